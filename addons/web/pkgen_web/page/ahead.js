"use strict";
/* Integrates a copy of the first run ahead of the clock, to collect points of a Poincaré
 * section. */
const Ahead = (() => {
  const ENOUGH = 3000;

  class Ahead_ {
    constructor(lab) {
      this.lab = lab;
      this.run = null;
      this.start = null;
    }

    /* Integrates for `budget` milliseconds; returns whether the section still lacks points. */
    more(event, budget) {
      const { lab } = this;
      if (this.start !== lab.runs.start) {
        this.free();
        this.start = lab.runs.start;
        this.t = 0;
        try {
          this.run = Runs.one(lab, lab.settings.methods[0], this.start);
        } catch (error) {
          this.run = null;
        }
      }
      const until = performance.now() + budget;
      while (this.run && !this.run.status && this.run.sections[event].t.length < ENOUGH) {
        if (performance.now() > until) return true;
        this.t += lab.natural / 40;
        this.run.advance(this.t);
        this.run.sample(lab.model, null);
      }
      return false;
    }

    free() {
      if (this.run) this.run.free();
      this.run = null;
    }
  }

  return { make: (lab) => new Ahead_(lab) };
})();
