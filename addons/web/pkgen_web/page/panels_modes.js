"use strict";
/* Energies of the normal modes of small oscillations, over time; for a chain, these are the modal
 * energies of Fermi, Pasta, Ulam and Tsingou. The mass and stiffness matrices are computed from
 * differences of the energy about the equilibrium. */
const PanelsModes = (() => {
  const MOST = 130; /* most coordinates, since the page solves the eigenproblem */
  const SHOWN = 5;

  function energyOf(lab) {
    const { engine } = lab;
    const { params } = lab.runs.start;
    if (engine.energy) return (q, v) => engine.energy(params, 0, q, v);
    const method = lab.model.method;
    return (q, v) => {
      const motion = engine.motion({ method, step: null, rtol: null, params, q, v, t: 0 });
      const e = motion.energy();
      motion.free();
      return e;
    };
  }

  function suits(model) {
    const { coordinates, states, constraints, rotations, constants } = model.description;
    return (
      coordinates.length > 1 &&
      coordinates.length <= MOST &&
      !(states || []).length &&
      !(constraints || []).length &&
      !(rotations || []).length &&
      constants.some((c) => c.kind === "energy")
    );
  }

  /* Energies of modes since the start of a run. When there are more than ROWS rows, every second
   * row is deleted. */
  const ROWS = 1400;
  const fresh = (run, n) => ({
    run,
    t: [],
    energies: Array.from({ length: n }, () => []),
    every: 0,
    next: -Infinity,
  });

  function energyAt(recent, k, { w2, row }) {
    let [a, b] = [0, 0];
    for (let j = 0; j < row.length; j++) {
      a += row[j] * recent.get(k, 1 + j);
      b += row[j] * recent.get(k, 1 + row.length + j);
    }
    return (b * b + w2 * a * a) / 2;
  }

  function gather(kept, recent, found) {
    let k = recent.size - 1;
    while (k > 0 && recent.get(k - 1, 0) >= kept.next) k--;
    for (; k < recent.size; k++) {
      const now = recent.get(k, 0);
      if (now < kept.next) continue;
      kept.t.push(now);
      found.forEach((mode, m) => kept.energies[m].push(energyAt(recent, k, mode)));
      if (kept.t.length > ROWS) {
        kept.t = kept.t.filter((_, i) => i % 2 === 0);
        kept.energies = kept.energies.map((list) => list.filter((_, i) => i % 2 === 0));
        kept.every = 2 * (kept.every || (now - kept.t[0]) / ROWS);
      }
      kept.next = now + kept.every + 1e-12 * Math.abs(now);
    }
  }

  function modes(lab, body, tools) {
    const chart = Chart.make(body, { x: Text.axis("t", lab.model.time), y: Text.axis("energy of a mode", lab.model.time && "J") });
    const key = Dom.h("span", { class: "key" });
    tools.append(key);
    let found = null;
    let made = null;
    let note = "";
    let kept = fresh(null, 0);
    return {
      chart,
      free: () => chart.free(),
      update(runs) {
        const { start } = lab.runs;
        if (made !== start) {
          made = start;
          found = null;
          note = "";
          try {
            const scale = Math.max(...start.q.map(Math.abs)) || 1;
            found = Numerics.modes(energyOf(lab), new Float64Array(lab.nq), Math.min(scale, 1));
          } catch (error) {
            note = String(error.message || error);
          }
          if (!found) note = note || "no rest at 0";
        }
        const run = runs.find((r) => r.index === 0) || runs[0];
        if (!found || !run) {
          Dom.say(key, note);
          chart.set([]);
          return;
        }
        if (kept.run !== run) kept = fresh(run, found.length);
        gather(kept, run.recent, found);
        const { t, energies } = kept;
        const most = energies
          .map((list, m) => [list.reduce((x, y) => Math.max(x, y), 0), m])
          .sort((a, b) => b[0] - a[0])
          .slice(0, SHOWN)
          .map(([, m]) => m)
          .sort((a, b) => a - b);
        const theme = Theme.now();
        const colours = [...theme.methods, theme.ink];
        chart.set(
          most.map((m, k) => ({
            x: [...t, run.t],
            y: [...energies[m], energyAt(run.recent, run.recent.size - 1, found[m])],
            colour: colours[k],
          })),
          { x: [t[0] || 0, Math.max(run.t, (t[0] || 0) + lab.natural * 6)] },
        );
        const text = most.map((m) => m + 1).join(",");
        if (key.dataset.modes !== text) {
          key.dataset.modes = text;
          Dom.fill(
            key,
            ...most.map((m, k) => {
              const mark = Dom.h("span", { class: "mode" }, String(m + 1));
              mark.style.borderColor = colours[k];
              return mark;
            }),
          );
        }
      },
    };
  }

  return { modes, suits };
})();
