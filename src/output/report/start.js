async function start() {
  try {
    byId("subtitle").textContent = frame.subtitle;
    byId("reduced").hidden = frame.factor === 1;
    byId("reduced").textContent =
      `Shown at ${width} × ${height}: each pixel is the mean of ${frame.factor} × ${frame.factor} of the frame's ${frame.full[0]} × ${frame.full[1]}. Tables are of the whole frame.`;
    pathTable();
    metricTable();
    planTable();
    witnessTable();
    convergence();
    factTable();
    ledgers();
    planes = await Promise.all(frame.planes.map(unpack));
    asRendered();
    controls();
    pointer();
    now();
    if (location.hash === "#selftest") await selftest();
  } catch (error) {
    byId("fault").hidden = false;
    byId("fault").textContent = `The page could not be shown: ${error.message}`;
  }
}
start();
