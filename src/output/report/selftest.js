// With #selftest at the end of its address the page works itself and writes what it finds into the document; tests/report.rs
// compares that with the values of the program.
const violations = [];
document.addEventListener("securitypolicyviolation", (event) => violations.push(event.effectiveDirective));

async function selftest() {
  const luminances = () => {
    const picture = { kind: "picture", grey: false, data: shown.mixed };
    return Array.from({ length: pixels }, (_, at) => luminanceAt(picture, at));
  };
  const set = (id, value) => {
    byId(id).value = value;
    byId(id).dispatchEvent(new Event("input"));
    now();
  };
  const found = { mixtures: [] };
  for (const gain of ["0", "1", "2"]) {
    for (const contrast of [null, "1", "3", "inf"]) {
      asRendered();
      if (frame.groups.length > 0) set("gain-0-number", gain);
      if (contrast !== null) set("contrast-number", contrast);
      shown.mixed = null;
      now();
      found.mixtures.push({ gain: Number(gain), contrast, luminances: luminances(), command: byId("command").textContent });
    }
  }
  byId("reset").click();
  now();
  const press = (key) => {
    canvas.dispatchEvent(new KeyboardEvent("keydown", { key }));
    return shown.pixel;
  };
  const point = (type, x, y) => {
    const box = canvas.getBoundingClientRect();
    const [clientX, clientY] = [box.left + (box.width * (x + 0.5)) / width, box.top + (box.height * (y + 0.5)) / height];
    canvas.dispatchEvent(new PointerEvent(type, { clientX, clientY }));
    return shown.pixel;
  };
  found.pixel = press("ArrowRight");
  found.readout = byId("readout").textContent;
  // Let go, follow the pointer, keep a pixel while the pointer goes on, let go.
  found.pointed = [press("Escape"), point("pointermove", 1, 3), point("click", 2, 4), point("pointermove", 0, 0)];
  found.pointed.push(press("Escape"));
  const codes = () => Array.from(canvas.getContext("2d").getImageData(0, 0, width, height).data);
  found.codes = codes();
  byId("false-colour").click();
  now();
  found.falseCodes = codes();
  found.legend = Array.from(byId("labels").children, (label) => label.textContent);
  byId("false-colour").click();
  const button = document.querySelector("button[data-layer]");
  button?.click();
  now();
  found.clicked = [button?.dataset.layer ?? null, shown.layer, byId("layer").value, button?.getAttribute("aria-pressed") ?? null];
  found.layers = Object.fromEntries(frame.layers.map((layer) => [layer.name, Array.from(channels(layer.planes)[0], (value) => (Number.isFinite(value) ? value : null))]));
  found.texts = document.body.innerText;
  found.markup = ["img", "iframe", "link", "object"].map((name) => document.querySelectorAll(name).length);
  found.scripts = document.scripts.length;
  found.pwned = globalThis.pwned ?? null;
  found.fetched = await fetch("data:text/plain,x").then(() => true, () => false);
  await new Promise((done) => setTimeout(done, 50));
  found.violations = violations;
  document.body.append(make("pre", { id: "selftest" }, JSON.stringify(found)));
}
