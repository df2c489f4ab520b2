"use strict";
/* Meshes of unit solids as triangles, and the matrices that place them for a body. */
const Solids = (() => {
  /* Returns a surface of revolution about z from [radius, z] pairs, shaded flat or smooth. */
  function revolve(profile, sides, smooth) {
    const position = [];
    const normal = [];
    for (let k = 0; k + 1 < profile.length; k++) {
      const [[r0, z0], [r1, z1]] = [profile[k], profile[k + 1]];
      const [nr, nz] = Camera.unit([z1 - z0, r0 - r1]);
      const slope = (r, z) => (smooth ? Camera.unit([r, z]) : [nr, nz]);
      for (let i = 0; i < sides; i++) {
        const [a, b] = [(2 * Math.PI * i) / sides, (2 * Math.PI * (i + 1)) / sides];
        const corner = (r, z, angle) => {
          const [mr, mz] = slope(r, z);
          position.push(r * Math.cos(angle), r * Math.sin(angle), z);
          normal.push(mr * Math.cos(angle), mr * Math.sin(angle), mz);
        };
        for (const [r, z, angle] of [
          [r0, z0, a],
          [r0, z0, b],
          [r1, z1, b],
          [r0, z0, a],
          [r1, z1, b],
          [r1, z1, a],
        ])
          corner(r, z, angle);
      }
    }
    return { position: new Float32Array(position), normal: new Float32Array(normal) };
  }

  function cube() {
    const position = [];
    const normal = [];
    for (let k = 0; k < 3; k++)
      for (const side of [-0.5, 0.5])
        for (const [a, b] of [
          [-0.5, -0.5],
          [0.5, -0.5],
          [0.5, 0.5],
          [-0.5, -0.5],
          [0.5, 0.5],
          [-0.5, 0.5],
        ]) {
          const p = [0, 0, 0];
          p[k] = side;
          p[(k + 1) % 3] = a;
          p[(k + 2) % 3] = b;
          const n = [0, 0, 0];
          n[k] = Math.sign(side);
          position.push(...p);
          normal.push(...n);
        }
    return { position: new Float32Array(position), normal: new Float32Array(normal) };
  }

  function all() {
    const ball = Array.from({ length: 17 }, (_, k) => [
      Math.sin((Math.PI * k) / 16),
      -Math.cos((Math.PI * k) / 16),
    ]);
    return {
      ball: revolve(ball, 32, true),
      /* a cylinder of radius 1, from z = −1/2 to 1/2, with caps */
      drum: revolve(
        [
          [0, -0.5],
          [1, -0.5],
          [1, 0.5],
          [0, 0.5],
        ],
        48,
        false,
      ),
      /* a cylinder of radius 1 from z = 0 to 1, without caps */
      tube: revolve(
        [
          [1, 0],
          [1, 1],
        ],
        20,
        false,
      ),
      /* a spinning top with a stem; its tip is the origin */
      top: revolve(
        [
          [0, 0],
          [0.16, 0.12],
          [0.75, 0.62],
          [1, 0.74],
          [1, 0.84],
          [0.3, 0.92],
          [0.1, 1],
          [0.1, 1.28],
          [0, 1.3],
        ],
        48,
        false,
      ),
      tip: revolve(
        [
          [0, 0],
          [1, 0],
          [0, 1],
        ],
        20,
        false,
      ),
      box: cube(),
    };
  }

  /* Returns a column-major matrix with the axes x, y, z and the origin o as columns. */
  const matrix = (x, y, z, o) => [...x, 0, ...y, 0, ...z, 0, ...o, 1];
  const times = (a, k) => a.map((x) => x * k);

  function turned(turn, sizes, at) {
    return matrix(
      Shapes.axis(turn, 0, sizes[0]),
      Shapes.axis(turn, 1, sizes[1]),
      Shapes.axis(turn, 2, sizes[2]),
      at,
    );
  }

  /* Returns the matrix of a tube from a to b. */
  function along(a, b, radius) {
    const d = a.map((x, k) => b[k] - x);
    const z = Camera.unit(d);
    const x = Camera.unit(Camera.cross(z, Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));
    return matrix(times(x, radius), times(Camera.cross(z, x), radius), d, a);
  }

  /* Returns [mesh, matrix] of a body. */
  function place({ form, sizes, at, turn }) {
    const [a, b, c] = sizes;
    switch (form) {
      case "box":
        return ["box", turned(turn, [a, b, c], at)];
      case "ellipsoid":
        return ["ball", turned(turn, [a, b, c], at)];
      case "top":
        return ["top", turned(turn, [a, a, b], at)];
      default:
        return ["drum", turned(turn, [a, a, b || a * 0.04], at)];
    }
  }

  /* Returns the vertices of a body, from which a plane view makes an outline. */
  let sample = null;
  function points(shape) {
    sample = sample || all();
    const [mesh, m] = place(shape);
    const { position } = sample[mesh];
    const seen = new Set();
    const out = [];
    for (let k = 0; k < position.length; k += 3) {
      const [x, y, z] = [position[k], position[k + 1], position[k + 2]];
      const key = `${x.toFixed(4)},${y.toFixed(4)},${z.toFixed(4)}`;
      if (seen.has(key)) continue;
      seen.add(key);
      out.push([0, 1, 2].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]));
    }
    return out;
  }

  return { all, place, along, turned, points, matrix };
})();
