"use strict";
/* Charts by uPlot, in the page's colours: any number of lines or points, each with its own x. */
const Chart = (() => {
  const FLOOR = 1e-17; /* on a logarithmic axis, a smaller value is drawn as this value */

  /* Draws a line or points with its own x, clipped to the frame: uPlot's series share one x. */
  function paths(style) {
    return (u, index) => {
      const [xs, ys] = u.data[index];
      const g = u.ctx;
      const { left, top, width, height } = u.bbox;
      const ratio = uPlot.pxRatio;
      const X = (x) => u.valToPos(x, "x", true);
      const Y = (y) => u.valToPos(y, "y", true);
      g.save();
      g.beginPath();
      g.rect(left, top, width, height);
      g.clip();
      if (style.points) {
        g.fillStyle = style.colour;
        const r = style.points * ratio;
        for (let k = 0; k < xs.length; k++) g.fillRect(X(xs[k]) - r / 2, Y(ys[k]) - r / 2, r, r);
      } else {
        g.strokeStyle = style.colour;
        g.lineWidth = (style.width || 1.6) * ratio;
        g.setLineDash((style.dash || []).map((d) => d * ratio));
        g.lineJoin = "round";
        g.beginPath();
        let pen = false;
        for (let k = 0; k < xs.length; k++) {
          if (!Number.isFinite(ys[k])) {
            pen = false;
            continue;
          }
          if (pen) g.lineTo(X(xs[k]), Y(ys[k]));
          else g.moveTo(X(xs[k]), Y(ys[k]));
          pen = true;
        }
        g.stroke();
        g.setLineDash([]);
      }
      if (style.head && xs.length) {
        const k = xs.length - 1;
        g.fillStyle = style.colour;
        g.beginPath();
        g.arc(X(xs[k]), Y(ys[k]), 3.5 * ratio, 0, 7);
        g.fill();
      }
      g.restore();
      return null;
    };
  }

  function extent(lists, log) {
    let [lo, hi] = [Infinity, -Infinity];
    for (const list of lists)
      for (let k = 0; k < list.length; k++) {
        const x = list[k];
        if (!Number.isFinite(x) || (log && !(x > 0))) continue;
        if (x < lo) lo = x;
        if (x > hi) hi = x;
      }
    return lo <= hi ? [lo, hi] : log ? [1e-16, 1] : [0, 1];
  }

  function padded([lo, hi], share) {
    const pad = (hi - lo) * share || Math.abs(hi) * 0.1 || 1;
    return [lo - pad, hi + pad];
  }

  const decades = ([lo, hi]) => {
    const a = Math.max(Math.floor(Math.log10(lo)), -17);
    return [10 ** a, 10 ** Math.max(a + 2, Math.ceil(Math.log10(hi)))];
  };

  class Chart_ {
    /* options: labels x and y of the axes; whether y is logarithmic (log) */
    constructor(element, options) {
      this.element = element;
      this.options = options;
      this.plot = null;
      this.made = "";
      this.range = { x: [0, 1], y: [0, 1] };
    }

    /* lines: [{x, y, colour, dash, points, head}]. The ranges x and y are computed if not given. */
    set(given, { x, y } = {}) {
      const lines = given.length ? given : [{ x: [], y: [], colour: Theme.now().soft }];
      const { log } = this.options;
      this.range.x = x || padded(extent(lines.map((l) => l.x)), 0);
      this.range.y =
        y ||
        (log
          ? decades(
              extent(
                lines.map((l) => l.y),
                true,
              ),
            )
          : padded(extent(lines.map((l) => l.y)), 0.06));
      const data = [
        null,
        ...lines.map((l) => [l.x, log ? l.y.map((v) => Math.max(v, FLOOR)) : l.y]),
      ];
      const made = JSON.stringify([
        lines.map(({ colour, dash, points, head }) => [colour, dash, points, head]),
        Theme.now().dark,
        this.options.x,
        this.options.y,
      ]);
      const { clientWidth: width, clientHeight: height } = this.element;
      if (!width || !height) return;
      if (made !== this.made) {
        this.made = made;
        if (this.plot) this.plot.destroy();
        this.plot = new uPlot(this.layout(lines, width, height), data, this.element);
      } else {
        if (this.plot.width !== width || this.plot.height !== height)
          this.plot.setSize({ width, height });
        this.plot.batch(() => {
          this.plot.setData(data, false);
          for (const axis of ["x", "y"]) {
            const [min, max] = this.range[axis];
            this.plot.setScale(axis, { min, max });
          }
        });
      }
      this.lines = lines;
    }

    layout(lines, width, height) {
      const theme = Theme.now();
      const font = `11px ${theme.font}`;
      const axis = (label, more) => ({
        stroke: theme.soft,
        font,
        labelFont: font,
        label,
        labelSize: 16,
        labelGap: 0,
        grid: { stroke: theme.faint, width: 1 },
        ticks: { stroke: theme.faint, width: 1, size: 4 },
        gap: 4,
        ...more,
      });
      const { log } = this.options;
      const written = (u, splits) => splits.map((v) => Text.number(v, 4));
      return {
        mode: 2,
        width,
        height,
        padding: [8, 20, 0, 0],
        legend: { show: false },
        cursor: { show: false },
        scales: {
          x: { time: false, auto: false, range: () => this.range.x },
          y: { auto: false, distr: log ? 3 : 1, range: () => this.range.y },
        },
        axes: [
          axis(this.options.x, { size: 26, values: written, space: 56 }),
          axis(
            this.options.y,
            log
              ? {
                  size: 40,
                  splits: () => this.powers(),
                  filter: (u, s) => s,
                  values: (u, s) => s.map((v) => Text.powerOfTen(v)),
                }
              : { size: 48, space: 28, values: written },
          ),
        ],
        series: [
          {},
          ...lines.map((line) => ({
            stroke: line.colour,
            paths: paths(line),
            facets: [
              { scale: "x", auto: false },
              { scale: "y", auto: false },
            ],
          })),
        ],
      };
    }

    powers() {
      const [a, b] = this.range.y.map((v) => Math.round(Math.log10(v)));
      const step = Math.max(1, Math.ceil((b - a) / 5));
      const out = [];
      for (let k = Math.ceil(a / step) * step; k <= b; k += step) out.push(10 ** k);
      return out;
    }

    free() {
      if (this.plot) this.plot.destroy();
      this.plot = null;
      this.made = "";
    }
  }

  return { make: (element, options) => new Chart_(element, options), extent, padded };
})();
