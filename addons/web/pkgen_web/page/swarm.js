"use strict";
/* A swarm of motions, shown in a phase plane. They start at the starts that the scene gives, or on
 * a disc around the start of the model. The first members of the swarm are the boundary of the
 * disc; Hamiltonian motion preserves the area within it. */
const Swarm = (() => {
  const LOOP = 600;
  const FIXED = ["blanes_moan4", "yoshida4", "verlet", "rk4"];

  class Swarm_ {
    constructor(lab) {
      this.lab = lab;
      const { model } = lab;
      this.canvas = Dom.$("marks");
      this.cloud = Cloud.make(Dom.$("cloud"));
      this.x = model.list.find((e) => e.kind === "q") || null;
      this.asked = 10000;
      this.members = 0;
      this.share = 0.25;
      this.swarm = null;
      this.status = "";
      this.methods = model.applying.filter((m) => !m.adaptive).map((m) => m.name);
      this.method = FIXED.find((name) => this.methods.includes(name)) || this.methods[0] || null;
      this.area = NaN;
    }

    can() {
      return Boolean(this.x && this.method && this.lab.engine.swarm);
    }

    /* Returns the radii of the disc of starts, in q and in q'. The radius in q is proportional to
     * |q| at the start; if q is 0 there, to 1 radian or to a typical length. The radius in q' is
     * that in q times the natural angular frequency. */
    radii(start) {
      const size = (x, angle) => (Math.abs(x) > 1e-12 ? Math.abs(x) : angle ? 1 : 0);
      const { index } = this.x;
      const r = this.share * (size(start.q[index], this.x.periodic) || this.reach(start.q) || 1);
      const pace = (2 * Math.PI) / this.lab.natural;
      return [r, r * pace];
    }

    reach(q) {
      return Math.max(...q.map(Math.abs));
    }

    restart() {
      this.free();
      this.status = "";
      if (this.lab.settings.view !== "swarm" || !this.can() || this.lab.runs.error) return;
      const { engine, runs } = this.lab;
      const { start } = runs;
      const own = this.own();
      const table = own ? own.table : this.disc(start);
      this.members = table.values.length / table.columns.length;
      this.loop = own ? 0 : Math.min(LOOP, this.members);
      try {
        this.swarm = engine.swarm({
          ...(own || { method: this.method, step: this.step() }),
          params: start.params,
          q: start.q,
          v: start.v,
          inputs: start.inputs,
          table,
          members: this.members,
        });
        this.t = 0;
        this.box = null;
        this.area = NaN;
        this.first = this.measure();
      } catch (error) {
        this.status = String(error.message || error);
      }
    }

    /* Returns the method and the starts of a scene that is a swarm; null for other scenes. */
    own() {
      const { model, settings } = this.lab;
      const scene = model.sceneNamed.get(settings.scene);
      if (!scene || !scene.swarm || !scene.swarm.columns) return null;
      const columns = scene.swarm.columns.map((name) => model.byName.get(name));
      const known = model.methodNamed.get(scene.method);
      const method = known && known.applies ? scene.method : this.method;
      return {
        method,
        step: method === scene.method ? scene.step : this.step(),
        rtol: scene.rtol,
        table: { columns, values: scene.swarm.values },
      };
    }

    disc(start) {
      const { index } = this.x;
      const [rx, ry] = this.radii(start);
      const values = new Float64Array(2 * this.asked);
      const loop = Math.min(LOOP, this.asked);
      /* The golden angle distributes points evenly over the disc. */
      for (let k = 0; k < this.asked; k++) {
        const inside = k >= loop;
        const angle = inside ? k * 2.399963229728653 : (2 * Math.PI * k) / loop;
        const radius = inside ? Math.sqrt((k - loop + 0.5) / (this.asked - loop)) : 1;
        values[2 * k] = start.q[index] + rx * radius * Math.cos(angle);
        values[2 * k + 1] = start.v[index] + ry * radius * Math.sin(angle);
      }
      const columns = ["q", "v"].map((kind) => ({ kind, index }));
      return { columns, values };
    }

    step() {
      return this.stepAsked || this.lab.natural / 64;
    }

    /* Called once per frame; the steps do not depend on the times of frames. */
    advance(t) {
      if (!this.swarm || this.status || t === this.t) return;
      this.t = t;
      try {
        const word = this.swarm.advance(t);
        if (typeof word === "string" && word) this.status = word;
      } catch (error) {
        this.status = String(error.message || error);
      }
    }

    /* Returns the area within the loop of the first members, in the planes (q, p), summed over all
     * coordinates. If the model has no momenta p, returns the area in the shown plane (q, q')
     * only. */
    measure() {
      const { engine, runs, nq } = this.lab;
      const { swarm, loop } = this;
      if (!loop) return NaN;
      const { width } = swarm;
      const states = swarm.states(loop);
      const column = (j) => Float64Array.from({ length: loop }, (_, k) => states[k * width + j]);
      if (!engine.momenta) {
        this.area = Numerics.area(column(nq + this.x.index), column(this.x.index));
        return this.area;
      }
      const p = Array.from({ length: nq }, () => new Float64Array(loop));
      for (let k = 0; k < loop; k++) {
        const row = states.subarray(k * width, (k + 1) * width);
        const momenta = engine.momenta(
          runs.start.params,
          this.lab.runs.t,
          row.slice(0, nq),
          row.slice(nq),
        );
        for (let j = 0; j < nq; j++) p[j][k] = momenta[j];
      }
      this.area = 0;
      for (let j = 0; j < nq; j++) this.area += Numerics.area(p[j], column(j));
      return this.area;
    }

    /* The range of the axes grows with the swarm and does not shrink. */
    frame([x0, x1, y0, y1]) {
      const now = [Chart.padded([x0, x1], 0.12), Chart.padded([y0, y1], 0.12)];
      if (!this.box) this.box = now;
      else
        this.box = this.box.map(([lo, hi], k) => [
          Math.min(lo, now[k][0]),
          Math.max(hi, now[k][1]),
        ]);
    }

    draw(width, height) {
      Dom.fitCanvas(this.canvas, width, height);
      const g = Dom.pen(this.canvas);
      const ratio = this.canvas.width / width;
      const theme = Theme.now();
      g.setTransform(1, 0, 0, 1, 0, 0);
      g.clearRect(0, 0, this.canvas.width, this.canvas.height);
      if (!this.swarm) return;
      const { members, lab } = this;
      const { box, points } = this.swarm.points(this.x.index, lab.engine.n + this.x.index);
      this.frame(box);
      const [[x0, x1], [y0, y1]] = this.box;
      g.setTransform(ratio, 0, 0, ratio, 0, 0);
      const [left, right, top, bottom] = [74, width - 20, 56, height - 44];
      const X = (x) => left + ((x - x0) / (x1 - x0)) * (right - left);
      const Y = (y) => bottom - ((y - y0) / (y1 - y0)) * (bottom - top);
      const { coordinate } = this.x;
      Axes.draw(g, {
        left,
        right,
        top,
        bottom,
        X,
        Y,
        x: [x0, x1],
        y: [y0, y1],
        below: Text.axis(this.x.name, this.x.unit),
        beside: Text.axis(coordinate.rate, coordinate.rate_unit),
      });
      const [a, c] = [(right - left) / (x1 - x0), (top - bottom) / (y1 - y0)];
      this.cloud.draw(g, points, this.loop, {
        ...{ a, b: left - a * x0, c, d: bottom - c * y0, width, height },
        size: members > 20000 ? 1 : members < 3000 ? 3 : 1.4,
        colour: theme.methods[0],
        alpha: 0.6,
      });
      g.strokeStyle = theme.methods[1];
      g.lineWidth = 1.6;
      g.beginPath();
      for (let k = 0; k < this.loop; k++) g.lineTo(X(points[2 * k]), Y(points[2 * k + 1]));
      g.closePath();
      g.stroke();
      this.drawn = [{ kind: "swarm", points: [[X(points[0]), Y(points[1])]], members }];
    }

    free() {
      if (this.swarm && this.swarm.free) this.swarm.free();
      this.swarm = null;
    }
  }

  return { make: (lab) => new Swarm_(lab) };
})();
