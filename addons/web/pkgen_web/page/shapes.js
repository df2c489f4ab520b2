"use strict";
/* Evaluates the drawing of the description for one state: the points of each shape. */
const Shapes = (() => {
  const value = (number, out) =>
    number !== null && typeof number === "object" ? out[number.output] : number;
  const point = (p, out) => [value(p[0], out), value(p[1], out), value(p[2], out)];
  const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
  const seen = (p) => p.every((x) => Number.isFinite(x));

  /* Returns the shape for one state: each index of an output is replaced by the output's value in
   * `out`. */
  function resolve(shape, out) {
    const { kind, name, label } = shape;
    const made = { kind, name, label, shape };
    switch (kind) {
      case "rod":
      case "spring":
      case "line":
        made.from = point(shape.from, out);
        made.to = point(shape.to, out);
        made.turns = shape.turns || 8;
        break;
      case "arrow":
        made.from = point(shape.at, out);
        made.to = plus(made.from, point(shape.vector, out));
        break;
      case "bob":
      case "trail":
        made.at = point(shape.at, out);
        made.radius = value(shape.radius ?? null, out);
        break;
      case "circle":
        made.at = point(shape.at, out);
        made.radius = value(shape.radius, out);
        made.normal = point(shape.normal || [0, 0, 1], out);
        break;
      case "body":
        made.form = shape.form;
        made.at = point(shape.at, out);
        made.sizes = shape.sizes.map((size) => value(size, out));
        made.turn = (shape.turn || [1, 0, 0, 0, 1, 0, 0, 0, 1]).map((x) => value(x, out));
        break;
      case "ground":
        made.axis = shape.axis;
        made.height = value(shape.at, out);
        break;
      case "curve":
      case "graph":
        made.points = (shape.points || []).map((p) => point(p, out));
        made.columns = shape.columns || [];
        break;
      case "level":
        made.value = shape.value.output;
        made.x = shape.x;
        made.y = shape.y;
        break;
    }
    return made;
  }

  const resolveAll = (shapes, out) => shapes.map((shape) => resolve(shape, out));

  /* Returns points that bound a shape; for a body, corners of a box around it. */
  function reach(made) {
    switch (made.kind) {
      case "rod":
      case "spring":
      case "line":
      case "arrow":
        return [made.from, made.to];
      case "bob":
        return around(made.at, made.radius || 0);
      case "trail":
        return [made.at];
      case "circle":
        return flat(made);
      case "curve":
      case "graph":
        return made.points;
      case "body": {
        const [a, b = a, c = a] = made.sizes;
        if (made.form === "top") return [made.at, plus(made.at, axis(made.turn, 2, b * 1.1))];
        const half =
          made.form === "box"
            ? Math.hypot(a, b, c) / 2
            : made.form === "ellipsoid"
              ? Math.max(a, b, c)
              : Math.hypot(a, b / 2);
        return around(made.at, half);
      }
      default:
        return [];
    }
  }

  const axis = (turn, k, length) => [
    turn[3 * k] * length,
    turn[3 * k + 1] * length,
    turn[3 * k + 2] * length,
  ];
  const around = (p, r) => [
    [p[0] - r, p[1] - r, p[2] - r],
    [p[0] + r, p[1] + r, p[2] + r],
  ];

  const flat = ({ at, radius, normal }) => {
    const size = Math.hypot(...normal) || 1;
    const r = normal.map((n) => radius * Math.sqrt(Math.max(0, 1 - (n / size) ** 2)));
    return [at.map((x, k) => x - r[k]), at.map((x, k) => x + r[k])];
  };

  const box = () => ({ lo: [Infinity, Infinity, Infinity], hi: [-Infinity, -Infinity, -Infinity] });
  function include(b, p) {
    if (!seen(p)) return;
    for (let k = 0; k < 3; k++) {
      b.lo[k] = Math.min(b.lo[k], p[k]);
      b.hi[k] = Math.max(b.hi[k], p[k]);
    }
  }
  function grow(b, shapes, out) {
    for (const shape of shapes) for (const p of reach(resolve(shape, out))) include(b, p);
  }
  function join(b, other) {
    if (other.lo[0] <= other.hi[0]) {
      include(b, other.lo);
      include(b, other.hi);
    }
  }

  /* Returns the draggable points: ends of rods, bobs, bodies, points of chains; each once. */
  function handles(made) {
    const found = [];
    const add = (point, of, read) => {
      if (seen(point)) found.push({ point, of, read });
    };
    for (const shape of made) {
      const { kind } = shape;
      const source = shape.shape;
      if (kind === "body" && shape.form === "top")
        add(head(shape), shape, (out) => head(resolve(source, out)));
      else if (kind === "bob" || kind === "body")
        add(shape.at, shape, (out) => point_(source.at, out));
      else if (kind === "rod" || kind === "spring")
        add(shape.to, shape, (out) => point_(source.to, out));
      else if (kind === "curve")
        shape.points.forEach((p, k) => add(p, shape, (out) => point_(source.points[k], out)));
    }
    return found;
  }
  const point_ = point;
  const head = ({ at, turn, sizes }) => plus(at, axis(turn, 2, sizes[1]));

  return { resolve, resolveAll, point, value, box, include, grow, join, handles, axis, seen };
})();
