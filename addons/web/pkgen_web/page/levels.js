"use strict";
/* Contours of an output over two coordinates, such as a potential, by marching squares on a lattice
 * that covers the view. They are recomputed if the parameters or the view change. */
const Levels = (() => {
  const ACROSS = 72;
  const LEVELS = 14;

  class Contours {
    constructor(shape, unit) {
      this.shape = shape; /* `value` is the index of an output, `x` and `y` those of coordinates */
      this.unit = unit;
      this.key = "";
      this.lines = [];
      this.marks = []; /* labels: {at: position, text: value} */
    }

    /* Evaluates the output at the points of the lattice; all coordinates but two, and all rates,
     * have their initial values. */
    update(engine, start, camera) {
      const wide = 1.15;
      const half = [
        ((camera.width / camera.scale) * wide) / 2,
        ((camera.height / camera.scale) * wide) / 2,
      ];
      const key = [...start.params, ...camera.centre, ...half].map((x) => x.toPrecision(4)).join();
      if (key === this.key) return;
      this.key = key;
      const n = [ACROSS, Math.max(8, Math.round((ACROSS * half[1]) / half[0]))];
      const at = (k, i) => camera.centre[k] - half[k] + (2 * half[k] * i) / n[k];
      const q = start.q.slice();
      const grid = [];
      for (let j = 0; j <= n[1]; j++) {
        const row = new Float64Array(n[0] + 1);
        for (let i = 0; i <= n[0]; i++) {
          q[this.shape.x] = at(0, i);
          q[this.shape.y] = at(1, j);
          row[i] = engine.outputs(start.params, 0, q, start.v)[this.shape.value];
        }
        grid.push(row);
      }
      const sorted = grid
        .flatMap((row) => Array.from(row).filter(Number.isFinite))
        .sort((a, b) => a - b);
      if (!sorted.length) return;
      const [low, high] = [
        sorted[Math.floor(sorted.length * 0.01)],
        sorted[Math.floor(sorted.length * 0.9)],
      ];
      const values = Array.from(
        { length: LEVELS },
        (_, k) => low + (high - low) * ((k + 0.5) / LEVELS) ** 1.6,
      );
      this.lines = values.map((value) => march(grid, value, at));
      /* The label of a contour is where the contour crosses the direction of −0.6 radians from the
       * centre, so that the labels are in a row. */
      const off = ([x, y]) => Math.abs(Math.atan2(y - camera.centre[1], x - camera.centre[0]) + 0.6);
      const ends = this.lines.map((list) => list.map(([a]) => a).sort((a, b) => off(a) - off(b))[0]);
      this.marks = ends.flatMap((end, k) =>
        end ? [{ at: end, text: Text.quantity(values[k], this.unit, 2) }] : [],
      );
    }

    draw(g, camera) {
      g.lineWidth = 1;
      g.strokeStyle = Theme.now().soft;
      this.lines.forEach((segments, k) => {
        g.globalAlpha = 0.25 + (0.3 * k) / LEVELS;
        g.beginPath();
        for (const [a, b] of segments) {
          const [p, q] = [this.place(a, camera), this.place(b, camera)];
          g.moveTo(p[0], p[1]);
          g.lineTo(q[0], q[1]);
        }
        g.stroke();
      });
      g.globalAlpha = 1;
    }

    place([x, y], camera) {
      const p = [0, 0, 0];
      p[camera.i ?? 0] = x;
      p[camera.j ?? 1] = y;
      return camera.project(p);
    }
  }

  /* Returns the line segments of one contour. Where the contour crosses the edge of a lattice cell
   * is interpolated between the corners. */
  function march(grid, level, at) {
    const segments = [];
    for (let j = 0; j + 1 < grid.length; j++)
      for (let i = 0; i + 1 < grid[j].length; i++) {
        const corner = [
          [i, j],
          [i + 1, j],
          [i + 1, j + 1],
          [i, j + 1],
        ];
        const z = corner.map(([a, b]) => grid[b][a] - level);
        const cuts = [];
        for (let k = 0; k < 4; k++) {
          const [za, zb] = [z[k], z[(k + 1) % 4]];
          if (!(za < 0 !== zb < 0) || !Number.isFinite(za - zb)) continue;
          const s = za / (za - zb);
          const [a, b] = [corner[k], corner[(k + 1) % 4]];
          cuts.push([at(0, a[0] + s * (b[0] - a[0])), at(1, a[1] + s * (b[1] - a[1]))]);
        }
        if (cuts.length === 2) segments.push(cuts);
        else if (cuts.length === 4) segments.push([cuts[0], cuts[1]], [cuts[2], cuts[3]]);
      }
    return segments;
  }

  return { Contours };
})();
