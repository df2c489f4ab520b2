"use strict";
/* Projects space to pixels of the canvas. The classes Plane and Orbit have the same methods: fit;
 * move (pan or rotate); zoom; project(point), which returns [x, y, depth]; and plane(), which
 * returns the two directions in space along which a drag moves a body. */
const Camera = (() => {
  const AXIS = { x: 0, y: 1, z: 2 };
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
  ];
  const unit = (a) => {
    const size = Math.hypot(...a) || 1;
    return a.map((x) => x / size);
  };

  class Plane {
    constructor(view) {
      const [right, up] = view.axes || ["x", "y"];
      this.i = AXIS[right];
      this.j = AXIS[up];
      this.names = [right, up];
      this.given = null; /* width of the view in `draw view`, if any */
      this.centre = [0, 0];
      this.scale = 100;
      this.resize(100, 100);
    }
    resize(width, height) {
      this.width = width;
      this.height = height;
    }
    fit(box, inset = { x: 0, y: 0 }) {
      const [i, j] = [this.i, this.j];
      const known = box.lo[i] <= box.hi[i] && box.lo[j] <= box.hi[j];
      const lo = known ? [box.lo[i], box.lo[j]] : [-1, -1];
      const hi = known ? [box.hi[i], box.hi[j]] : [1, 1];
      const room = [
        Math.max(80, this.width - 2 * inset.x),
        Math.max(80, this.height - 2 * inset.y),
      ];
      const [x, y] = [hi[0] - lo[0], hi[1] - lo[1]];
      /* If the model gives the width of the view, that width is used; otherwise the width fits the
       * motion. The height fits the motion; if the width is given, the height is at most the
       * width. */
      const width = this.given || x / 0.86 || 1;
      const height = this.given ? Math.min(this.given, y * 1.25 || this.given) : y / 0.86 || 1e-300;
      this.scale = Math.min(room[0] / width, room[1] / height);
      this.centre = [(lo[0] + hi[0]) / 2, (lo[1] + hi[1]) / 2];
    }
    project(p) {
      return [
        this.width / 2 + (p[this.i] - this.centre[0]) * this.scale,
        this.height / 2 - (p[this.j] - this.centre[1]) * this.scale,
        0,
      ];
    }
    plane() {
      const right = [0, 0, 0];
      const up = [0, 0, 0];
      right[this.i] = 1;
      up[this.j] = 1;
      return { right, up, perPixel: () => 1 / this.scale };
    }
    move(dx, dy) {
      this.centre[0] -= dx / this.scale;
      this.centre[1] += dy / this.scale;
    }
    zoom(factor, x = this.width / 2, y = this.height / 2) {
      const [ax, ay] = [(x - this.width / 2) / this.scale, (this.height / 2 - y) / this.scale];
      this.scale *= factor;
      this.centre[0] += ax * (1 - 1 / factor);
      this.centre[1] += ay * (1 - 1 / factor);
    }
  }

  /* A perspective camera on a sphere around `target`; z is up. */
  class Orbit {
    constructor(view) {
      this.given = null; /* width of the view in `draw view`, if any */
      this.yaw = -1.1;
      this.pitch = 0.32;
      this.target = [0, 0, 0];
      this.distance = 5;
      this.angle = 0.6; /* vertical angle of view */
      this.resize(100, 100);
    }
    resize(width, height) {
      this.width = width;
      this.height = height;
    }
    fit(box) {
      const known = box.lo[0] <= box.hi[0];
      const lo = known ? box.lo : [-1, -1, -1];
      const hi = known ? box.hi : [1, 1, 1];
      this.target = lo.map((x, k) => (x + hi[k]) / 2);
      const across = this.given || Math.hypot(...lo.map((x, k) => hi[k] - x)) || 1;
      this.distance = across / 2 / Math.tan(this.angle / 2) / Math.min(1, this.width / this.height);
      if (!this.given) for (let k = 0; k < 3; k++) this.close(lo, hi);
    }
    /* Centres the box, and sets the distance so that its corners fill four fifths of the canvas. */
    close(lo, hi) {
      let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
      for (let corner = 0; corner < 8; corner++) {
        const [x, y] = this.project(lo.map((_, k) => ((corner >> k) & 1 ? hi : lo)[k]));
        [x0, x1, y0, y1] = [Math.min(x0, x), Math.max(x1, x), Math.min(y0, y), Math.max(y1, y)];
      }
      const { right, up } = this.frame();
      const pixel = this.distance / this.focal();
      const [dx, dy] = [
        ((x0 + x1 - this.width) / 2) * pixel,
        ((y0 + y1 - this.height) / 2) * pixel,
      ];
      this.target = this.target.map((t, k) => t + right[k] * dx - up[k] * dy);
      this.distance *= Math.max((x1 - x0) / this.width, (y1 - y0) / this.height, 1e-3) / 0.8;
    }
    frame() {
      const [c, s] = [Math.cos(this.pitch), Math.sin(this.pitch)];
      const back = [c * Math.cos(this.yaw), c * Math.sin(this.yaw), s];
      const right = unit(cross([0, 0, 1], back));
      return {
        back,
        right,
        up: cross(back, right),
        eye: this.target.map((x, k) => x + back[k] * this.distance),
      };
    }
    focal() {
      return this.height / 2 / Math.tan(this.angle / 2);
    }
    project(p) {
      const { back, right, up, eye } = this.frame();
      const d = p.map((x, k) => x - eye[k]);
      const depth = -dot(d, back);
      const f = this.focal() / Math.max(depth, 1e-9 * this.distance);
      return [this.width / 2 + dot(d, right) * f, this.height / 2 - dot(d, up) * f, depth];
    }
    plane() {
      const { right, up } = this.frame();
      return { right, up, perPixel: (depth) => depth / this.focal() };
    }
    /* Returns the product of projection and view, column-major. */
    matrix() {
      const { back, right, up, eye } = this.frame();
      const near = this.distance / 100;
      const far = this.distance * 100;
      const f = 1 / Math.tan(this.angle / 2);
      const fx = (f * this.height) / this.width;
      const [a, b] = [(far + near) / (near - far), (2 * far * near) / (near - far)];
      const column = (r, u, k, w) => [fx * r, f * u, a * k + (w ? b : 0), -k];
      return new Float32Array([
        ...column(right[0], up[0], back[0]),
        ...column(right[1], up[1], back[1]),
        ...column(right[2], up[2], back[2]),
        ...column(-dot(right, eye), -dot(up, eye), -dot(back, eye), true),
      ]);
    }
    move(dx, dy) {
      this.yaw -= dx * 0.008;
      this.pitch = Math.max(-1.5, Math.min(1.5, this.pitch + dy * 0.008));
    }
    zoom(factor) {
      this.distance /= factor;
    }
  }

  const make = (view) => (view.kind === "space" ? new Orbit(view) : new Plane(view));
  return { make, dot, cross, unit };
})();
