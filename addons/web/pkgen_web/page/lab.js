"use strict";
/* The main object of the page: it holds the clock, the settings, the runs and the views. */
const Lab = (() => {
  const { $, say } = Dom;
  const TICKS = 60; /* samples per second of real time */
  const BUDGET = 13; /* ms per frame for integration */
  const WORDS_EVERY = 90; /* ms */
  const HEADS = [1, 2, 5];

  class Lab_ {
    constructor(engine, model) {
      this.engine = engine;
      this.model = model;
      this.nq = engine.defaults().q.length;
      this.nv = engine.defaults().v.length;
      this.settings = Settings.read(model, location.hash);
      this.natural = 1;
      this.rtol = (model.description.run || {}).rtol || null; /* default of `pkgen run` */
      this.base = 1;
      this.playing = false;
      this.dirty = true;
      this.behind = 0;
      this.slow = 1;
      this.runs = Runs.make(this);
      this.swarm = Swarm.make(this);
    }

    open() {
      this.restart();
      this.stage = Stage.make(this);
      this.look();
      this.restart();
      this.drag = Drag.make(this);
      this.panels = Panels.make(this);
      this.sheets = {
        values: SheetValues.make(this),
        methods: SheetMethods.make(this),
        swarm: SheetSwarm.make(this),
        model: SheetModel.make(this),
        map: SheetMap.make(this),
      };
      this.shown();
      requestAnimationFrame((now) => this.frame(now));
    }

    /* Returns the simulated time per second of real time: the model's natural speed times 1, 2, 5,
     * 10, ..., as the user has set. */
    speed() {
      const n = this.settings.speed;
      return this.base * HEADS[((n % 3) + 3) % 3] * 10 ** Math.floor(n / 3);
    }

    /* Returns the step of a method: the one that the user has set; otherwise null for an adaptive
     * method, and a hundredth of the natural period for a method with fixed steps. */
    stepOf({ method, step }) {
      if (step) return step;
      return (this.model.methodNamed.get(method) || {}).adaptive
        ? null
        : Ranges.nice(this.natural / 100);
    }

    look() {
      if (this.runs.error) return;
      const { start } = this.runs;
      const { speed, box, period, moving } = Trial.look(this, start);
      this.first = moving || this.first;
      this.base = speed;
      this.natural = period || speed * 3;
      this.stage.frame(box, this.engine.outputs(start.params, 0, start.q, start.v));
      this.clock();
    }

    restart() {
      this.runs.restart();
      this.clock();
      this.swarm.restart();
      if (this.sheets) this.shown();
      this.dirty = true;
    }

    /* Restarts the count of ticks at the present time. The time of each tick is this time plus an
     * exact multiple of the tick's length. */
    clock() {
      this.from = this.now = this.runs.t;
      this.count = 0;
      this.behind = 0;
    }

    startFrom(state) {
      for (const c of this.model.description.coordinates)
        if (this.model.byKey.has("q" + c.index))
          this.settings.values.set("q" + c.index, state.q[c.index]);
      for (const s of this.model.description.states || [])
        if (this.model.isQuaternion(s.name))
          this.settings.values.set("v" + s.index, state.v[s.index]);
      for (const key of [...this.settings.values.keys()])
        if (key.startsWith("r")) this.settings.values.delete(key);
      this.restart();
    }

    enter(scene) {
      const { speed, panels, reference } = this.settings;
      /* If the previous scene was a swarm, the swarm view is closed when that scene is left. */
      const left = Settings.usual(this.model, this.settings.scene) === "swarm";
      const view = left ? "scene" : this.settings.view;
      this.settings = Settings.enter(
        this.model,
        { ...Settings.fresh(), speed, panels, view, reference },
        scene,
      );
      this.restart();
      this.look();
      this.restart();
      this.sheets.methods.build();
      this.changed();
    }

    show(view) {
      this.settings.view = view;
      this.swarm.restart();
      this.shown();
      this.changed();
    }

    /* Writes the settings to the page's address. */
    changed() {
      const text = Settings.write(this.model, this.settings);
      history.replaceState(null, "", text ? "#" + text : location.pathname + location.search);
    }

    shown() {
      this.sheets.values.refresh();
      this.sheets.swarm.refresh();
      const view = this.settings.view;
      $("cloud").hidden = view !== "swarm";
      this.stage.canvas.hidden = view === "swarm";
      for (const name of ["scene", "swarm"])
        $("view-" + name).setAttribute("aria-pressed", String(view === name));
      $("hint").hidden = view === "swarm";
      $("fit").hidden = view === "swarm" || this.stage.graph;
      $("scene").value = this.settings.scene || "";
      say(
        $("speed-is"),
        this.model.time ? `${Text.number(this.speed())}×` : `${Text.number(this.speed())} per s`,
      );
      $("speed").value = this.settings.speed;
      say($("note"), this.runs.error || this.stage.failed || "");
      this.legend();
      this.dirty = true;
    }

    legend() {
      const { list, reference } = this.runs;
      const rows = [...list, ...(reference ? [reference] : [])];
      Dom.fill(
        $("legend"),
        ...(rows.length > 1
          ? rows.map((run) =>
              Dom.h(
                "li",
                { class: run.index < 0 ? "m-ref" : "m" + run.index },
                Dom.h("span", { class: "swatch", "aria-hidden": "true" }),
                run.spec.method +
                  (run.spec.step ? `, step ${Text.number(run.spec.step)}` : "") +
                  (run.index < 0 ? " (reference)" : ""),
                run.status ? Dom.h("em", null, " stopped") : null,
              ),
            )
          : []),
      );
      this.stopped = rows.map((run) => run.status).join();
    }

    play() {
      if (this.runs.error) return;
      this.playing = true;
      this.behind = 0;
      document.body.classList.add("playing");
      $("play").setAttribute("aria-label", "Pause");
    }

    pause() {
      this.playing = false;
      this.dirty = true;
      document.body.classList.remove("playing");
      $("play").setAttribute("aria-label", "Play");
    }

    toggle() {
      if (this.playing) this.pause();
      else this.play();
    }

    setSpeed(n) {
      this.settings.speed = Math.max(-12, Math.min(12, n));
      this.clock();
      this.shown();
      this.changed();
    }

    tick() {
      this.count++;
      this.now = this.from + (this.count * this.speed()) / TICKS;
      this.runs.advance(this.now);
      this.dirty = true;
    }

    /* Advances the runs by the ticks that are due, for at most BUDGET milliseconds. Ticks that are
     * then left over are dropped: the motion is slower than requested, and the slowdown is
     * recorded. */
    ticks(seconds) {
      this.behind += seconds * TICKS;
      const begun = performance.now();
      const asked = Math.floor(this.behind);
      let done = 0;
      while (this.behind >= 1 && performance.now() - begun < BUDGET) {
        this.tick();
        this.behind -= 1;
        done++;
      }
      if (this.behind >= 1) this.behind %= 1;
      if (asked) this.slow = 0.95 * this.slow + 0.05 * (done / asked);
      if (!this.runs.alive().length && this.settings.view !== "swarm") this.pause();
    }

    frame(now) {
      requestAnimationFrame((next) => this.frame(next));
      const seconds = Math.min(0.1, Math.max(0, (now - (this.last ?? now)) / 1000));
      this.last = now;
      if (this.playing) this.ticks(seconds);
      this.drag.frame();
      if (!this.dirty) return;
      this.dirty = false;
      this.frames = (this.frames || 0) + 1;
      if (this.settings.view === "swarm") {
        this.swarm.advance(this.now);
        this.swarm.draw(this.stage.width, this.stage.height);
      }
      else this.stage.draw();
      say($("time"), time(this.runs.t, this.natural, this.model.time));
      this.charts();
      if (now - (this.told || 0) > WORDS_EVERY) this.slowly(now);
      else
        this.due =
          this.due ||
          setTimeout(() => {
            this.due = 0;
            this.slowly(performance.now());
          }, WORDS_EVERY);
    }

    /* Updates the charts. During play they take at most half of the time: an update that took
     * longer than a frame is followed by a pause of the same length. */
    charts() {
      const now = performance.now();
      if (this.playing && now - this.charted < this.cost) return;
      this.panels.update();
      this.charted = performance.now();
      this.cost = this.charted - now;
    }

    slowly(now) {
      this.told = now;
      this.sheets.methods.counts();
      this.sheets.swarm.refresh();
      if (
        this.runs
          .all()
          .map((run) => run.status)
          .join() !== this.stopped
      )
        this.legend();
      const words =
        this.runs.error ||
        this.stage.failed ||
        (this.playing && this.slow < 0.8
          ? "Slower than asked: this machine does not keep up."
          : "") ||
        this.runs.list
          .filter((run) => run.status && !run.refused)
          .map(
            (run) => (this.runs.list.length > 1 ? `${run.spec.method}: ` : "") + run.status,
          )[0] ||
        "";
      say($("note"), Text.shorter(words));
      $("note").classList.toggle("calm", /stopped at event/.test(words));
    }
  }

  /* Returns a time as text. Slow motions are shown with fewer decimals than fast ones. */
  function time(t, natural, unit) {
    const places = Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(natural || 1))));
    return Text.minus(t.toFixed(places)) + (unit ? " " + unit : "");
  }

  return { make: (engine, model) => new Lab_(engine, model) };
})();
