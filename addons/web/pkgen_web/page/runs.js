"use strict";
/* The runs shown: up to four methods, and the reference. All start together and are integrated to
 * the same times; a run that fails keeps its last state, and its status says why. */
const Runs = (() => {
  const SECTION_POINTS = 20000;

  /* Returns the start according to the settings: {params, q, v} or {error}. */
  function given(engine, model, settings) {
    const params = engine.defaults().params.slice().fill(NaN);
    const scene = Settings.ofScene(model, settings.scene);
    const values = new Map([...scene, ...settings.values]);
    for (const [key, value] of values) {
      const entry = model.byKey.get(key);
      if (entry && entry.kind === "p") params[entry.index] = value;
    }
    let all;
    try {
      all = engine.given(params);
      const why = engine.prepare(all.params);
      if (why) return { error: why };
    } catch (error) {
      return { error: String(error.message || error) };
    }
    for (const [key, value] of values) {
      const entry = model.byKey.get(key);
      if (entry && "qv".includes(entry.kind)) all[entry.kind][entry.index] = value;
    }
    all.inputs = Float64Array.from(
      model.description.inputs || [],
      (_, k) => values.get("u" + k) || 0,
    );
    turn(model, settings, all.v);
    /* values that the scene or the user has set; other values are computed by the model */
    all.given = values;
    return all;
  }

  /* Rotates the initial attitudes by rotation vectors in space: keys r0x, r0y, r0z. */
  function turn(model, settings, v) {
    (model.description.rotations || []).forEach((rotation, k) => {
      const turned = ["x", "y", "z"].map((axis) => settings.values.get(`r${k}${axis}`) || 0);
      const angle = Math.hypot(...turned);
      if (angle === 0) return;
      const at = rotation.quaternion.map((name) => model.byName.get(name)?.index);
      if (at.includes(undefined)) return;
      const s = Math.sin(angle / 2) / angle;
      const [a, b, c, d] = [Math.cos(angle / 2), ...turned.map((x) => x * s)];
      const [e, f, g, h] = at.map((index) => v[index]);
      [
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
      ].forEach((x, i) => {
        v[at[i]] = x;
      });
    });
  }

  class Run {
    constructor(lab, spec, start, index) {
      const { engine, model } = lab;
      this.lab = lab;
      this.spec = spec;
      this.index = index; /* index of its colour; −1 is the reference */
      this.status = "";
      this.motion = engine.motion({
        method: spec.method,
        step: lab.stepOf(spec),
        rtol: spec.rtol ?? lab.rtol,
        params: start.params,
        q: start.q,
        v: start.v,
        t: 0,
        inputs: start.inputs,
      });
      this.params = start.params;
      this.seen = model.outputs.map((o) => o.index);
      const width = 1 + start.q.length + start.v.length + this.seen.length;
      const rows = Math.max(256, Math.min(6000, Math.floor(1.5e6 / width)));
      this.recent = new History.Recent(width, rows);
      this.row = new Float64Array(width);
      this.drifts = new History.Whole(model.description.constants.length + 1);
      this.trails = model.shapes
        .filter((shape) => shape.kind === "trail")
        .map((shape) => ({
          shape,
          trail: new History.Trail(
            Shapes.value(shape.lasting ?? Infinity, this.motion.outputs()) ?? Infinity,
          ),
        }));
      this.sections = model.description.events.map(() => ({ t: [], states: [] }));
      this.coming = [];
      this.start = null;
      this.sample(model, null);
    }

    /* Records the state that the run has after it is integrated to the next time. */
    sample(model, reference) {
      const { motion } = this;
      this.t = motion.t;
      this.q = motion.q;
      this.v = motion.v;
      this.out = motion.outputs();
      this.constants = motion.constants();
      if (!this.start) this.start = this.constants.slice();
      this.row[0] = this.t;
      this.row.set(this.q, 1);
      this.row.set(this.v, 1 + this.q.length);
      this.seen.forEach((index, k) => {
        this.row[1 + this.q.length + this.v.length + k] = this.out[index];
      });
      this.recent.push(this.row);
      this.size(model);
      const drifts = Array.from(this.constants, (c, k) => Math.abs(c - this.start[k]));
      drifts.push(reference ? distance(this, reference.at(this.t)) : NaN);
      this.drifts.push(this.t, drifts);
      for (const { shape, trail } of this.trails)
        trail.add(this.t, Shapes.point(shape.at, this.out));
      /* The last step may end after the time that is shown; events in it are shown when that time
       * comes. */
      this.coming.push(...motion.events());
      while (this.coming.length && this.coming[0].t <= this.t) this.cross(this.coming.shift());
    }

    /* Updates the scale of each drift, to which the drift is relative. The scale is the value of
     * the constant at the start. Since that may vanish, a larger magnitude is taken if there is
     * one: for the energy |v·p|/2, where p are the momenta; for a momentum the largest momentum of
     * the same unit; for a claim the largest constant of the same unit. */
    size(model) {
      const { constants, coordinates } = model.description;
      const { engine } = this.lab;
      if (!this.sizes) this.sizes = Array.from(this.start, Math.abs);
      const p =
        engine.momenta && constants.some((c) => c.kind !== "claim")
          ? engine.momenta(this.params, this.t, this.q, this.v)
          : null;
      constants.forEach((c, k) => {
        let other = 0;
        if (c.kind === "energy" && p)
          other = Math.abs(this.v.reduce((s, v, i) => s + (v * p[i] || 0), 0)) / 2;
        else if (c.kind === "momentum" && p) {
          for (const q of coordinates)
            if (q.momentum_unit === c.unit) other = Math.max(other, Math.abs(p[q.index]) || 0);
        }
        constants.forEach((d, j) => {
          if (c.kind === "claim" && d.unit === c.unit)
            other = Math.max(other, Math.abs(this.start[j]));
        });
        if (other > this.sizes[k]) this.sizes[k] = other;
      });
    }

    cross({ event, t, q, v }) {
      const section = this.sections[event];
      if (!section || section.t.length >= SECTION_POINTS) return;
      section.t.push(t);
      section.states.push(q ? [Array.from(q), Array.from(v)] : this.between(t));
    }

    /* Returns the coordinates q at time t, which is near the last sample. Samples of fixed-step
     * methods need not be at t, and are interpolated. */
    at(t) {
      return t === this.t ? this.q : this.between(t)[0];
    }

    /* Interpolates between the last two samples: cubic for q, linear for first-order variables. */
    between(t) {
      const { recent } = this;
      const [a, b] = [Math.max(0, recent.size - 2), recent.size - 1];
      const [ta, tb] = [recent.get(a, 0), recent.get(b, 0)];
      const h = tb - ta;
      const s = h > 0 ? (t - ta) / h : 1;
      const n = this.q.length;
      const q = Array.from({ length: n }, (_, k) => {
        const [qa, qb] = [recent.get(a, 1 + k), recent.get(b, 1 + k)];
        const [va, vb] = [recent.get(a, 1 + n + k), recent.get(b, 1 + n + k)];
        const [p, r] = [s * s * (3 - 2 * s), s * (1 - s)];
        return qa + (qb - qa) * p + h * r * ((1 - s) * va - s * vb);
      });
      const v = Array.from({ length: this.v.length }, (_, k) => {
        const [va, vb] = [recent.get(a, 1 + n + k), recent.get(b, 1 + n + k)];
        if (k >= n || !(h > 0)) return va * (1 - s) + vb * s;
        const slope = (recent.get(b, 1 + k) - recent.get(a, 1 + k)) / h;
        return slope * 6 * s * (1 - s) + (1 - s) * (1 - 3 * s) * va + s * (3 * s - 2) * vb;
      });
      return [q, v];
    }

    advance(t) {
      if (this.status) return;
      try {
        this.status = this.motion.advance(t) || "";
      } catch (error) {
        this.status = String(error.message || error);
      }
    }

    free() {
      this.motion.free();
    }
  }

  function distance(run, reference) {
    let sum = 0;
    let size = 0;
    for (let k = 0; k < run.q.length; k++) {
      sum += (run.q[k] - reference[k]) ** 2;
      size += reference[k] ** 2;
    }
    return Math.sqrt(sum / run.q.length) / Math.max(1, Math.sqrt(size / run.q.length));
  }

  /* The runs of all methods, their reference run, the largest distance from it, and the time. A
     method that refuses to start has a message in place of a run. */
  class Runs_ {
    constructor(lab) {
      this.lab = lab;
      this.list = [];
      this.reference = null;
      this.error = "";
      this.t = 0;
    }

    all() {
      return this.reference ? [...this.list, this.reference] : this.list;
    }

    restart() {
      const { engine, model, settings } = this.lab;
      this.free();
      this.t = 0;
      this.start = given(engine, model, settings);
      this.error = this.start.error || "";
      if (this.error) return;
      const begin = (spec, index) => {
        try {
          return new Run(this.lab, spec, this.start, index);
        } catch (error) {
          return {
            spec,
            index,
            refused: String(error.message || error),
            status: String(error.message || error),
            free() {},
          };
        }
      };
      this.list = settings.methods.map(begin);
      if (settings.reference) {
        const run = begin({ method: model.reference(), step: null, rtol: 1e-14 }, -1);
        this.reference = run.refused ? null : run;
      }
      const refused = this.list.filter((run) => run.refused);
      if (refused.length === this.list.length && refused.length) this.error = refused[0].refused;
    }

    alive() {
      return this.all().filter((run) => !run.refused && !run.status);
    }

    /* Integrates all runs to time t, the reference first, since distances are measured from it. */
    advance(t) {
      this.t = t;
      const { model } = this.lab;
      if (this.reference && !this.reference.status) {
        this.reference.advance(t);
        this.reference.sample(model, null);
      }
      for (const run of this.list) {
        if (run.refused || run.status) continue;
        run.advance(t);
        run.sample(model, this.reference && !this.reference.status ? this.reference : null);
      }
      /* If all runs have ended, the time is that of the longest. */
      if (!this.alive().length)
        this.t = Math.max(...this.all().map((run) => (run.refused ? 0 : run.t)));
    }

    free() {
      for (const run of this.all()) run.free();
      this.list = [];
      this.reference = null;
    }
  }

  return {
    given,
    make: (lab) => new Runs_(lab),
    one: (lab, spec, start) => new Run(lab, spec, start, 0),
  };
})();
