// Sliders, fields and the pointer.
let pending = false;

/** Redraws once before the next repaint, however many inputs came. */
function later(recompute) {
  if (recompute && frame.shares.length > 0) shown.mixed = null;
  if (pending) return;
  pending = true;
  requestAnimationFrame(() => {
    pending = false;
    now();
  });
}

/** Other light is seen in the mixed picture alone: a layer that was chosen gives way to it. */
function remix() {
  if (shown.layer !== MIXED) choose(MIXED);
  later(true);
}

function now() {
  if (!shown.mixed && frame.shares.length > 0) shown.mixed = recombine();
  byId("command").textContent = command();
  draw();
}

/** A slider and a field beside it for one number. `toSlider`, `fromSlider` bend the slider's scale. */
function pair(slider, field, { get, set, parse, write, toSlider, fromSlider }) {
  const sync = () => {
    slider.value = toSlider(get());
    field.value = write(get());
    slider.setAttribute("aria-valuetext", write(get()));
    field.setCustomValidity("");
  };
  slider.addEventListener("input", () => {
    set(fromSlider(Number(slider.value)));
    sync();
  });
  field.addEventListener("input", () => {
    const value = parse(field.value);
    field.setCustomValidity(value === null ? "not a usable number" : "");
    if (value === null) return;
    set(value);
    slider.value = toSlider(get());
  });
  field.addEventListener("change", sync);
  return sync;
}

const numberOf = (text, least) => (text.trim() !== "" && Number(text) >= least && Number.isFinite(Number(text)) ? Number(text) : null);
const syncs = [];

function controls() {
  const select = byId("layer");
  if (frame.shares.length > 0) select.append(make("option", { value: MIXED }, "mixed picture"));
  for (const [kind, name] of [["picture", "pictures, as rendered"], ["data", "data"]]) {
    const of = frame.layers.filter((layer) => (layer.kind === "picture") === (kind === "picture"));
    const options = of.map((layer) => make("option", { value: layer.name }, layer.name));
    if (options.length > 0) select.append(make("optgroup", { label: name }, ...options));
  }
  if (frame.shares.length === 0) shown.layer = frame.layers[0]?.name ?? MIXED;
  select.addEventListener("change", () => choose(select.value));
  const colours = byId("false-colour");
  colours.addEventListener("change", () => {
    shown.falseColour = colours.checked;
    later(false);
  });
  syncs.push(
    pair(byId("exposure"), byId("exposure-number"), {
      get: () => shown.exposure,
      set: (value) => {
        shown.exposure = value;
        later(false);
      },
      parse: (text) => numberOf(text, -200),
      write: (value) => String(Math.round(value * 100) / 100),
      toSlider: (value) => value,
      fromSlider: (value) => value,
    }),
  );
  for (const [index, group] of frame.groups.entries()) gainOf(group, `gain-${index}`);
  if (frame.shares.some((share) => share.split) && renderedContrast !== null) contrastControl();
  byId("mixture").disabled = frame.shares.length === 0;
  byId("unmixed").hidden = !frame.unmixed;
  byId("unmixed").textContent = frame.unmixed ? `Not mixed: ${frame.unmixed}` : "";
  byId("reset").addEventListener("click", () => {
    asRendered();
    shown.exposure = frame.exposure;
    syncs.forEach((sync) => sync());
    later(true);
  });
  syncs.forEach((sync) => sync());
}

/** Gains from 0 to 8 on the slider, 1 in its middle; any on the field. */
function gainOf(group, id) {
  const slider = make("input", { type: "range", min: "0", max: "2", step: "0.01", id });
  const field = make("input", { type: "number", min: "0", step: "any", id: `${id}-number`, ariaLabel: `Gain of ${group}, as a number` });
  const label = make("label", { htmlFor: id }, `Gain of ${group}`);
  byId("gains").append(make("div", { className: "row" }, label, slider, field));
  syncs.push(
    pair(slider, field, {
      get: () => mixture.gains[group],
      set: (value) => {
        mixture.gains[group] = value;
        remix();
      },
      parse: (text) => numberOf(text, 0),
      write: (value) => String(Number(value.toPrecision(4))),
      toSlider: (value) => Math.cbrt(value),
      fromSlider: (value) => Number((value ** 3).toPrecision(4)),
    }),
  );
}

/** The slider is the contrast's decimal logarithm; its end is infinite contrast. */
function contrastControl() {
  byId("contrast-row").hidden = false;
  syncs.push(
    pair(byId("contrast"), byId("contrast-number"), {
      get: () => mixture.contrast ?? renderedContrast,
      set: (value) => {
        mixture.contrast = value;
        remix();
      },
      parse: contrastOf,
      write: (value) => (value === Infinity ? "inf" : String(Number(value.toPrecision(5)))),
      toSlider: (value) => (value === Infinity ? 5.05 : Math.min(Math.log10(value), 5)),
      fromSlider: (value) => (value > 5 ? Infinity : Number((10 ** value).toPrecision(4))),
    }),
  );
}

/** Shows a layer, and marks it where it is named. */
function choose(layer) {
  shown.layer = layer;
  byId("layer").value = layer;
  document.querySelectorAll("button[data-layer]").forEach((button) => {
    button.setAttribute("aria-pressed", String(button.dataset.layer === layer));
  });
  later(false);
}

function pointer() {
  canvas.width = width;
  canvas.height = height;
  let kept = false;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    const place = (from, length, count) => Math.min(Math.max(Math.floor((from / length) * count), 0), count - 1);
    shown.pixel = [place(event.clientX - box.left, box.width, width), place(event.clientY - box.top, box.height, height)];
    read();
  };
  canvas.addEventListener("pointermove", (event) => kept || at(event));
  canvas.addEventListener("click", (event) => {
    kept = !kept;
    at(event);
  });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (event.key === "Escape") {
      kept = false;
      shown.pixel = null;
      read();
    }
    if (!step) return;
    event.preventDefault();
    kept = true;
    const by = event.shiftKey ? 10 : 1;
    const [x, y] = shown.pixel ?? [width >> 1, height >> 1];
    const inside = (value, count) => Math.min(Math.max(value, 0), count - 1);
    shown.pixel = [inside(x + by * step[0], width), inside(y + by * step[1], height)];
    read();
  });
}
