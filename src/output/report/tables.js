// What is known besides pictures, as tables.

/** Rows of cells; a cell is a text, a number or an element. The first column names the row. */
function table(head, rows, kinds) {
  const cell = (name, value, index) => {
    const element = make(name, {}, value instanceof Node ? value : String(value));
    if (kinds[index]) element.className = kinds[index];
    return element;
  };
  const top = make("tr", {}, ...head.map((text, index) => Object.assign(cell("th", text, index), { scope: "col" })));
  const body = rows.map((row) => {
    const cells = row.map((value, index) => cell(index === 0 ? "th" : "td", value, index));
    if (cells[0]) cells[0].scope = "row";
    return make("tr", {}, ...cells);
  });
  return make("table", {}, make("thead", {}, top), make("tbody", {}, ...body));
}

const percent = (share) => (share === null || share === undefined ? "–" : `${said(100 * share, 3)} %`);

function pathTable() {
  byId("paths-note").textContent = frame.pathsNote;
  const rows = frame.paths.map((path) => {
    let name = path.name;
    if (path.layer !== null) {
      name = make("button", { type: "button" }, path.name);
      name.dataset.layer = path.layer;
      name.setAttribute("aria-pressed", "false");
      name.addEventListener("click", () => choose(path.layer));
    }
    return [name, percent(path.share), said(path.amount), path.said];
  });
  const table_ = table(["path", "share", frame.pathsUnit, ""], rows, ["", "number", "number", "words"]);
  byId("paths").append(rows.length > 0 ? table_ : make("p", { className: "note" }, "None in the header, and no shares to list."));
}

function metricTable() {
  if (frame.unmeasured) {
    byId("metrics").append(make("p", { className: "note" }, `Not measured: ${frame.unmeasured}`));
    return;
  }
  const rows = frame.metrics.map(({ name, value, unit, interval, note }) => [
    name,
    value === null ? "–" : said(value, 5),
    unit,
    interval ? `${said(interval[0], 5)} to ${said(interval[1], 5)}` : "–",
    note,
  ]);
  byId("metrics").append(table(["quantity", "value", "unit", "95 %", "how, or why not"], rows, ["", "number", "unit", "number", "words"]));
}

function planTable() {
  const rows = frame.plan.map(([what, because]) => [what, because]);
  byId("plan").append(
    rows.length > 0 ? table(["decision", "because"], rows, ["", "words"]) : make("p", { className: "note" }, "The header holds no plan."),
  );
}

function witnessTable() {
  byId("witness-note").textContent = frame.witness.note;
  const rows = frame.witness.rows.map(({ name, ratio, error, looks, off }) => [
    name,
    ratio === null ? "–" : said(ratio, 4),
    error === null ? "–" : said(error, 2),
    String(looks),
    off,
  ]);
  if (rows.length > 0) {
    byId("witness").append(
      table(["light", "of what brute force found", "±", "looks", "off by more than chance"], rows, ["", "number", "number", "number", "words"]),
    );
  }
}

function factTable() {
  byId("facts").append(table(["", ""], frame.facts, ["", "words"]));
  byId("facts").querySelector("thead")?.remove();
}

function ledgers() {
  const place = byId("ledger");
  for (const ledger of frame.ledgers) {
    const rows = ledger.rows.map(({ name, amount, share }) => [name, said(amount, 5), percent(share)]);
    place.append(
      make("h3", {}, ledger.estimator),
      make("p", { className: "note" }, ledger.note),
      make("div", { className: "scroll" }, table(["", ledger.unit, "of what was emitted"], rows, ["", "number", "number"])),
    );
    if (ledger.parts.length > 0) {
      const parts = ledger.parts.map(({ name, amount, share }) => [name, said(amount, 5), percent(share)]);
      place.append(
        make("details", {}, make("summary", {}, `Absorbed, part by part (${parts.length})`),
          make("div", { className: "scroll" }, table(["part", ledger.unit, "of what was emitted"], parts, ["", "number", "number"]))),
      );
    }
  }
  if (frame.ledgers.length === 0) place.append(make("p", { className: "note" }, "The header holds no ledger."));
}
