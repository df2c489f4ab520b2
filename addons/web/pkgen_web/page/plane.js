"use strict";
/* Draws a plane scene on a 2D canvas. Each of several runs has one colour; the mechanism of a
 * single run is dark, with coloured bodies. */
const PlaneView = (() => {
  const BOB = 9; /* pixels: default radius */
  const TAIL = 28; /* number of pieces of a trail; older pieces are fainter */

  class View {
    constructor(canvas, camera) {
      this.canvas = canvas;
      this.camera = camera;
      this.drawn = [];
    }

    /* scene: {width, height, runs: [{run, made, trails, style}], levels, unit} */
    draw(scene) {
      const { width, height } = scene;
      const g = (this.g = Dom.blank(this.canvas, width, height));
      g.lineJoin = "round";
      g.lineCap = "round";
      this.drawn = [];
      this.grid(width, height);
      if (scene.levels) scene.levels.draw(g, this.camera);
      const layers = scene.runs;
      const first = layers.length ? layers[layers.length - 1].made : [];
      for (const shape of first) if (shape.kind === "ground") this.ground(shape);
      for (const { trails, style } of layers) for (const trail of trails) this.trail(trail, style);
      for (const { made, style, run } of layers) {
        this.style = style;
        g.globalAlpha = style.alpha;
        let count = 0;
        for (const shape of made) {
          const colour = style.of(shape, count);
          if (shape.kind === "bob" || shape.kind === "body") count++;
          this.shape(shape, colour, run);
        }
        g.globalAlpha = 1;
      }
    }

    px(p) {
      return this.camera.project(p);
    }

    note(shape, points, run) {
      this.drawn.push({
        kind: shape.kind,
        name: shape.name || shape.label || "",
        run: run.index,
        points: points.map((p) => [p[0], p[1]]),
      });
    }

    /* Draws a faint grid with a round spacing. */
    grid(width, height) {
      const { g, camera } = this;
      const step = Ranges.nice(90 / camera.scale);
      g.strokeStyle = Theme.now().faint;
      g.lineWidth = 1;
      g.beginPath();
      for (const [k, size] of [
        [0, width],
        [1, height],
      ]) {
        const half = size / 2 / camera.scale;
        const from = Math.ceil((camera.centre[k] - half) / step);
        for (let n = from; n * step <= camera.centre[k] + half && n < from + 200; n++) {
          const off = (n * step - camera.centre[k]) * camera.scale;
          const x = Math.round(k === 0 ? width / 2 + off : height / 2 - off) + 0.5;
          if (k === 0) {
            g.moveTo(x, 0);
            g.lineTo(x, height);
          } else {
            g.moveTo(0, x);
            g.lineTo(width, x);
          }
        }
      }
      g.stroke();
    }

    line(points, colour, width, dash = []) {
      const { g } = this;
      g.strokeStyle = colour;
      g.lineWidth = width;
      g.setLineDash(dash);
      g.beginPath();
      points.forEach((p, k) => (k ? g.lineTo(p[0], p[1]) : g.moveTo(p[0], p[1])));
      g.stroke();
      g.setLineDash([]);
    }

    shape(shape, colour, run) {
      const { g, style } = this;
      const kind = shape.kind;
      if (kind === "rod" || kind === "line") {
        const ends = [this.px(shape.from), this.px(shape.to)];
        const rod = kind === "rod";
        this.line(ends, rod ? style.metal : style.thin, rod ? style.rod : 1.5, style.dash);
        if (rod && style.joints) this.joint(ends[0]);
        this.note(shape, ends, run);
      } else if (kind === "spring") {
        const ends = [this.px(shape.from), this.px(shape.to)];
        this.line(Outlines.coil(ends, shape.turns), style.metal, 2, style.dash);
        this.note(shape, ends, run);
      } else if (kind === "arrow") {
        const ends = [this.px(shape.from), this.px(shape.to)];
        this.arrow(ends, style.arrow);
        this.note(shape, ends, run);
      } else if (kind === "bob") {
        const at = this.px(shape.at);
        const radius = shape.radius ? Math.max(3, shape.radius * this.camera.scale) : BOB;
        g.beginPath();
        g.arc(at[0], at[1], radius * style.size, 0, 7);
        g.fillStyle = style.hollow ? Theme.now().stage : colour;
        g.fill();
        g.strokeStyle = style.hollow ? colour : Theme.now().stage;
        g.lineWidth = style.hollow ? 2 : 1.5;
        g.setLineDash(style.hollow ? [3, 3] : []);
        g.stroke();
        g.setLineDash([]);
        this.note(shape, [at], run);
      } else if (kind === "circle") {
        const ring = Outlines.circle(shape).map((p) => this.px(p));
        this.line(ring, style.thin, 1.5);
        this.note(shape, [this.px(shape.at)], run);
      } else if (kind === "curve") {
        const points = shape.points.map((p) => this.px(p));
        this.line(points, style.metal, 2, style.dash);
        this.note(shape, points, run);
      } else if (kind === "body") this.body(shape, colour, run);
    }

    joint(p) {
      const { g } = this;
      g.beginPath();
      g.arc(p[0], p[1], 3.5, 0, 7);
      g.fillStyle = Theme.now().stage;
      g.fill();
      g.strokeStyle = this.style.metal;
      g.lineWidth = 1.5;
      g.stroke();
    }

    arrow([a, b], colour) {
      const { g } = this;
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      if (!(length > 1)) return;
      const [c, s] = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
      const head = Math.min(11, length * 0.5);
      this.line([a, [b[0] - c * head * 0.8, b[1] - s * head * 0.8]], colour, 2.5);
      g.fillStyle = colour;
      g.beginPath();
      g.moveTo(b[0], b[1]);
      g.lineTo(b[0] - c * head + s * head * 0.42, b[1] - s * head - c * head * 0.42);
      g.lineTo(b[0] - c * head - s * head * 0.42, b[1] - s * head + c * head * 0.42);
      g.fill();
    }

    ground(shape) {
      const { g, camera } = this;
      const p = [0, 0, 0];
      const k = "xyz".indexOf(shape.axis);
      p[k] = shape.height;
      const [x, y] = this.px(p);
      const flat = k === camera.j;
      if (!flat && k !== camera.i) return;
      g.fillStyle = Theme.now().faint;
      if (flat) g.fillRect(0, y, camera.width, Math.max(0, camera.height - y));
      else g.fillRect(0, 0, Math.max(0, x), camera.height);
      this.line(
        flat
          ? [
              [0, y],
              [camera.width, y],
            ]
          : [
              [x, 0],
              [x, camera.height],
            ],
        Theme.now().soft,
        1.5,
      );
      this.drawn.push({ kind: "ground", name: "", run: 0, points: [[x, y]] });
    }

    body(shape, colour, run) {
      const { g } = this;
      const outline = Outlines.hull(Solids.points(shape).map((p) => this.px(p)));
      g.fillStyle = colour;
      g.strokeStyle = Theme.now().stage;
      g.lineWidth = 1.5;
      g.beginPath();
      outline.forEach((p, k) => (k ? g.lineTo(p[0], p[1]) : g.moveTo(p[0], p[1])));
      g.closePath();
      g.fill();
      g.stroke();
      const at = this.px(shape.at);
      const mark = this.px(
        shape.at.map(
          (x, k) =>
            x +
            Shapes.axis(shape.turn, 0, shape.form === "box" ? shape.sizes[0] / 2 : shape.sizes[0])[
              k
            ],
        ),
      );
      this.line([at, mark], Theme.now().stage, 2);
      this.note(shape, [at], run);
    }

    trail({ trail, colour }, style) {
      const { g } = this;
      const n = trail.size;
      if (n < 2) return;
      g.strokeStyle = colour || style.trail;
      g.lineWidth = style.trailWidth;
      const pieces = Number.isFinite(trail.lasting) ? Math.min(TAIL, n - 1) : 1;
      let previous = null;
      for (let piece = 0; piece < pieces; piece++) {
        const from = Math.floor((piece * (n - 1)) / pieces);
        const to = Math.floor(((piece + 1) * (n - 1)) / pieces);
        g.globalAlpha = style.alpha * (pieces === 1 ? 0.6 : 0.08 + (0.72 * (piece + 1)) / pieces);
        g.beginPath();
        for (let k = from; k <= to; k++) {
          const p = this.px([trail.get(k, 1), trail.get(k, 2), trail.get(k, 3)]);
          if (k === from) g.moveTo(p[0], p[1]);
          else g.lineTo(p[0], p[1]);
          previous = p;
        }
        g.stroke();
      }
      g.globalAlpha = 1;
      this.drawn.push({ kind: "trail", name: "", run: 0, points: previous ? [previous] : [] });
    }
  }

  return { View };
})();
