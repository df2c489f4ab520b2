"use strict";
/* Draws a scene in space. It draws the same shapes as PlaneView, and records the positions of
 * bodies on the canvas like PlaneView. */
const SpaceView = (() => {
  class View {
    constructor(canvas, camera) {
      this.canvas = canvas;
      this.camera = camera;
      this.painter = new Gl.Painter(canvas);
      this.drawn = [];
    }

    draw(scene) {
      const { width, height } = scene;
      Dom.fitCanvas(this.canvas, width, height);
      const theme = Theme.now();
      const { painter: p, camera } = this;
      p.begin(camera, Theme.rgb(theme.stage));
      this.drawn = [];
      const size = camera.distance * Math.tan(camera.angle / 2);
      this.unit = size;
      const rods = first_(scene).filter((shape) => shape.kind === "rod").length;
      this.thick = 0.012 * Math.min(1, 10 / Math.max(1, rods));
      const layers = scene.runs;
      const first = first_(scene);
      const ground = first.find((shape) => shape.kind === "ground");
      this.floor(scene, ground, Theme.rgb(theme.soft));
      if (scene.levels) this.levels(scene.levels);
      for (const { made, trails, style, run } of layers) {
        this.style = style;
        let count = 0;
        for (const shape of made) {
          const colour = Theme.rgb(style.of(shape, count));
          if (shape.kind === "bob" || shape.kind === "body") count++;
          this.shape(shape, colour, run);
        }
        for (const trail of trails) this.trail(trail, style);
      }
      p.end();
    }

    /* Draws a grid of round spacing on the ground, or below all shapes; it fades outwards. */
    floor(scene, ground, colour) {
      const { painter: p, camera } = this;
      const low = scene.box && scene.box.lo[2] <= scene.box.hi[2] ? scene.box.lo[2] : -1;
      const axis = ground ? "xyz".indexOf(ground.axis) : 2;
      const height = ground ? ground.height : low - 0.02 * this.unit;
      const step = Ranges.nice(this.unit / 6);
      const [i, j] = axis === 2 ? [0, 1] : axis === 1 ? [0, 2] : [1, 2];
      const middle = [i, j].map((k) => Math.round(camera.target[k] / step));
      const n = 10;
      const strength = ground ? 0.55 : 0.3;
      for (let a = -n; a <= n; a++) {
        for (const [along, across] of [
          [i, j],
          [j, i],
        ]) {
          const m = along === i ? middle : [middle[1], middle[0]];
          const points = [];
          for (let b = -n; b <= n; b++) {
            const at = [0, 0, 0];
            at[axis] = height;
            at[along] = (m[0] + b) * step;
            at[across] = (m[1] + a) * step;
            points.push(at);
          }
          p.line(points, 1, colour, (k) => strength * Math.max(0, 1 - Math.hypot(a, k - n) / n));
        }
      }
      if (ground) this.drawn.push({ kind: "ground", name: "", run: 0, points: [] });
    }

    levels(contours) {
      const colour = Theme.rgb(Theme.now().soft);
      for (const segments of contours.lines)
        for (const [a, b] of segments)
          this.painter.line(
            [
              [...a, 0],
              [...b, 0],
            ],
            1,
            colour,
            () => 0.4,
          );
    }

    note(shape, points, run) {
      this.drawn.push({
        kind: shape.kind,
        name: shape.name || shape.label || "",
        run: run.index,
        points: points.map((p) => this.camera.project(p).slice(0, 2)),
      });
    }

    shape(shape, colour, run) {
      const { painter: p, style, unit } = this;
      const metal = Theme.rgb(style.metal);
      const alpha = style.alpha;
      switch (shape.kind) {
        case "rod":
          p.put("tube", Solids.along(shape.from, shape.to, unit * this.thick), metal, alpha);
          this.note(shape, [shape.from, shape.to], run);
          break;
        case "line":
          p.line([shape.from, shape.to], 1.6, Theme.rgb(style.thin), () => alpha);
          this.note(shape, [shape.from, shape.to], run);
          break;
        case "spring":
          p.line(helix(shape, unit * 0.04), 2.2, metal, () => alpha);
          this.note(shape, [shape.from, shape.to], run);
          break;
        case "arrow":
          this.arrow(shape, Theme.rgb(style.arrow), alpha);
          this.note(shape, [shape.from, shape.to], run);
          break;
        case "bob": {
          const r = (shape.radius || unit * 0.045) * style.size;
          p.put(
            "ball",
            Solids.turned([1, 0, 0, 0, 1, 0, 0, 0, 1], [r, r, r], shape.at),
            colour,
            alpha,
          );
          this.note(shape, [shape.at], run);
          break;
        }
        case "circle":
          p.line(Outlines.circle(shape), 1.6, Theme.rgb(style.thin), () => 0.8 * alpha);
          this.note(shape, [shape.at], run);
          break;
        case "curve": {
          p.line(shape.points, 2.2, metal, () => alpha);
          this.note(shape, shape.points, run);
          break;
        }
        case "body": {
          const [mesh, place] = Solids.place(shape);
          p.put(mesh, place, colour, alpha, mesh === "box" ? 0 : 1);
          this.note(shape, [shape.at], run);
          break;
        }
      }
    }

    arrow({ from, to }, colour, alpha) {
      const d = from.map((x, k) => to[k] - x);
      const length = Math.hypot(...d);
      if (!(length > 0)) return;
      const head = Math.min(length * 0.4, this.unit * 0.09);
      const neck = from.map((x, k) => x + d[k] * (1 - head / length));
      this.painter.put("tube", Solids.along(from, neck, this.unit * 0.009), colour, alpha);
      this.painter.put("tip", Solids.along(neck, to, head * 0.34), colour, alpha);
    }

    trail({ trail, colour }, style) {
      const n = trail.size;
      if (n < 2) return;
      const skip = Math.max(1, Math.floor(n / 900));
      const points = [];
      for (let k = (n - 1) % skip; k < n; k += skip)
        points.push([trail.get(k, 1), trail.get(k, 2), trail.get(k, 3)]);
      const fades = Number.isFinite(trail.lasting);
      this.painter.line(
        points,
        style.trailWidth,
        Theme.rgb(colour || style.trail),
        (k) => style.alpha * (fades ? 0.08 + (0.8 * k) / points.length : 0.65),
      );
      this.drawn.push({
        kind: "trail",
        name: "",
        run: 0,
        points: [this.camera.project(points[points.length - 1]).slice(0, 2)],
      });
    }
  }

  const first_ = ({ runs }) => (runs.length ? runs[runs.length - 1].made : []);

  function helix({ from, to, turns }, radius) {
    const d = from.map((x, k) => to[k] - x);
    const z = Camera.unit(d);
    const u = Camera.unit(Camera.cross(z, Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));
    const v = Camera.cross(z, u);
    const points = [from];
    for (let k = 0; k <= turns * 14; k++) {
      const s = k / (turns * 14);
      const [c, e] = [Math.cos(2 * Math.PI * turns * s), Math.sin(2 * Math.PI * turns * s)].map(
        (x) => x * radius,
      );
      points.push(from.map((x, i) => x + d[i] * (0.08 + 0.84 * s) + c * u[i] + e * v[i]));
    }
    points.push(to);
    return points;
  }

  return { View };
})();
