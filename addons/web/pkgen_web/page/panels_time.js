"use strict";
/* Panels over time: drifts, coordinates, distance from the reference run. */
const PanelsTime = (() => {
  const WINDOW = 1200; /* shown samples of coordinates */

  /* The deviation of constants of the motion from their start; a menu selects one of several. */
  function drift(lab, body, tools) {
    const { constants } = lab.model.description;
    let which = 0;
    const chart = Chart.make(body, { x: Text.axis("t", lab.model.time), y: "", log: true });
    if (constants.length > 1)
      tools.append(
        Dom.select(
          constants.map((c, k) => [k, Text.plain(c.label || c.name)]),
          0,
          (k) => {
            which = Number(k);
            lab.dirty = true;
          },
          { "aria-label": "Which constant" },
        ),
      );
    return {
      chart,
      free: () => chart.free(),
      update(runs) {
        const c = constants[which];
        chart.options.y = `drift of ${Text.plain(c.label || c.name)}, relative`;
        chart.set(
          runs.map((run) => ({
            ...run.drifts.line(which, run.sizes[which] || 1),
            colour: Theme.ofRun(run),
            dash: Theme.dashOf(run),
          })),
          { x: whole(runs, lab) },
        );
      },
    };
  }

  function distance(lab, body) {
    const chart = Chart.make(body, {
      x: Text.axis("t", lab.model.time),
      y: "distance from the reference",
      log: true,
    });
    const column = lab.model.description.constants.length;
    return {
      chart,
      free: () => chart.free(),
      update(runs) {
        chart.set(
          runs
            .filter((run) => run.index >= 0)
            .map((run) => ({
              ...run.drifts.line(column),
              colour: Theme.ofRun(run),
              dash: Theme.dashOf(run),
            })),
          { x: whole(runs, lab) },
        );
      },
    };
  }

  const whole = (runs, lab) => [0, Math.max(lab.natural, ...runs.map((run) => run.t || 0))];

  /* One quantity over the last samples, in each run's colour. */
  function time(lab, body, tools) {
    const quantities = quantitiesOf(lab.model);
    let which = lab.first || quantities[0];
    const chart = Chart.make(body, { x: Text.axis("t", lab.model.time), y: "" });
    if (quantities.length > 1)
      tools.append(
        Dom.select(
          quantities.map((e) => [e.key, Text.plain(e.name)]),
          which.key,
          (key) => {
            which = lab.model.byKey.get(key);
            lab.dirty = true;
          },
          { "aria-label": "Which quantity" },
        ),
      );
    return {
      chart,
      free: () => chart.free(),
      update(runs) {
        chart.options.y = Text.axis(which.name, which.unit);
        const lines = runs.map((run) => {
          const from = Math.max(0, run.recent.size - WINDOW);
          return {
            x: run.recent.column(0, from),
            y: run.recent.column(columnOf(lab, which), from),
            colour: Theme.ofRun(run),
            dash: Theme.dashOf(run),
            head: run.index >= 0,
          };
        });
        const last = Math.max(...runs.map((run) => run.t || 0));
        const first = Math.min(...lines.map((l) => (l.x.length ? l.x[0] : 0)));
        chart.set(lines, { x: [first, Math.max(last, first + lab.natural * 6)] });
      },
    };
  }

  const quantitiesOf = Model.quantities;
  const columnOf = (lab, entry) =>
    1 + entry.index + { q: 0, v: lab.nq, o: lab.nq + lab.nv }[entry.kind];

  return { drift, time, distance, quantitiesOf, columnOf };
})();
