"use strict";
/* Labels over a scene: names of bodies and arrows, captions, values of contours, the scale. They do
 * not overlap each other, bodies or buttons. */
const Marks = (() => {
  const NAMED = 12; /* if there are more names than this, none is drawn */
  const GAP = 5;

  class View {
    constructor(canvas, camera) {
      this.canvas = canvas;
      this.camera = camera;
      this.placed = [];
    }

    /* Draws the labels of a scene; `placed` records their positions. */
    draw({ width, height, runs, levels, unit }) {
      const g = (this.g = Dom.blank(this.canvas, width, height));
      g.textAlign = "left";
      g.textBaseline = "middle";
      this.size = [width, height];
      /* Areas that labels avoid: those of the buttons, and, next line, that of the methods'
       * names. */
      this.boxes = [[0, 0, 186, 52], [width - 70, 0, width, 52]];
      if (runs.length > 1) this.boxes.push([0, height - 40, 0.78 * width, height]);
      this.placed = [];
      this.scale(unit);
      if (!runs.length) return;
      const { made, style } = runs[runs.length - 1];
      this.captions(made);
      this.bodies(made);
      if (style.labels) this.names(made);
      for (const { at, text } of levels ? levels.marks : [])
        this.beside(text, levels.place(at, this.camera), 0, false);
    }

    px(p) {
      return this.camera.project(p);
    }

    scale(unit) {
      const { g, camera, size } = this;
      const pixels = camera.scale || camera.focal() / camera.distance;
      const step = Ranges.nice(90 / pixels);
      const length = step * pixels;
      const [x, y] = [size[0] - 16, size[1] - 14];
      g.strokeStyle = Theme.now().soft;
      g.lineWidth = 1;
      g.beginPath();
      g.moveTo(x - length, y - 4);
      g.lineTo(x - length, y);
      g.lineTo(x, y);
      g.lineTo(x, y - 4);
      g.stroke();
      const text = Text.quantity(step, unit) + (camera.scale ? "" : " at the middle");
      this.font();
      this.write(text, Math.min(x - length / 2 - g.measureText(text).width / 2,
        size[0] - 8 - g.measureText(text).width), y - 13);
      this.boxes.push([x - length - 8, y - 24, size[0], size[1]]);
    }

    bodies(made) {
      const r = 11;
      for (const { kind, at } of made)
        if (kind === "bob" && this.boxes.length < 60) {
          const [x, y] = this.px(at);
          this.boxes.push([x - r, y - r, x + r, y + r]);
        }
    }

    names(made) {
      const named = made
        .filter((s) => ["bob", "body", "arrow", "circle"].includes(s.kind))
        .map((s) => [s, s.label || s.shape.says || (s.kind === "bob" ? s.shape.member : "")])
        .filter(([, text]) => text !== undefined && text !== "" && String(text).length <= 32);
      if (named.length > NAMED) return;
      for (const [s, text] of named) {
        const at = this.px(s.kind === "arrow" ? s.to : s.at);
        this.beside(Text.plain(String(text)), at, s.kind === "arrow" ? 0 : 10, true);
      }
    }

    /* Draws captions above the lower edge of the canvas; below each bar of a chart, its index. */
    captions(made) {
      const { g } = this;
      const [width, height] = this.size;
      const texts = made.map((shape) => shape.shape.caption).filter(Boolean);
      const times = made.map((shape) => shape.shape.times).find(Boolean);
      if (times) texts.push(`Displacements are drawn ${Text.number(times)} times as large`);
      this.font();
      const lines = texts.flatMap((text) =>
        text.split(" ").reduce((all, word) => {
          const longer = all.length ? `${all[all.length - 1]} ${word}` : word;
          if (all.length && g.measureText(longer).width < 0.68 * width)
            all[all.length - 1] = longer;
          else all.push(word);
          return all;
        }, []),
      );
      const most = Array.from({ length: 5 }, (_, k) => height - 16 - 18 * k);
      for (const line of lines.reverse()) this.text(line, most.map((y) => [14, y]));
      const from = made.findIndex((shape) => shape.shape.caption);
      if (from < 0) return;
      for (const { kind, from: foot, shape } of made.slice(from))
        if (kind === "rod" && shape.member !== undefined) {
          const [x, y] = this.px(foot);
          this.text(String(shape.member), [[x - 4, y + 13], [x - 4, y - 13]]);
        }
    }

    font() {
      this.g.font = `13px ${Theme.now().font}`;
    }

    beside(text, [x, y], r, must) {
      this.font();
      const w = this.g.measureText(text).width;
      const d = r + GAP;
      this.text(text, [
        [x + d, y - d], [x + d, y + d], [x - d - w, y - d], [x - d - w, y + d],
        [x - w / 2, y - d - 8], [x - w / 2, y + d + 8], [x + d, y - 3 * d - 8], [x + d, y + 3 * d + 8],
      ], must);
    }

    /* Draws a text at the first of `places` where it is inside the canvas and overlaps no other. If
     * there is none and `must` is true, draws it at the first place inside the canvas. */
    text(text, places, must = false) {
      this.font();
      const w = this.g.measureText(text).width;
      const box = ([x, y]) => [x - 3, y - 9, x + w + 3, y + 9];
      const inside = ([a, b, c, d]) => a >= 0 && b >= 0 && c <= this.size[0] && d <= this.size[1];
      const free = (p) => this.boxes.every((q) =>
        p[2] <= q[0] || q[2] <= p[0] || p[3] <= q[1] || q[3] <= p[1]);
      const fits = places.filter((at) => inside(box(at)));
      const at = fits.find((place) => free(box(place))) || (must && fits[0]);
      if (!at) return;
      this.boxes.push(box(at));
      this.write(text, ...at);
    }

    write(text, x, y) {
      const { g } = this;
      const theme = Theme.now();
      g.strokeStyle = theme.stage;
      g.lineWidth = 4;
      g.lineJoin = "round";
      g.strokeText(text, x, y);
      g.fillStyle = theme.soft;
      g.fillText(text, x, y);
      this.placed.push({ text, x, y, width: g.measureText(text).width });
    }
  }

  return { View };
})();
