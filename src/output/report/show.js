// From cd/m² to the screen: exposure, sRGB, false colours, and what a pixel holds.
const MIXED = "";
const canvas = byId("canvas");
const shown = { layer: MIXED, falseColour: false, exposure: frame.exposure, mixed: null, pixel: null };

const layerOf = (name) => frame.layers.find((layer) => layer.name === name);

function current() {
  if (shown.layer === MIXED && shown.mixed) return { kind: "picture", grey: false, data: shown.mixed };
  const layer = layerOf(shown.layer) ?? frame.layers[0];
  return { kind: layer.kind, grey: layer.grey, data: channels(layer.planes) };
}

const luminanceAt = ({ grey, data }, at) =>
  grey
    ? frame.white * data[0][at]
    : frame.weights[0] * data[0][at] + frame.weights[1] * data[1][at] + frame.weights[2] * data[2][at];

/** The 8-bit sRGB code of a linear value. IEC 61966-2-1. */
function code(linear) {
  const value = Math.min(Math.max(linear, 0), 1);
  return Math.round(255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055));
}

/** The ends of the scale: the largest value rounded up to 1, 2 or 5 times a power of ten, and some decades below. */
function falseScale(largest) {
  let high = 1;
  if (largest > 0) {
    const power = 10 ** Math.floor(Math.log10(largest));
    high = [1, 2, 5, 10].map((step) => step * power).find((round) => round >= largest * (1 - 1e-12)) ?? largest;
  }
  return [high / 10 ** frame.falseColour.decades, high];
}

function falseColour(value, [low, high]) {
  if (!Number.isFinite(value)) return [255, 0, 255];
  const place = value <= low ? 0 : Math.min(Math.max(Math.log(value / low) / Math.log(high / low), 0), 1);
  const stops = frame.falseColour.stops;
  const after = stops.findIndex(([stop], index) => index > 0 && place <= stop);
  const [[from, a], [to, b]] = [stops[after - 1], stops[after]];
  return a.map((start, c) => Math.round(start + ((place - from) / (to - from)) * (b[c] - start)));
}

function largestLuminance(picture) {
  let largest = 0;
  for (let at = 0; at < pixels; at++) {
    const value = luminanceAt(picture, at);
    if (value > largest && value < Infinity) largest = value;
  }
  return largest;
}

/** A function from a pixel to its three codes, for the kind of the layer: as `eyebox view` shows it. */
function painter(picture) {
  const [r, g, b] = picture.data;
  const m = frame.toRec709;
  if (picture.kind === "picture" && shown.falseColour) {
    const ends = falseScale(largestLuminance(picture));
    legend(ends);
    return (at) => falseColour(luminanceAt(picture, at), ends);
  }
  legend(null);
  if (picture.kind === "picture" || picture.kind === "fraction") {
    const scale = picture.kind === "picture" ? 2 ** shown.exposure / frame.displayWhite : 1;
    const plain = picture.grey || picture.kind === "fraction";
    const once = r === g && g === b && m.every((row) => Math.abs(row[0] + row[1] + row[2] - 1) < 1e-12);
    return (at) => {
      if (!Number.isFinite(r[at] + g[at] + b[at])) return [255, 0, 255];
      if (once) return Array(3).fill(code(r[at] * scale));
      const colour = [r[at], g[at], b[at]].map((value) => value * scale);
      return (plain ? colour : m.map((row) => row[0] * colour[0] + row[1] * colour[1] + row[2] * colour[2])).map(code);
    };
  }
  if (picture.kind === "vector") {
    let longest = 0;
    for (let at = 0; at < pixels; at++) longest = Math.max(longest, Math.hypot(r[at], g[at], b[at]) || 0);
    return (at) =>
      r[at] === 0 && g[at] === 0 && b[at] === 0
        ? [0, 0, 0]
        : [r[at], g[at], b[at]].map((value) => Math.round(255 * ((value / longest) * 0.5 + 0.5)));
  }
  let [low, high] = [Infinity, -Infinity];
  for (const value of r) {
    if (value !== 0 && Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
  }
  const grey = (value) => {
    if (low < 0) return (value / Math.max(-low, high)) * 0.5 + 0.5;
    if (value === 0) return 0;
    return high > low ? 1 - (0.92 * (value - low)) / (high - low) : 1;
  };
  return (at) => (Number.isFinite(r[at]) ? Array(3).fill(Math.round(255 * grey(r[at]))) : [255, 0, 255]);
}

function legend(ends) {
  byId("legend").hidden = !ends;
  if (!ends) return;
  const colours = frame.falseColour.stops.map(([at, rgb]) => `rgb(${rgb.join(",")}) ${100 * at}%`);
  byId("bar").style.background = `linear-gradient(to right, ${colours.join(",")})`;
  const decades = frame.falseColour.decades;
  const labels = Array.from({ length: decades + 1 }, (_, i) => said(ends[1] / 10 ** (decades - i)));
  const spans = labels.map((text, i) => make("span", {}, i === 0 ? `${text} cd/m²` : text));
  spans.forEach((span, i) => (span.style.left = `${(100 * i) / decades}%`));
  byId("labels").replaceChildren(...spans);
}

function draw() {
  const context = canvas.getContext("2d");
  const image = context.createImageData(width, height);
  const paint = painter(current());
  for (let at = 0; at < pixels; at++) {
    const [r, g, b] = paint(at);
    image.data.set([r, g, b, 255], 4 * at);
  }
  context.putImageData(image, 0, 0);
  canvas.setAttribute("aria-label", shown.layer === MIXED ? "The mixed picture" : `Layer ${shown.layer}`);
  read();
}

/** What a pixel of the shown layer holds, in words. */
function holds(picture, at) {
  const values = picture.data.map((channel) => said(channel[at]));
  switch (picture.kind) {
    case "picture":
      // Equal channels are a luminance.
      return `${said(luminanceAt(picture, at), 5)} cd/m²` + (new Set(values).size === 1 ? "" : ` (channels ${values.join(", ")})`);
    case "fraction":
    case "vector":
      return values.join(", ");
    default:
      return values[0];
  }
}

function read() {
  const lines = [];
  const marker = byId("marker");
  marker.style.display = shown.pixel ? "block" : "none";
  if (shown.pixel) {
    const [x, y] = shown.pixel;
    const at = y * width + x;
    const block = frame.factor > 1 ? `, ${frame.factor} × ${frame.factor} pixels` : "";
    lines.push(["pixel", `(${x * frame.factor}, ${y * frame.factor})${block}`]);
    if (shown.mixed) lines.push(["mixed picture", holds({ kind: "picture", grey: false, data: shown.mixed }, at)]);
    if (shown.layer !== MIXED || !shown.mixed) lines.push([shown.layer || "picture", holds(current(), at)]);
    const share = (length, of) => `${(100 * length) / of}%`;
    Object.assign(marker.style, {
      left: share(x, width), top: share(y, height), width: share(1, width), height: share(1, height),
    });
  } else {
    lines.push(["pixel", "none chosen"]);
  }
  byId("readout").replaceChildren(...lines.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
}
