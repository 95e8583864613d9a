// As much of a browser as the page of `eyebox report` uses, for an engine that knows the language alone. There is no layout and
// no policy. Nodes take no properties but those below, and whatever else the page comes to use throws: a shim that stays silent
// would pass a page that does not work.
// The host gives `inflate`, from a list of the bytes of a zlib stream to the list of what is in it, and calls what this file's
// value holds.
"use strict";
(() => {
  const missing = (what) => {
    throw new TypeError(`dom.js has no ${what}`);
  };

  class Event {
    constructor(type, { bubbles = false, cancelable = false } = {}) {
      Object.assign(this, { type, bubbles, cancelable, target: null, defaultPrevented: false });
    }
    preventDefault() {
      this.defaultPrevented = this.cancelable;
    }
  }
  class MouseEvent extends Event {
    constructor(type, options = {}) {
      super(type, options);
      const { clientX = 0, clientY = 0, shiftKey = false } = options;
      Object.assign(this, { clientX, clientY, shiftKey });
    }
  }
  class PointerEvent extends MouseEvent {}
  class KeyboardEvent extends Event {
    constructor(type, options = {}) {
      super(type, options);
      const { key = "", shiftKey = false } = options;
      Object.assign(this, { key, shiftKey });
    }
  }

  class Node {
    parentNode = null;
    childNodes = [];
    listeners = [];

    addEventListener(type, listener) {
      this.listeners.push([type, listener]);
    }
    /** Listeners that throw end the page, where a browser would go on. */
    dispatchEvent(event) {
      event.target = this;
      for (let node = this; node; node = event.bubbles ? node.parentNode : null) {
        node.listeners.forEach(([type, listener]) => type === event.type && listener.call(node, event));
      }
      return !event.defaultPrevented;
    }
    append(...children) {
      for (const child of children) {
        const node = child instanceof Node ? child : new Text(child);
        node.remove();
        node.parentNode = this;
        this.childNodes.push(node);
      }
    }
    replaceChildren(...children) {
      [...this.childNodes].forEach((child) => child.remove());
      this.append(...children);
    }
    remove() {
      const siblings = this.parentNode?.childNodes;
      siblings?.splice(siblings.indexOf(this), 1);
      this.parentNode = null;
    }
    get children() {
      return this.childNodes.filter((child) => child instanceof Element);
    }
    get textContent() {
      return this.childNodes.map((child) => child.textContent).join("");
    }
    set textContent(text) {
      this.replaceChildren(...(text === "" ? [] : [String(text)]));
    }
    /** All elements below, in the order of the document. */
    *below() {
      for (const child of this.children) {
        yield child;
        yield* child.below();
      }
    }
    /** `name` and `name[attribute]`. */
    querySelectorAll(selector) {
      const [, name, attribute] = /^([a-z]+)(?:\[([a-z-]+)\])?$/.exec(selector) ?? missing(`selector ${selector}`);
      return [...this.below()].filter((at) => at.localName === name && (!attribute || at.attributes.has(attribute)));
    }
    querySelector(selector) {
      return this.querySelectorAll(selector)[0] ?? null;
    }
  }

  class Text extends Node {
    constructor(text) {
      super();
      this.data = String(text);
      Object.preventExtensions(this);
    }
    get textContent() {
      return this.data;
    }
  }

  const dashed = (name) => name.replace(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`);

  class Element extends Node {
    attributes = new Map();
    style = Object.seal({ display: "", left: "", top: "", width: "", height: "", background: "" });

    constructor(localName) {
      super();
      this.localName = localName;
    }
    getAttribute(name) {
      return this.attributes.get(name) ?? null;
    }
    setAttribute(name, value) {
      this.attributes.set(name, String(value));
    }
    get dataset() {
      return new Proxy({}, {
        get: (_, name) => this.attributes.get(`data-${dashed(name)}`),
        set: (_, name, value) => this.attributes.set(`data-${dashed(name)}`, String(value)) !== null,
      });
    }
    /** Texts of what is shown; without styles, a hidden element is one that says so. */
    get innerText() {
      if (this.hidden || ["script", "style", "noscript"].includes(this.localName)) return "";
      const shown = this.childNodes.filter((child) => this.localName !== "details" || child.localName === "summary");
      return shown.map((child) => child.innerText ?? child.textContent).join("");
    }
    /** A control that is off, itself or with its fieldset, cannot be clicked. */
    get isOff() {
      for (let at = this; at instanceof Element; at = at.parentNode) {
        if (at.disabled && (at === this || at.localName === "fieldset")) return true;
      }
      return false;
    }
    click() {
      if (!this.isOff) this.dispatchEvent(new PointerEvent("click", { bubbles: true, cancelable: true }));
    }
    getBoundingClientRect() {
      return missing(`layout of <${this.localName}>`);
    }
  }
  const reflected = {
    id: "id", className: "class", htmlFor: "for", type: "type", min: "min", max: "max", step: "step", scope: "scope",
    label: "label", ariaLabel: "aria-label",
  };
  for (const [property, attribute] of Object.entries(reflected)) {
    Object.defineProperty(Element.prototype, property, {
      get() {
        return this.getAttribute(attribute) ?? "";
      },
      set(value) {
        this.setAttribute(attribute, value);
      },
    });
  }
  for (const name of ["hidden", "disabled"]) {
    Object.defineProperty(Element.prototype, name, {
      get() {
        return this.attributes.has(name);
      },
      set(value) {
        if (value) this.setAttribute(name, "");
        else this.attributes.delete(name);
      },
    });
  }

  /** Fields change what is put into them. HTML Standard, "value sanitization algorithm". */
  class Input extends Element {
    raw = null;
    checked = false;
    validity = "";

    get value() {
      const text = this.raw ?? this.getAttribute("value") ?? "";
      const number = /^-?(\d+|\d*\.\d+)(e[+-]?\d+)?$/i.test(text) ? Number(text) : NaN;
      if (this.type === "number") return Number.isFinite(number) ? text : "";
      if (this.type !== "range") return text;
      const [least, most] = [Number(this.min || 0), Number(this.max || 100)];
      const step = this.step === "any" ? 0 : Number(this.step || 1);
      const inside = Math.min(Math.max(Number.isFinite(number) ? number : (least + most) / 2, least), most);
      return String(step > 0 ? Number((least + Math.round((inside - least) / step) * step).toPrecision(12)) : inside);
    }
    set value(text) {
      this.raw = String(text);
    }
    setCustomValidity(why) {
      this.validity = String(why);
    }
    click() {
      if (this.isOff) return;
      if (this.type === "checkbox") this.checked = !this.checked;
      super.click();
      for (const type of this.type === "checkbox" ? ["input", "change"] : []) {
        this.dispatchEvent(new Event(type, { bubbles: true }));
      }
    }
  }

  class Option extends Element {
    get value() {
      return this.getAttribute("value") ?? this.textContent;
    }
    set value(text) {
      this.setAttribute("value", text);
    }
  }

  class Select extends Element {
    chosen = undefined;

    /** At first the first option; none after a value that no option has. */
    get value() {
      const options = this.querySelectorAll("option");
      const option = this.chosen === undefined || (this.chosen && !options.includes(this.chosen)) ? options[0] : this.chosen;
      return option?.value ?? "";
    }
    set value(text) {
      this.chosen = this.querySelectorAll("option").find((option) => option.value === String(text)) ?? null;
    }
  }

  class ImageData {
    constructor(width, height) {
      Object.assign(this, { width, height, data: new Uint8ClampedArray(4 * width * height) });
      Object.freeze(this);
    }
  }

  class Canvas extends Element {
    size = { width: 300, height: 150 };
    bitmap = new ImageData(300, 150);

    get width() {
      return this.size.width;
    }
    set width(value) {
      this.size.width = value;
      this.bitmap = new ImageData(this.width, this.height);
    }
    get height() {
      return this.size.height;
    }
    set height(value) {
      this.size.height = value;
      this.bitmap = new ImageData(this.width, this.height);
    }
    getContext(kind) {
      if (kind !== "2d") missing(`context ${kind}`);
      const copy = (from, to, left, top) => {
        for (let y = 0; y < from.height; y++) {
          for (let x = 0; x < from.width; x++) {
            if (x + left < 0 || x + left >= to.width || y + top < 0 || y + top >= to.height) continue;
            const at = 4 * (y * from.width + x);
            to.data.set(from.data.subarray(at, at + 4), 4 * ((y + top) * to.width + x + left));
          }
        }
        return to;
      };
      return Object.freeze({
        createImageData: (width, height) => new ImageData(width, height),
        putImageData: (image, left, top) => void copy(image, this.bitmap, left, top),
        getImageData: (left, top, width, height) => copy(this.bitmap, new ImageData(width, height), -left, -top),
      });
    }
    /** Somewhere, and larger than its pixels: what takes one for the other is off. */
    getBoundingClientRect() {
      return { left: 40, top: 30, width: 7 * this.width, height: 7 * this.height };
    }
  }

  const kinds = { canvas: Canvas, input: Input, option: Option, select: Select };
  const element = (name) => Object.preventExtensions(new (kinds[name] ?? Element)(name));

  class Document extends Node {
    createElement(name) {
      return element(name);
    }
    createElementNS(_, name) {
      return element(name);
    }
    getElementById(id) {
      for (const at of this.below()) if (at.id === id) return at;
      return null;
    }
    get body() {
      return this.querySelector("body");
    }
    get scripts() {
      return this.querySelectorAll("script");
    }
  }
  const document = new Document();

  const entities = { lt: "<", gt: ">", amp: "&", quot: '"', "#39": "'" };
  const plain = (text) => text.replace(/&([a-z]+|#\d+);/g, (_, name) => entities[name] ?? missing(`entity &${name};`));

  /** Tags, attributes, texts of a page, into the document. A name that broke out would become an element here too. */
  function parse(html) {
    const tag =
      /<!--[^]*?-->|<![^>]*>|<\/([a-z][^\s/>]*)[^>]*>|<([a-z]\w*)((?:\s+[^\s=>]+(?:=(?:"[^"]*"|'[^']*'|[^\s"'>]+))?)*)\s*>/gi;
    const open = [document];
    const top = () => open[open.length - 1];
    const text = (from, to) => {
      if (from < to) top().append(plain(html.slice(from, to)));
    };
    let done = 0;
    for (let found = tag.exec(html); found; found = tag.exec(html)) {
      text(done, found.index);
      done = tag.lastIndex;
      const [, ended, begun, attributes] = found;
      if (ended) {
        const at = open.findLastIndex((one) => one.localName === ended.toLowerCase());
        if (at > 0) open.length = at;
      }
      if (!begun) continue;
      const made = element(begun.toLowerCase());
      for (const [, name, ...values] of attributes.matchAll(/([^\s=]+)(?:=(?:"([^"]*)"|'([^']*)'|([^\s"'>]+)))?/g)) {
        made.setAttribute(name.toLowerCase(), plain(values.find((value) => value !== undefined) ?? ""));
      }
      top().append(made);
      if (["meta", "input", "img", "link", "br"].includes(made.localName)) continue;
      open.push(made);
      if (!["script", "style"].includes(made.localName)) continue;
      // Nothing ends these but their own end.
      const end = html.slice(done).search(new RegExp(`</${made.localName}[\\s/>]`, "i"));
      if (end > 0) made.append(html.slice(done, done + end));
      tag.lastIndex = done += Math.max(end, 0);
    }
    text(done, html.length);
  }

  function atob(text) {
    const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let [out, bits, count] = ["", 0, 0];
    for (const letter of text.replace(/={1,2}$/, "")) {
      const six = letters.indexOf(letter);
      if (six < 0) throw new Error(`no base64: ${letter}`);
      bits = ((bits << 6) | six) & 0xffff;
      count += 6;
      if (count < 8) continue;
      count -= 8;
      out += String.fromCharCode((bits >> count) & 0xff);
    }
    return out;
  }

  /** All bytes are at hand: a stream is a list of them. */
  class Blob {
    constructor(parts) {
      this.bytes = Uint8Array.from(parts.flatMap((part) => [...part]));
    }
    stream() {
      return { bytes: this.bytes, pipeThrough: (through) => ({ bytes: through.apply(this.bytes) }) };
    }
  }
  const { inflate } = globalThis;
  class DecompressionStream {
    constructor(format) {
      if (format !== "deflate") missing(`format ${format}`);
    }
    apply(bytes) {
      return Uint8Array.from(inflate([...bytes]));
    }
  }
  class Response {
    constructor(stream) {
      this.stream = stream;
    }
    async arrayBuffer() {
      return this.stream.bytes.buffer;
    }
  }

  // Repaints come before timers, timers in the order of their times; nothing waits.
  let frames = [];
  let timers = [];
  let now = 0;
  const requestAnimationFrame = (callback) => frames.push(callback);
  const setTimeout = (callback, after = 0) => timers.push({ at: now + after, callback });
  const fetch = () => Promise.reject(new TypeError("nothing may be loaded"));
  const location = Object.freeze({ hash: "#selftest" });

  delete globalThis.inflate;
  Object.assign(globalThis, {
    Blob, DecompressionStream, Event, KeyboardEvent, MouseEvent, Node, PointerEvent, Response,
    atob, document, fetch, location, requestAnimationFrame, setTimeout,
  });

  return {
    /** The scripts of a page, to be run in this order. */
    open(html) {
      parse(html);
      return document.scripts.filter((script) => !script.type).map((script) => script.textContent);
    },
    /** Runs what waits next; false if nothing does. */
    turn() {
      const due = frames;
      frames = [];
      due.forEach((callback) => callback(now));
      if (due.length > 0) return true;
      timers.sort((a, b) => a.at - b.at);
      const timer = timers.shift();
      if (timer) now = timer.at;
      timer?.callback();
      return timer !== undefined;
    },
    /** What an element says; null where there is none, or it is hidden. */
    said(id) {
      const at = document.getElementById(id);
      return at && !at.hidden ? at.textContent : null;
    },
  };
})();
