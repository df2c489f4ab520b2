"use strict";
/* Energies of the normal modes of small motions, over time. Of a chain these are the modal energies
 * of Fermi, Pasta, Ulam and Tsingou. M and K come from differences of the energy about rest. */
const PanelsModes = (() => {
  const MOST = 130;      /* coordinates: the eigenproblem is solved here */
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
    return coordinates.length > 1 && coordinates.length <= MOST && !(states || []).length
      && !(constraints || []).length && !(rotations || []).length
      && constants.some((c) => c.kind === "energy");
  }

  function modes(lab, body, tools) {
    const chart = Chart.make(body, { x: Text.axis("t", lab.model.time), y: "energy of a mode" });
    const key = Dom.h("span", { class: "key" });
    tools.append(key);
    let found = null;
    let made = null;
    let note = "";
    return {
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
        const { recent } = run;
        const every = Math.max(1, Math.floor(recent.size / 400));
        const t = [];
        const energies = found.map(() => []);
        for (let k = (recent.size - 1) % every; k < recent.size; k += every) {
          t.push(recent.get(k, 0));
          found.forEach(({ w2, row }, m) => {
            let [a, b] = [0, 0];
            for (let j = 0; j < row.length; j++) {
              a += row[j] * recent.get(k, 1 + j);
              b += row[j] * recent.get(k, 1 + row.length + j);
            }
            energies[m].push((b * b + w2 * a * a) / 2);
          });
        }
        const most = energies.map((list, m) => [Math.max(...list), m]).sort((a, b) => b[0] - a[0])
          .slice(0, SHOWN).map(([, m]) => m).sort((a, b) => a - b);
        const theme = Theme.now();
        const colours = [...theme.methods, theme.ink];
        chart.set(most.map((m, k) => ({ x: t, y: energies[m], colour: colours[k] })),
          { x: [t[0] || 0, Math.max(t[t.length - 1] || 0, (t[0] || 0) + lab.natural * 6)] });
        const text = most.map((m) => m + 1).join(",");
        if (key.dataset.modes !== text) {
          key.dataset.modes = text;
          Dom.fill(key, ...most.map((m, k) => {
            const mark = Dom.h("span", { class: "mode" }, String(m + 1));
            mark.style.borderColor = colours[k];
            return mark;
          }));
        }
      },
    };
  }

  return { modes, suits };
})();
