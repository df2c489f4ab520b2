"use strict";
/* Outlines of springs and bodies in the plane, and of circles in space. */
const Outlines = (() => {
  /* Returns the zigzag of a spring seen from the side. */
  function coil([a, b], turns) {
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    const [c, s] = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    const ends = Math.min(14, length * 0.12);
    const width = Math.max(4, Math.min(11, 5 + 40 / turns));
    const points = [a];
    const n = turns * 12;
    for (let k = 0; k <= n; k++) {
      const x = ends + ((length - 2 * ends) * k) / n;
      const y = width * Math.sin((2 * Math.PI * turns * k) / n);
      points.push([a[0] + c * x - s * y, a[1] + s * x + c * y]);
    }
    points.push(b);
    return points;
  }

  function circle({ at, radius, normal }) {
    const n = Camera.unit(normal);
    const u = Camera.unit(Camera.cross(n, Math.abs(n[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));
    const v = Camera.cross(n, u);
    return Array.from({ length: 73 }, (_, k) => {
      const [c, s] = [Math.cos((k * Math.PI) / 36) * radius, Math.sin((k * Math.PI) / 36) * radius];
      return at.map((x, i) => x + c * u[i] + s * v[i]);
    });
  }

  /* Returns the convex hull, by Andrew's monotone chain. */
  function hull(points) {
    const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const half = (list) => {
      const out = [];
      for (const p of list) {
        while (out.length > 1) {
          const [a, b] = [out[out.length - 2], out[out.length - 1]];
          if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
          out.pop();
        }
        out.push(p);
      }
      return out.slice(0, -1);
    };
    return [...half(sorted), ...half(sorted.reverse())];
  }

  return { coil, circle, hull };
})();
