"use strict";
/* The picture of a model without a drawing: its coordinates over time, or for a long family their
 * current values over the index (a profile). */
const GraphView = (() => {
  const CURVES = 6;

  class View {
    constructor(canvas, lab) {
      this.canvas = canvas;
      this.lab = lab;
      this.drawn = [];
      this.reach = 0;
    }

    draw({ width, height, runs }) {
      const g = Dom.blank(this.canvas, width, height);
      this.drawn = [];
      if (!runs.length) return;
      const entries = this.entries();
      const profile = entries.length > CURVES;
      const lines = profile ? this.profiles(runs, entries) : this.curves(runs, entries);
      const all = lines.flatMap((line) => line.points);
      this.frame(g, width, height, lines, all, profile);
    }

    /* Returns the quantities of the drawing's graph, or else those of the state. */
    entries() {
      const { model } = this.lab;
      const graph = model.shapes.find((shape) => shape.kind === "graph");
      const named = ((graph && graph.columns) || [])
        .map((c) => model.byKey.get("q" + c))
        .filter(Boolean);
      if (named.length) return named;
      const all = PanelsTime.quantitiesOf(model);
      const places = all.filter((e) => e.kind === "q");
      return places.length ? places : all.slice(0, CURVES);
    }

    profiles(runs, entries) {
      return runs.map(({ run, style }) => ({
        run,
        style,
        colour: style.trail,
        name: "",
        points: entries.map((e, k) => [
          k + 1,
          run.recent.get(run.recent.size - 1, PanelsTime.columnOf(this.lab, e)),
        ]),
      }));
    }

    curves(runs, entries) {
      const theme = Theme.now();
      return runs.flatMap(({ run, style }) =>
        entries.map((e, k) => {
          const from = Math.max(0, run.recent.size - 1500);
          const column = PanelsTime.columnOf(this.lab, e);
          const points = [];
          for (let i = from; i < run.recent.size; i++)
            points.push([run.recent.get(i, 0), run.recent.get(i, column)]);
          return {
            run,
            style,
            points,
            name: e.name,
            colour: runs.length > 1 || entries.length === 1 ? style.trail : theme.shapes[k % 4],
          };
        }),
      );
    }

    frame(g, width, height, lines, all, profile) {
      const theme = Theme.now();
      const [left, right, top, bottom] = [56, 24, 52, 40];
      let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
      for (const [x, y] of all) {
        x0 = Math.min(x0, x);
        x1 = Math.max(x1, x);
        if (Number.isFinite(y)) {
          y0 = Math.min(y0, y);
          y1 = Math.max(y1, y);
        }
      }
      if (profile) {
        /* The scale of a profile follows a decreasing amplitude only slowly: otherwise the axis
         * would pulsate with each oscillation. */
        this.reach = Math.max(this.reach * 0.999, Math.abs(y0), Math.abs(y1)) || 1;
        [y0, y1] = [-this.reach * 1.1, this.reach * 1.1];
      } else {
        const span = (this.lab.natural || 1) * 8;
        if (x1 - x0 < span) x1 = x0 + span;
        const pad = 0.08 * (y1 - y0) || 1;
        [y0, y1] = [y0 - pad, y1 + pad];
      }
      const X = (x) => left + ((x - x0) / (x1 - x0 || 1)) * (width - left - right);
      const Y = (y) => height - bottom - ((y - y0) / (y1 - y0)) * (height - top - bottom);
      Axes.draw(g, {
        left,
        right: width - right,
        top,
        bottom: height - bottom,
        X,
        Y,
        x: [x0, x1],
        y: [y0, y1],
        below: profile ? "number" : Text.axis("t", this.lab.model.time),
      });
      g.lineJoin = "round";
      for (const line of lines) {
        g.globalAlpha = line.style.alpha;
        g.strokeStyle = line.colour;
        g.lineWidth = 2;
        g.setLineDash(line.style.dash);
        g.beginPath();
        line.points.forEach(([x, y], k) => (k ? g.lineTo(X(x), Y(y)) : g.moveTo(X(x), Y(y))));
        g.stroke();
        g.setLineDash([]);
        const last = line.points[line.points.length - 1];
        g.fillStyle = line.colour;
        g.beginPath();
        for (const [x, y] of profile && line.points.length < 200 ? line.points : [last]) {
          g.moveTo(X(x) + 3, Y(y));
          g.arc(X(x), Y(y), 3, 0, 7);
        }
        g.fill();
        g.globalAlpha = 1;
        if (line.name && line.run.index === 0 && last) {
          g.textAlign = "left";
          g.font = `italic 15px ${theme.font}`;
          g.fillText(Text.plain(line.name), Math.min(X(last[0]) + 8, width - 22), Y(last[1]) - 8);
        }
        this.drawn.push({
          kind: profile ? "profile" : "graph",
          name: line.name,
          run: line.run.index,
          points: (profile ? line.points : [last]).map(([x, y]) => [X(x), Y(y)]),
        });
      }
    }
  }

  return { View };
})();
