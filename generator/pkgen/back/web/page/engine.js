"use strict";
/* The model and the runtime in WebAssembly (live.c), as the page calls them. Parameters are a flat
 * Float64Array in the order of the description; q has the coordinates, v the rates and behind them
 * the first-order variables. All numbers are in SI. */
const Engine = (() => {
  /* What wasi-libc imports: nothing is written anywhere, and nothing is read. */
  const WASI = { fd_close: () => 0, fd_seek: () => 70, fd_write: () => 0, fd_fdstat_get: () => 0,
    proc_exit: (code) => { throw new Error("the model's code ended with " + code); } };
  const BUDGET = 20000;    /* steps between two looks at the clock */
  const PATIENCE = 1500;   /* milliseconds that one advance may take */

  async function load(bytes, description) {
    const imports = new Proxy(WASI, { get: (known, name) => known[name] || (() => 0) });
    const { instance } = await WebAssembly.instantiate(bytes, { wasi_snapshot_preview1: imports });
    if (instance.exports._initialize) instance.exports._initialize();
    return new Engine_(instance.exports, description);
  }

  class Engine_ {
    constructor(c, description) {
      this.c = c;
      this.description = description;
      this.base = c.live_params();
      if (!this.base) throw new Error("there is no memory");
      this.n = c.live_n(this.base);
      this.nq = c.live_n_q(this.base);
      this.count = c.live_parameters(this.base);
      this.inputs = description.inputs.length;
      this.nOut = description.outputs.length;
      this.constants = description.constants;
      this.claims = this.constants.filter((x) => x.kind === "claim").length;
      this.sets = new Map();                            /* prepared parameters by their values */
      this.room = c.malloc(8 * (4 * this.n + this.inputs + Math.max(this.nOut, this.claims, 1)));
    }

    /* Views die when memory grows, so each is made anew. */
    reals(at, length) {
      return new Float64Array(this.c.memory.buffer, at, length);
    }

    text(at) {
      const bytes = new Uint8Array(this.c.memory.buffer, at);
      return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
    }

    write(values) {
      const at = this.c.malloc(8 * Math.max(values.length, 1));
      this.reals(at, values.length).set(values);
      return at;
    }

    word(text) {
      const bytes = new TextEncoder().encode(text + "\0");
      const at = this.c.malloc(bytes.length);
      new Uint8Array(this.c.memory.buffer, at, bytes.length).set(bytes);
      return at;
    }

    /* Defaults and starts of the description: those of the chosen scene. */
    defaults() {
      const params = new Float64Array(this.count).fill(NaN);
      for (const p of this.description.parameters) if (!p.follows) params[p.index] = p.value;
      return this.given(params);
    }

    /* All parameters, and the start, where those that are not a number follow the others. */
    given(params) {
      const { c } = this;
      const at = this.write(params);
      const good = c.live_set(this.base, at);
      const all = this.reals(at, this.count).slice();
      c.free(at);
      if (!good) throw new Error(this.text(c.live_why()));
      const start = c.malloc(16 * this.n);
      c.live_start(this.base, start, start + 8 * this.n);
      const [q, v] = [this.reals(start, this.nq).slice(), this.reals(start + 8 * this.n, this.n).slice()];
      c.free(start);
      this.asDescribed(all, q, v);
      return { params: all, q, v };
    }

    /* Starts that scene and options give stand in the description: they hold as long as the
     * parameters are its own. */
    asDescribed(all, q, v) {
      const { parameters, coordinates, states } = this.description;
      if (!parameters.every((p) => p.value === null || p.value === all[p.index])) return;
      for (const x of coordinates) {
        if (x.q !== null) q[x.index] = x.q;
        if (x.v !== null) v[x.index] = x.v;
      }
      for (const x of states) if (x.value !== null) v[x.index] = x.value;
    }

    /* null, or why these parameters cannot be. */
    prepare(params) {
      try {
        this.prepared(params);
        return null;
      } catch (error) {
        return error.message;
      }
    }

    /* The struct of these parameters, kept for the next call. */
    prepared(params) {
      const key = params.join();
      if (this.sets.has(key)) return this.sets.get(key);
      const { c } = this;
      if (this.sets.size > 64) this.sets.clear();       /* leaks little: one struct a setting */
      const made = c.live_params();
      const at = this.write(params);
      const good = made && c.live_set(made, at);
      c.free(at);
      if (!good) throw new Error(this.text(c.live_why()));
      this.sets.set(key, made);
      return made;
    }

    /* Puts a state into the room of all calls: addresses of q, v, u, and of the answer. */
    state(q, v, u) {
      const [at, n] = [this.room, this.n];
      this.reals(at, n).fill(0);
      this.reals(at, n).set(q);
      this.reals(at + 8 * n, n).set(v);
      const inputs = this.reals(at + 16 * n, this.inputs);
      inputs.fill(0);
      if (u) inputs.set(u);
      return [at, at + 8 * n, at + 16 * n, at + 16 * n + 8 * this.inputs];
    }

    outputs(params, t, q, v, u) {
      const [a, b, c, out] = this.state(q, v, u);
      const found = this.c.live_outputs(this.prepared(params), t, a, b, c, out);
      return found ? this.reals(out, this.nOut).slice() : new Float64Array(0);
    }

    energy(params, t, q, v, u) {
      const [a, b, c] = this.state(q, v, u);
      return this.c.live_energy(this.prepared(params), t, a, b, c);
    }

    momenta(params, t, q, v, u) {
      const [a, b, c, out] = this.state(q, v, u);
      const rest = this.c.malloc(16 * this.n);
      const good = this.c.live_momenta(this.prepared(params), t, a, b, c, rest, rest + 8 * this.n);
      const found = this.reals(rest, this.n).slice();
      this.c.free(rest);
      return good && out ? found : found.fill(NaN);
    }

    claimed(params, t, q, v, u) {
      const [a, b, c, out] = this.state(q, v, u);
      const good = this.c.live_claims(this.prepared(params), t, a, b, c, out);
      return good ? this.reals(out, this.claims).slice() : new Float64Array(this.claims).fill(NaN);
    }

    /* What the description proves constant, in its order. */
    constantsAt(params, t, q, v, u) {
      const kinds = new Set(this.constants.map((x) => x.kind));
      const claims = kinds.has("claim") ? this.claimed(params, t, q, v, u) : [];
      const momenta = kinds.has("momentum") ? this.momenta(params, t, q, v, u) : [];
      const energy = kinds.has("energy") ? this.energy(params, t, q, v, u) : NaN;
      return Float64Array.from(this.constants, (x) =>
        x.kind === "energy" ? energy : x.kind === "claim" ? claims[x.index] : momenta[x.index]);
    }

    motion(asked) {
      return new Motion(this, asked);
    }

    swarm(asked) {
      return new Swarm(this, asked);
    }
  }

  /* One trajectory. Throws with words where method, settings or start are refused. */
  class Motion {
    constructor(engine, { method, step, rtol, params, q, v, t = 0, inputs = null }) {
      const { c, n } = engine;
      this.engine = engine;
      this.params = params;
      this.inputs = inputs;
      const own = engine.prepared(params);
      const [name, start] = [engine.word(method), c.malloc(8 * (2 * n + engine.inputs))];
      const room = engine.reals(start, 2 * n + engine.inputs);
      room.fill(0);
      room.set(q, 0);
      room.set(v, n);
      if (inputs) room.set(inputs, 2 * n);
      const h = step ?? this.usual(engine, method);
      this.at = c.live_new(own, name, h, rtol ?? 0, t, start, start + 8 * n, start + 16 * n);
      c.free(name);
      c.free(start);
      if (!this.at) throw new Error(engine.text(c.live_why()));
      this.step = step ?? h;
      this.read();
    }

    /* A step for a method that must have one, of a hundredth of a unit of time where nothing is
     * known; an adaptive one begins by itself. */
    usual(engine, method) {
      const known = engine.description.methods.find((x) => x.name === method);
      return known && (known.adaptive || known.exact) && !known.fixed ? 0 : engine.description.run.step || 0.01;
    }

    read() {
      const { c, n, nq } = this.engine;
      this.t = c.live_t(this.at);
      this.q = this.engine.reals(c.live_q(this.at), nq).slice();
      this.v = this.engine.reals(c.live_v(this.at), n).slice();
      this.steps = c.live_steps(this.at);
      this.evaluations = c.live_evaluations(this.at);
    }

    /* To t: "" or the status in words. One that takes too long for a page is given up. */
    advance(t) {
      const { c } = this.engine;
      const until = performance.now() + PATIENCE;
      let code = 1;
      while (code === 1) {
        code = c.live_to(this.at, t, BUDGET);
        if (code === 1 && performance.now() > until) {
          this.read();
          return "its steps are too many for a live page: choose a longer one, or a looser tolerance";
        }
      }
      this.read();
      return code ? this.engine.text(c.live_reason(this.at)) : "";
    }

    energy() {
      return this.engine.energy(this.params, this.t, this.q, this.v, this.inputs);
    }

    outputs() {
      return this.engine.outputs(this.params, this.t, this.q, this.v, this.inputs);
    }

    constants() {
      return this.engine.constantsAt(this.params, this.t, this.q, this.v, this.inputs);
    }

    /* Crossings since the last call. */
    events() {
      const { c } = this.engine;
      const at = c.live_crossings(this.at);
      const count = c.live_take_crossings(this.at);
      const pairs = this.engine.reals(at, 2 * count);
      return Array.from({ length: count }, (_, k) => ({ event: pairs[2 * k], t: pairs[2 * k + 1] }));
    }

    free() {
      if (this.at) this.engine.c.live_free(this.at);
      this.at = 0;
    }
  }

  /* Many members side by side. `table`: {columns: [{kind: "q"|"v"|"p", index}], values} row by row. */
  class Swarm {
    constructor(engine, { method, step, rtol, params, q, v, table, members }) {
      const { c, n, nq } = engine;
      this.engine = engine;
      this.members = members;
      const start = engine.given(params);
      const size = c.live_params_size();
      const own = table.columns.some((x) => x.kind === "p");
      this.params = c.malloc(size * members);
      if (!this.params) throw new Error("there is no memory");
      const all = params.slice();
      const width = table.columns.length;
      for (let i = 0; i < members; i++) {
        table.columns.forEach(({ kind, index }, k) => {
          if (kind === "p") all[index] = table.values[i * width + k];
        });
        if (own || i === 0) this.shared = engine.prepared(all);
        const bytes = new Uint8Array(c.memory.buffer);
        bytes.copyWithin(this.params + i * size, this.shared, this.shared + size);
      }
      const name = engine.word(method);
      this.at = c.live_swarm_new(this.params, name, step ?? 0.01, rtol ?? 0, members);
      c.free(name);
      if (!this.at) throw new Error(engine.text(c.live_why()));
      const states = engine.reals(c.live_swarm_states(this.at), 2 * n * members);
      const [q0, v0] = [q ?? start.q, v ?? start.v];
      for (let i = 0; i < members; i++) {
        states.set(q0, i * n);
        states.set(v0, n * members + i * n);
        table.columns.forEach(({ kind, index }, k) => {
          const x = table.values[i * width + k];
          if (kind === "q") states[i * n + index] = x;
          if (kind === "v") states[n * members + i * n + index] = x;
        });
      }
      this.width = nq + n;
    }

    /* "" or what became of them. */
    advance(t) {
      const going = this.engine.c.live_swarm_to(this.at, t);
      return going ? "" : "no member goes on: the step is too long, or the motion ends";
    }

    /* Of each member q, then v. */
    states() {
      const { c, n, nq } = this.engine;
      const { members, width } = this;
      const all = this.engine.reals(c.live_swarm_states(this.at), 2 * n * members);
      const found = new Float64Array(members * width);
      for (let i = 0; i < members; i++) {
        for (let k = 0; k < nq; k++) found[i * width + k] = all[i * n + k];
        for (let k = 0; k < n; k++) found[i * width + nq + k] = all[n * members + i * n + k];
      }
      return found;
    }

    free() {
      if (this.at) {
        this.engine.c.live_swarm_free(this.at);
        this.engine.c.free(this.params);
      }
      this.at = 0;
    }
  }

  return { load };
})();
