"use strict";
/* A short trial run before the first frame. It determines the natural speed (simulated time per
 * second), and the box to which the camera is fitted. */
const Trial = (() => {
  const POINTS = 240;
  const BUDGET = 1200; /* ms */
  /* fast vibrations are played at least at this fraction of their real speed */
  const SHAKING = 0.5;
  const SWING = 2.4; /* s: duration of one oscillation on the screen */
  const SHOW = 45; /* s: duration of a whole scene on the screen */
  const SWINGS = 4; /* most oscillations per second on the screen */

  /* Counts the turning points (local extremes) in each of the first n columns. */
  function counts(rows, n) {
    const found = [];
    for (let k = 0; k < n; k++) {
      let count = 0;
      for (let i = 2; i < rows.length; i++)
        if ((rows[i][k] - rows[i - 1][k]) * (rows[i - 1][k] - rows[i - 2][k]) < 0) count++;
      found.push(count);
    }
    return found;
  }

  /* Returns the mean of the three largest nonzero counts of turning points. */
  function turns(rows, n) {
    const top = counts(rows, n)
      .sort((a, b) => b - a)
      .slice(0, 3)
      .filter((c) => c > 0);
    return top.length ? top.reduce((a, b) => a + b, 0) / top.length : 0;
  }

  function run(lab, start, method, span, deadline) {
    const motion = lab.engine.motion({
      method,
      step: (lab.model.methodNamed.get(method) || {}).adaptive ? null : span / POINTS,
      rtol: null,
      params: start.params,
      q: start.q,
      v: start.v,
      t: 0,
      inputs: start.inputs,
    });
    const rows = [];
    const box = Shapes.box();
    try {
      for (let i = 0; i <= POINTS; i++) {
        if (i > 0 && motion.advance((span * i) / POINTS)) break;
        rows.push([...motion.q, ...motion.v]);
        Shapes.grow(box, lab.model.shapes, motion.outputs());
        if (performance.now() > deadline) break;
      }
    } finally {
      motion.free();
    }
    return { rows, box, span: rows.length > 1 ? (span * (rows.length - 1)) / POINTS : 0 };
  }

  function round125(x) {
    const power = 10 ** Math.floor(Math.log10(x));
    const head = x / power;
    return (head < 1.5 ? 1 : head < 3.5 ? 2 : head < 7.5 ? 5 : 10) * power;
  }

  /* Returns the coordinate that panels show first. It is the first coordinate that has turning
   * points and a range of at least a fifth of the largest range; if there is none, the first of any
   * coordinates with such a range; otherwise a rate. */
  function moving(lab, rows) {
    const spans = rows[0].map((_, k) => {
      const column = rows.map((row) => row[k]).filter(Number.isFinite);
      return (
        column.reduce((a, b) => Math.max(a, b), -Infinity) -
        column.reduce((a, b) => Math.min(a, b), Infinity)
      );
    });
    const back = counts(rows, spans.length).map((count) => count > 0);
    const pick = (from, to, kind, those) => {
      const part = spans.slice(from, to).map((span, k) => (those(from + k) ? span : 0));
      const most = Math.max(...part, 0);
      const k = part.findIndex((span) => span > 0.2 * most);
      return most > 1e-9 && k >= 0 ? lab.model.byKey.get(kind + k) : null;
    };
    return (
      pick(0, lab.nq, "q", (k) => back[k]) ||
      pick(0, lab.nq, "q", () => true) ||
      pick(lab.nq, spans.length, "v", () => true)
    );
  }

  /* Whether a scene runs the model with its default values. */
  const plain = (scene) =>
    !scene.swarm && !Object.keys(scene.set).length && !Object.keys(scene.start).length;

  function look(lab, start) {
    const asked = lab.model.sceneNamed.get(lab.settings.scene);
    const scene = asked || lab.model.description.scenes.find(plain);
    const until = asked && asked.until > 0 ? asked.until : null;
    const deadline = performance.now() + BUDGET;
    const box = Shapes.box();
    Shapes.grow(box, lab.model.shapes, lab.engine.outputs(start.params, 0, start.q, start.v));
    let span = Math.min(10, until || 10);
    let period = null;
    let found = null;
    for (let k = 0; k < 6 && performance.now() < deadline; k++) {
      try {
        const next = run(lab, start, lab.model.reference(), span, deadline);
        if (next.rows.length < 3) break;
        found = next;
      } catch (error) {
        break;
      }
      const count = turns(found.rows, start.q.length || found.rows[0].length);
      if (count > 0) period = (2 * found.span) / count;
      if (count > POINTS / 4) span /= 6;
      else if (count < 2 && found.span > 0.99 * span && (!until || span < until)) span *= 6;
      else break;
    }
    if (found) Shapes.join(box, found.box);
    let speed = 1;
    const real = lab.model.time === "s" && period > 0.3 && period < 8;
    if (period !== null && !(real && !asked)) {
      const all = Math.min(((scene && scene.until) || 0) / SHOW, SWINGS * period);
      /* Fast vibrations are played no slower than SHAKING, so that one sees the slow motion that
       * they cause. */
      const shaking = lab.model.time === "s" && period > 0.02 && period <= 0.3;
      speed = round125(Math.max(real ? 1 : period / SWING, shaking ? SHAKING : 0, all));
    }
    if (period === null && until) speed = round125(until / 20);
    return { speed, box, period, moving: found ? moving(lab, found.rows) : null };
  }

  return { look };
})();
