// Relative error against passes, both logarithmic, and a line of slope −½ through the last point.
function convergence() {
  const place = byId("convergence");
  const points = frame.convergence;
  if (points.length === 0) {
    place.append(make("p", { className: "note" }, "The header does not say how many passes were made, or the frame has no stderr."));
    return;
  }
  const [wide, high, left, right, top, bottom] = [640, 340, 64, 16, 14, 46];
  const last = points[points.length - 1];
  const decades = (values) => [Math.floor(Math.log10(Math.min(...values))), Math.ceil(Math.log10(Math.max(...values)) + 1e-9)];
  const [x0, x1] = decades([1, ...points.map(({ passes }) => passes)]);
  const [y0, y1] = decades(points.map(({ error }) => error));
  const x = (passes) => left + ((Math.log10(passes) - x0) / Math.max(x1 - x0, 1)) * (wide - left - right);
  const y = (error) => high - bottom - ((Math.log10(error) - y0) / Math.max(y1 - y0, 1)) * (high - top - bottom);
  const svg = (name, attributes, ...children) => {
    const element = document.createElementNS("http:" + "//www.w3.org/2000/svg", name);
    Object.entries(attributes).forEach(([key, value]) => element.setAttribute(key, value));
    element.append(...children);
    return element;
  };
  const drawing = svg("svg", {
    viewBox: `0 0 ${wide} ${high}`, role: "img",
    "aria-label": `Relative error against passes: ${percent(last.error)} after ${last.passes} passes. The table below has the points.`,
  });
  for (let decade = x0; decade <= x1; decade++) {
    const at = x(10 ** decade);
    drawing.append(svg("line", { class: "axis", x1: at, x2: at, y1: top, y2: high - bottom }));
    drawing.append(svg("text", { x: at, y: high - bottom + 18, "text-anchor": "middle" }, String(10 ** decade)));
  }
  for (let decade = y0; decade <= y1; decade++) {
    const at = y(10 ** decade);
    drawing.append(svg("line", { class: "axis", x1: left, x2: wide - right, y1: at, y2: at }));
    drawing.append(svg("text", { x: left - 8, y: at + 4, "text-anchor": "end" }, `${said(100 * 10 ** decade, 2)} %`));
  }
  drawing.append(svg("text", { x: (left + wide - right) / 2, y: high - 8, "text-anchor": "middle" }, "passes"));
  // The line, cut where it leaves the axes.
  const errorAt = (passes) => last.error * Math.sqrt(last.passes / passes);
  const passesAt = (error) => last.passes * (last.error / error) ** 2;
  const [from, to] = [Math.max(10 ** x0, passesAt(10 ** y1)), Math.min(10 ** x1, passesAt(10 ** y0))];
  drawing.append(svg("line", { class: "slope", x1: x(from), y1: y(errorAt(from)), x2: x(to), y2: y(errorAt(to)) }));
  drawing.append(svg("polyline", { class: "measured", points: points.map(({ passes, error }) => `${x(passes)},${y(error)}`).join(" ") }));
  for (const { passes, error } of points) drawing.append(svg("circle", { class: "dot", cx: x(passes), cy: y(error), r: 3.5 }));
  const rows = points.map(({ passes, error, from: source }) => [passes, percent(error), source]);
  place.append(
    drawing,
    make("p", { className: "note" }, "Dots: relative error of the whole picture. Dashed: one over the root of the passes, through the last dot."),
    make("details", {}, make("summary", {}, `The points (${points.length})`), table(["passes", "relative error", "from"], rows, ["", "number", "words"])),
  );
}
