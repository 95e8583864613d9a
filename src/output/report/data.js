"use strict";
// What the page knows, and its pictures. A plane is a PNG without filters, one grey byte a pixel: below each other the first,
// second and third byte of each value as a 32-bit float; the fourth is 0.
const frame = JSON.parse(document.getElementById("frame").textContent);
const [width, height] = frame.size;
const pixels = width * height;
const black = new Float32Array(pixels);
let planes = [];

const byId = (id) => document.getElementById(id);

/** An element with properties and children; texts become text nodes, never markup. */
function make(name, properties = {}, ...children) {
  const element = document.createElement(name);
  Object.assign(element, properties);
  element.append(...children);
  return element;
}

async function unpack(base64) {
  const text = atob(base64);
  const file = Uint8Array.from({ length: text.length }, (_, at) => text.charCodeAt(at));
  const view = new DataView(file.buffer);
  const parts = [];
  for (let at = 8; at + 12 <= file.length; at += 12 + view.getUint32(at)) {
    const kind = String.fromCharCode(...file.subarray(at + 4, at + 8));
    if (kind === "IDAT") parts.push(file.subarray(at + 8, at + 8 + view.getUint32(at)));
  }
  const stream = new Blob(parts).stream().pipeThrough(new DecompressionStream("deflate"));
  const rows = new Uint8Array(await new Response(stream).arrayBuffer());
  const step = width + 1;
  if (rows.length !== 3 * height * step) throw new Error("a plane has another size than the picture");
  const values = new Float32Array(pixels);
  const bits = new Uint32Array(values.buffer);
  for (let byte = 0; byte < 3; byte++) {
    for (let y = 0; y < height; y++) {
      const row = (byte * height + y) * step;
      if (rows[row] !== 0) throw new Error("a plane is filtered");
      for (let x = 0; x < width; x++) bits[y * width + x] |= rows[row + 1 + x] << (24 - 8 * byte);
    }
  }
  return values;
}

/** The three channels of a picture; a plane that is 0 everywhere is not stored. */
const channels = (indices) => indices.map((index) => (index < 0 ? black : planes[index]));

/** 0.0123, 12.3, 1.23e+7. */
function said(value, digits = 4) {
  if (value === null || value === undefined) return "–";
  if (value === 0 || !Number.isFinite(value)) return String(value);
  const size = Math.abs(value);
  return size < 1e-3 || size >= 1e6 ? value.toExponential(digits - 1) : String(Number(value.toPrecision(digits)));
}
