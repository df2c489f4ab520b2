"use strict";
/* The large picture: selects the view, the colours of the runs and the camera. */
const Stage = (() => {
  const { $ } = Dom;

  /* Returns the style of a run, which depends on whether it is the only run, one of several, or the
   * reference. */
  function styleOf(run, several, { distinct, joints }) {
    const theme = Theme.now();
    const colour = Theme.ofRun(run);
    const reference = run.index < 0;
    const base = {
      alpha: run.status && !/^stopped at event/.test(run.status) ? 0.35 : 1,
      dash: [],
      hollow: false,
      size: 1,
      rod: 5,
      thin: theme.soft,
      arrow: theme.shapes[1],
      trail: colour,
      trailWidth: 1.8,
      labels: false,
      joints,
      metal: theme.metal,
      of: () => colour,
    };
    if (reference)
      return {
        ...base,
        hollow: true,
        dash: [5, 5],
        rod: 2,
        metal: colour,
        size: 1.25,
        trailWidth: 1.2,
      };
    if (several)
      return {
        ...base,
        rod: 3.5,
        metal: colour,
        arrow: colour,
        size: 0.92,
        alpha: base.alpha * 0.92,
        labels: false,
      };
    return {
      ...base,
      labels: true,
      of: (shape, k) => (distinct ? theme.shapes[k % theme.shapes.length] : colour),
    };
  }

  /* Whether bobs are separate bodies, such as planets: each then has its own colour. */
  const loose = (shapes) =>
    shapes.filter((s) => s.kind === "bob").length > 1 &&
    !shapes.some((s) => ["rod", "spring", "curve", "body"].includes(s.kind));

  const unitOf = (model, { value }) =>
    (model.description.outputs.find((o) => o.index === value.output) || {}).unit;

  class Stage_ {
    constructor(lab) {
      this.lab = lab;
      const { model } = lab;
      this.element = $("stage");
      this.camera = Camera.make(model.view);
      const space = model.view.kind === "space";
      this.distinct = loose(model.shapes);
      /* Pivots are drawn for few rods only: many rods are the bars of a chart. */
      this.joints = model.shapes.filter((s) => s.kind === "rod").length < 5;
      this.box = Shapes.box();
      const level = model.shapes.find((shape) => shape.kind === "level");
      this.levels = level ? new Levels.Contours(Shapes.resolve(level, []), unitOf(model, level)) : null;
      this.graph =
        (model.shapes.length > 0 && model.shapes.every((s) => s.kind === "graph")) ||
        model.shapes.length === 0;
      this.failed = "";
      this.marks = null;
      try {
        this.canvas = space ? $("space") : $("plane");
        this.view = this.graph
          ? new GraphView.View($("plane"), lab)
          : space
            ? new SpaceView.View(this.canvas, this.camera)
            : new PlaneView.View(this.canvas, this.camera);
      } catch (error) {
        this.failed = error.message;
        this.camera = Camera.make({ kind: "plane", axes: ["x", "z"], width: null });
        this.canvas = $("plane");
        this.view = new PlaneView.View(this.canvas, this.camera);
      }
      if (this.graph) this.canvas = $("plane");
      else this.marks = new Marks.View($("marks"), this.camera);
      $("space").hidden = this.canvas.id !== "space";
      $("plane").hidden = this.canvas.id !== "plane";
      this.touched = false;
      new ResizeObserver(() => this.resize()).observe(this.element);
      $("fit").addEventListener("click", () => this.fit());
      this.resize();
    }

    resize() {
      const { width, height } = this.element.getBoundingClientRect();
      if (!width || !height) return;
      this.width = width;
      this.height = height;
      this.camera.resize(width, height);
      if (!this.touched) this.fit();
      this.lab.dirty = true;
    }

    fit() {
      this.touched = false;
      this.camera.fit(this.box, { x: 28, y: 54 });
      this.lab.dirty = true;
    }

    /* Fits the camera to the box of the trial run. */
    frame(box, out) {
      this.box = box;
      const { width } = this.lab.model.view;
      const given = out ? Shapes.value(width ?? null, out) : null;
      this.camera.given = given > 0 ? given : null;
      if (!this.touched) this.fit();
    }

    layers() {
      const { runs } = this.lab;
      const shown = [...runs.list].reverse().filter((run) => !run.refused);
      if (runs.reference) shown.unshift(runs.reference);
      const several = shown.length > 1;
      return shown.map((run) => ({
        run,
        made: run.made && run.madeAt === run.out ? run.made : this.resolve(run),
        style: styleOf(run, several, this),
        trails: run.trails.map(({ shape, trail }) => ({
          trail,
          colour: !several && this.distinct ? this.colourAt(shape.at) : null,
        })),
      }));
    }

    /* Returns the colour of the body that a trail follows. */
    colourAt(at) {
      const bodies = this.lab.model.shapes.filter((s) => s.kind === "bob" || s.kind === "body");
      const k = bodies.findIndex((s) => JSON.stringify(s.at) === JSON.stringify(at));
      return k < 0 ? null : Theme.now().shapes[k % 4];
    }

    resolve(run) {
      run.made = Shapes.resolveAll(this.lab.model.shapes, run.out);
      run.madeAt = run.out;
      return run.made;
    }

    draw() {
      const { lab } = this;
      if (!this.width || lab.settings.view !== "scene") return;
      if (this.levels && !lab.runs.error)
        this.levels.update(
          lab.engine,
          lab.runs.start,
          this.camera.scale ? this.camera : this.flat(),
        );
      const scene = {
        width: this.width,
        height: this.height,
        runs: this.layers(),
        levels: this.levels,
        unit: lab.model.time ? "m" : "",
        box: this.box,
      };
      this.view.draw(scene);
      if (this.marks) this.marks.draw(scene);
    }

    /* Returns a camera of the plane z = 0 around the target, for contours in a view of space. */
    flat() {
      const { target, distance, angle } = this.camera;
      return {
        centre: target.slice(0, 2),
        width: 2,
        height: 2,
        scale: 1 / (distance * Math.tan(angle / 2)),
      };
    }

    drawn() {
      return this.view.drawn;
    }
  }

  return { make: (lab) => new Stage_(lab) };
})();
