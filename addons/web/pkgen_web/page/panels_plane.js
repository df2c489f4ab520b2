"use strict";
/* Panels of two quantities: phase plane and Poincaré section; and the spectrum. */
const PanelsPlane = (() => {
  const { quantitiesOf, columnOf } = PanelsTime;
  const menu = (list, value, onchange, label) =>
    Dom.select(
      list.map((e) => [e.key, Text.plain(e.name)]),
      value.key,
      onchange,
      { "aria-label": label },
    );

  /* Angles are reduced to [−π, π]. */
  const TURN = 2 * Math.PI;
  const wrap = (x) => x - TURN * Math.round(x / TURN);
  const folded = (entry, list) => (entry.periodic ? list.map(wrap) : list);

  /* Interrupts a curve where its angle jumps from π to −π. */
  function gaps(entry, x, y) {
    if (!entry.periodic) return [x, y];
    for (let k = 1; k < x.length; k++) if (Math.abs(x[k] - x[k - 1]) > Math.PI) y[k - 1] = NaN;
    return [x, y];
  }

  function phase(lab, body, tools) {
    const list = quantitiesOf(lab.model);
    let x = lab.first || list[0];
    let y = list.find((e) => e.kind === "v" && e.index === x.index && e !== x) || list[1] || x;
    const chart = Chart.make(body, { x: "", y: "" });
    if (list.length > 2)
      tools.append(
        menu(
          list,
          y,
          (key) => {
            y = lab.model.byKey.get(key);
            lab.dirty = true;
          },
          "Upwards",
        ),
        "over",
        menu(
          list,
          x,
          (key) => {
            x = lab.model.byKey.get(key);
            lab.dirty = true;
          },
          "To the right",
        ),
      );
    return {
      free: () => chart.free(),
      update(runs) {
        chart.options.x = Text.axis(x.name, x.unit);
        chart.options.y = Text.axis(y.name, y.unit);
        chart.set(
          runs.map((run) => {
            const from = Math.max(0, run.recent.size - 3000);
            const [xs, ys] = gaps(
              x,
              folded(x, run.recent.column(columnOf(lab, x), from)),
              run.recent.column(columnOf(lab, y), from),
            );
            return { x: xs, y: ys, colour: Theme.ofRun(run), head: run.index >= 0, width: 1.2 };
          }),
          {
            x: Chart.padded(
              Chart.extent(
                runs.map((run) =>
                  folded(
                    x,
                    run.recent.column(columnOf(lab, x), Math.max(0, run.recent.size - 3000)),
                  ),
                ),
              ),
              0.06,
            ),
          },
        );
      },
    };
  }

  /* Draws the states at which an event occurs as points (a Poincaré section). The button "Fill"
   * continues the integration beyond the current time to find more points, for a few milliseconds
   * per update of the panel. */
  function section(lab, body, tools) {
    const events = lab.model.description.events.filter((e) => !e.hidden);
    const list = quantitiesOf(lab.model).filter((e) => e.kind !== "o");
    let event = (events.find((e) => !e.stop) || events[0]).index;
    let x = list.find((e) => e.kind === "q" && e.index === Math.min(1, lab.nq - 1)) || list[0];
    let y = list.find((e) => e.kind === "v" && e.index === x.index) || list[0];
    const chart = Chart.make(body, { x: "", y: "" });
    const again = () => {
      lab.dirty = true;
    };
    if (events.length > 1)
      tools.append(
        Dom.select(
          events.map((e) => [e.index, Text.plain(e.name)]),
          event,
          (k) => {
            event = Number(k);
            again();
          },
          { "aria-label": "Which event", class: "yields" },
        ),
      );
    tools.append(
      menu(
        list,
        y,
        (key) => {
          y = lab.model.byKey.get(key);
          again();
        },
        "Upwards",
      ),
      menu(
        list,
        x,
        (key) => {
          x = lab.model.byKey.get(key);
          again();
        },
        "To the right",
      ),
      Dom.h(
        "button",
        {
          type: "button",
          class: "quiet small-button",
          title: "Run ahead for more points",
          onclick: () => {
            fill = !fill;
            again();
          },
        },
        "Fill",
      ),
    );
    let fill = false;
    const ahead = Ahead.make(lab);
    const read = (entry, states) =>
      folded(
        entry,
        states.map(([q, v]) => (entry.kind === "q" ? q : v)[entry.index]),
      );
    return {
      free() {
        ahead.free();
        chart.free();
      },
      update(runs) {
        chart.options.x = Text.axis(x.name, x.unit);
        chart.options.y = Text.axis(y.name, y.unit);
        const shown = runs
          .filter((run) => run.index >= 0)
          .map((run) => [run, run.sections[event].states]);
        if (fill && shown.length) {
          if (ahead.more(event, 24)) setTimeout(again, 0);
          if (ahead.run) shown[0] = [shown[0][0], ahead.run.sections[event].states];
        }
        chart.set(
          shown.map(([run, states]) => ({
            x: read(x, states),
            y: read(y, states),
            colour: Theme.ofRun(run),
            points: states.length > 400 ? 1.6 : 2.6,
          })),
          { x: Chart.padded(Chart.extent(shown.map(([, states]) => read(x, states))), 0.08) },
        );
      },
    };
  }

  function spectrum(lab, body, tools) {
    const list = quantitiesOf(lab.model);
    let which = lab.first || list[0];
    const chart = Chart.make(body, {
      x: lab.model.time ? "frequency [Hz]" : "frequency",
      y: "",
      log: true,
    });
    if (list.length > 1)
      tools.append(
        menu(
          list,
          which,
          (key) => {
            which = lab.model.byKey.get(key);
            lab.dirty = true;
          },
          "Which quantity",
        ),
      );
    return {
      free: () => chart.free(),
      update(runs) {
        chart.options.y = "amplitude of " + Text.axis(which.name, which.unit);
        const lines = [];
        let most = 0;
        for (const run of runs) {
          const t = run.recent.column(0);
          const found = Numerics.spectrum(t, run.recent.column(columnOf(lab, which)));
          if (!found) continue;
          const top = Math.max(...found.a);
          /* The frequency axis ends after the last amplitude above 1/1000 of the highest. */
          let end = found.a.length - 1;
          while (end > 16 && found.a[end] < 1e-3 * top) end--;
          most = Math.max(most, found.f[Math.min(found.f.length - 1, Math.round(end * 1.25))]);
          lines.push({
            x: found.f,
            y: found.a,
            colour: Theme.ofRun(run),
            dash: Theme.dashOf(run),
            width: 1.2,
          });
        }
        chart.set(lines, { x: [0, most || 1] });
      },
    };
  }

  return { phase, section, spectrum };
})();
