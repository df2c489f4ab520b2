"use strict";
/* Dragging on the canvas. A dragged body follows the pointer as far as the model allows: damped
 * least squares, with difference quotients of the outputs as Jacobian, find coordinates that bring
 * it there. A drag of the background moves the view. */
const Drag = (() => {
  const REACH = 24; /* pixels: largest distance from pointer to handle */
  const CLOSE = 0.05; /* pixels: the least squares end when the body is this close to the pointer */
  const ROUNDS = 40;

  /* Returns the unknowns: the coordinates, and three rotation angles per rotation. */
  function variables(model) {
    const list = model.description.coordinates
      .filter((c) => model.byKey.has("q" + c.index))
      .map((c) => ({ kind: "q", index: c.index, angle: c.unit === "rad" || c.periodic }));
    (model.description.rotations || []).forEach((_, k) => {
      for (let axis = 0; axis < 3; axis++) list.push({ kind: "r", rotation: k, axis, angle: true });
    });
    return list;
  }

  const multiply = ([a, b, c, d], [e, f, g, h]) => [
    a * e - b * f - c * g - d * h,
    a * f + b * e + c * h - d * g,
    a * g - b * h + c * e + d * f,
    a * h + b * g - c * f + d * e,
  ];

  /* Returns the state with its unknowns changed by dx. */
  function moved(model, list, state, dx) {
    const q = state.q.slice();
    const v = state.v.slice();
    list.forEach((x, k) => {
      if (x.kind === "q") q[x.index] += dx[k];
      else if (dx[k]) {
        const at = model.description.rotations[x.rotation].quaternion.map(
          (name) => model.byName.get(name).index,
        );
        const turn = [Math.cos(dx[k] / 2), 0, 0, 0];
        turn[1 + x.axis] = Math.sin(dx[k] / 2);
        multiply(
          turn,
          at.map((i) => v[i]),
        ).forEach((y, i) => {
          v[at[i]] = y;
        });
      }
    });
    return { params: state.params, q, v };
  }

  /* Returns the state in which a point of the drawing is projected as near as possible to the pixel
   * `target`; read(outputs) returns the point. */
  function solve(lab, list, state, read, camera, target) {
    const { engine, model } = lab;
    const { right, up, perPixel } = camera.plane();
    const place = (s) => read(engine.outputs(s.params, 0, s.q, s.v));
    const miss = (p) => {
      const [x, y] = camera.project(p);
      return [target[0] - x, target[1] - y];
    };
    const size = (r) => r[0] * r[0] + r[1] * r[1];
    let now = state;
    let p = place(now);
    let r = miss(p);
    let damping = 1e-6;
    for (let round = 0; round < ROUNDS && size(r) > CLOSE * CLOSE; round++) {
      const pixel = perPixel(camera.project(p)[2]);
      const columns = list.map((x, k) => {
        const h = x.angle ? 1e-5 : Math.max(1e-9, pixel * 0.05);
        const dx = new Float64Array(list.length);
        dx[k] = h;
        const a = place(moved(model, list, now, dx));
        dx[k] = -h;
        const b = place(moved(model, list, now, dx));
        const d = a.map((y, i) => (y - b[i]) / (2 * h) / pixel);
        return [Camera.dot(d, right), -Camera.dot(d, up)].map((y) => (Number.isFinite(y) ? y : 0));
      });
      /* Unknowns are scaled: a change by 1 is one radian for an angle, 100 pixels for a length. */
      const scale = list.map((x) => (x.angle ? 1 : pixel * 100));
      const J = columns.map((c, k) => c.map((y) => y * scale[k]));
      let [a, b, d] = [0, 0, 0];
      for (const [x, y] of J) {
        a += x * x;
        b += x * y;
        d += y * y;
      }
      const trace = a + d;
      if (!(trace > 0)) break;
      const lambda = damping * trace;
      const determinant = (a + lambda) * (d + lambda) - b * b;
      const w = [
        ((d + lambda) * r[0] - b * r[1]) / determinant,
        ((a + lambda) * r[1] - b * r[0]) / determinant,
      ];
      let dx = J.map(([x, y], k) => scale[k] * (x * w[0] + y * w[1]));
      const longest = Math.max(...dx.map((x, k) => Math.abs(x / scale[k])));
      if (longest > 0.7) dx = dx.map((x) => (x * 0.7) / longest);
      const next = moved(model, list, now, dx);
      const nextPlace = place(next);
      const nextMiss = miss(nextPlace);
      if (size(nextMiss) < size(r)) {
        if (size(r) - size(nextMiss) < 1e-8 * size(r)) break;
        [now, p, r] = [next, nextPlace, nextMiss];
        damping = Math.max(1e-9, damping / 4);
      } else {
        damping *= 10;
        if (damping > 1e4) break;
      }
    }
    return now;
  }

  /* Returns the state projected to the constraints, or null if the projection fails. */
  function allowed(lab, state) {
    if (!(lab.model.description.constraints || []).length) return state;
    try {
      const motion = lab.engine.motion({
        ...lab.settings.methods[0],
        step: lab.stepOf(lab.settings.methods[0]),
        ...state,
        t: 0,
      });
      const q = motion.q;
      motion.free();
      return { ...state, q };
    } catch (error) {
      return null;
    }
  }

  function make(lab) {
    const { stage, model } = lab;
    const { canvas } = stage;
    const list = variables(model);
    const pointers = new Map();
    let held = null;
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };

    function nearest([x, y]) {
      const run = lab.runs.list.find((r) => !r.refused);
      if (!run || stage.graph) return null;
      let best = null;
      for (const handle of Shapes.handles(stage.resolve(run))) {
        const [px, py] = stage.camera.project(handle.point);
        const far = Math.hypot(px - x, py - y);
        /* If the draggable points of a body and of a rod coincide, the body is dragged. */
        const rank = far - (handle.of.kind === "bob" || handle.of.kind === "body" ? 4 : 0);
        if (far < REACH && (!best || rank < best.rank)) best = { ...handle, rank, run, px, py };
      }
      return best;
    }

    function take(handle, [x, y]) {
      const { run } = handle;
      const start = lab.runs.start;
      const base =
        lab.runs.t > 0 ? restState(run, start) : { params: start.params, q: start.q, v: start.v };
      held = { ...handle, state: base, was: lab.playing, off: [handle.px - x, handle.py - y] };
      lab.pause();
      document.body.classList.add("dragging");
    }

    /* A drag during a motion makes a start from the current coordinates and the initial rates. */
    function restState(run, start) {
      const v = start.v.slice();
      for (const rotation of model.description.rotations || [])
        for (const name of rotation.quaternion) {
          const { index } = model.byName.get(name);
          v[index] = run.v[index];
        }
      return { params: start.params, q: run.q.slice(), v };
    }

    function pull(point) {
      const target = [point[0] + held.off[0], point[1] + held.off[1]];
      const { camera } = stage;
      let state = held.state;
      const tied = (model.description.constraints || []).length > 0;
      for (let k = 0; k < (tied ? 4 : 1); k++) {
        const next = allowed(lab, solve(lab, list, state, held.read, camera, target));
        if (!next) break;
        state = next;
      }
      held.state = state;
      lab.startFrom(state);
    }

    canvas.addEventListener("pointerdown", (event) => {
      if (event.button > 0) return;
      canvas.setPointerCapture(event.pointerId);
      const point = at(event);
      pointers.set(event.pointerId, point);
      if (pointers.size === 1) {
        const handle = nearest(point);
        if (handle) take(handle, point);
      } else if (held) release();
      event.preventDefault();
      canvas.focus({ preventScroll: true });
    });

    canvas.addEventListener("pointermove", (event) => {
      const point = at(event);
      const old = pointers.get(event.pointerId);
      if (!old) {
        canvas.style.cursor = nearest(point) ? "grab" : "";
        return;
      }
      if (held) held.wish = point;
      else if (!stage.graph) {
        stage.touched = true;
        if (pointers.size === 2) {
          const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, p]) => p);
          const spread = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
          stage.camera.zoom(spread(point) / spread(old), other[0], other[1]);
        } else stage.camera.move(point[0] - old[0], point[1] - old[1]);
        lab.dirty = true;
      }
      pointers.set(event.pointerId, point);
    });

    function release() {
      if (held.wish) pull(held.wish);
      const { was } = held;
      held = null;
      document.body.classList.remove("dragging");
      lab.changed();
      if (was) lab.play();
    }
    const up = (event) => {
      pointers.delete(event.pointerId);
      if (held && pointers.size === 0) release();
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener(
      "wheel",
      (event) => {
        if (stage.graph) return;
        event.preventDefault();
        stage.touched = true;
        const [x, y] = at(event);
        stage.camera.zoom(Math.exp(-event.deltaY * 0.0015), x, y);
        lab.dirty = true;
      },
      { passive: false },
    );
    canvas.addEventListener("dblclick", (event) => {
      if (!nearest(at(event))) stage.fit();
    });

    return {
      /* Called once per frame: moves the body to the last position of the pointer. */
      frame() {
        if (!held || !held.wish) return;
        const { wish } = held;
        held.wish = null;
        pull(wish);
      },
      holding: () => Boolean(held),
      can: () =>
        !stage.graph &&
        lab.runs.list.some((run) => !run.refused && Shapes.handles(stage.resolve(run)).length > 0),
    };
  }

  return { make, solve, variables };
})();
