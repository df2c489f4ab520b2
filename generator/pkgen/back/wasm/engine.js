"use strict";
/* Calls the model and the runtime, compiled to WebAssembly (live/). Parameters are a flat
 * Float64Array in the order of the description; q has the coordinates, v the rates and after them
 * the first-order variables. All numbers are in SI. */
const Engine = (() => {
  /* Stubs of the system calls that wasi-libc imports: no file is read or written. */
  const WASI = { fd_close: () => 0, fd_seek: () => 70, fd_write: () => 0, fd_fdstat_get: () => 0,
    proc_exit: (code) => { throw new Error("the model's code ended with " + code); } };
  const BUDGET = 20000;    /* integration steps between two checks of the time */
  const PATIENCE = 1500;   /* longest time of a call of advance, in ms */
  const KEPT = 16;         /* parameter sets kept in memory while unused */

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
      this.base = c.live_params(1, 1);
      if (!this.base) throw new Error("there is no memory");
      this.n = c.live_n(this.base);
      this.nq = c.live_n_q(this.base);
      this.count = c.live_parameters(this.base);
      this.inputs = description.inputs.length;
      this.nOut = description.outputs.length;
      this.constants = description.constants;
      this.claims = this.constants.filter((x) => x.kind === "claim").length;
      this.sets = new Map();                            /* prepared parameter sets, by their values */
      this.room = c.malloc(8 * (4 * this.n + this.inputs + Math.max(this.nOut, this.claims, 1)));
    }

    /* Makes a new view each time: views become invalid when WebAssembly's memory grows. */
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

    /* Parameters and initial state of the description, which has those of the chosen scene. */
    defaults() {
      const params = new Float64Array(this.count).fill(NaN);
      for (const p of this.description.parameters) if (!p.follows) params[p.index] = p.value;
      return this.given(params);
    }

    /* All parameters, and the initial state; parameters that are NaN get their default values. */
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

    /* Initial values that the scene or options set are in the description. Values that depend on
     * parameters are used only while all parameters are those of the description. */
    asDescribed(all, q, v) {
      const { parameters, coordinates, states, rotations } = this.description;
      const own = parameters.every((p) => p.value === null || p.value === all[p.index]);
      const put = (to, index, value, follows) => {
        if (value !== null && (own || !follows)) to[index] = value;
      };
      for (const x of coordinates) {
        put(q, x.index, x.q, x.q_follows);
        put(v, x.index, x.v, x.v_follows);
      }
      for (const x of states) put(v, x.index, x.value, x.follows);
      for (const r of rotations)
        r.rate_indices.forEach((k, i) => put(v, k, r.rate_values[i], r.rates_follow[i]));
    }

    /* Returns null, or the error message for invalid parameters. */
    prepare(params) {
      try {
        this.prepared(params);
        return null;
      } catch (error) {
        return error.message;
      }
    }

    /* Address of the parameter struct. The latest structs, and those that motions use, are kept. */
    prepared(params) {
      return this.set(params).at;
    }

    set(params) {
      const key = params.join();
      let set = this.sets.get(key);
      if (set) this.sets.delete(key);
      else set = { key, at: this.made(params), users: 0 };
      this.sets.set(key, set);                          /* The map's last entry is the newest. */
      if (this.sets.size > KEPT) this.forget();
      return set;
    }

    made(params) {
      const { c } = this;
      const [made, at] = [c.live_params(1, 1), this.write(params)];
      const good = made && c.live_set(made, at);
      c.free(at);
      if (good) return made;
      c.free(made);
      throw new Error(made ? this.text(c.live_why()) : "there is no memory");
    }

    forget() {
      let many = this.sets.size - KEPT;
      const last = Array.from(this.sets.values()).pop();
      for (const set of this.sets.values()) {
        if (many <= 0 || set === last) return;
        if (set.users) continue;
        this.c.free(set.at);
        this.sets.delete(set.key);
        many--;
      }
    }

    /* Copies a state to the common buffer; returns the addresses of q, v, u and of the result. */
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

    /* Values of the constants of the motion in the description, in its order. */
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
      return new EngineSwarm(this, asked);
    }
  }

  /* One trajectory. Throws an error with a message if method, settings or start are invalid. */
  class Motion {
    constructor(engine, { method, step, rtol, params, q, v, t = 0, inputs = null }) {
      const { c, n } = engine;
      this.engine = engine;
      this.params = params;
      this.inputs = inputs;
      const own = engine.set(params);
      const [name, start] = [engine.word(method), c.malloc(8 * (2 * n + engine.inputs))];
      const room = engine.reals(start, 2 * n + engine.inputs);
      room.fill(0);
      room.set(q, 0);
      room.set(v, n);
      if (inputs) room.set(inputs, 2 * n);
      const h = step ?? this.usual(engine, method);
      const tolerance = rtol ?? engine.description.run.rtol;
      this.at = c.live_new(own.at, name, h, tolerance, t, start, start + 8 * n, start + 16 * n);
      c.free(name);
      c.free(start);
      if (!this.at) throw new Error(engine.text(c.live_why()));
      this.own = own;
      own.users++;
      this.step = step ?? h;
      this.read();
    }

    /* Default step: 0 for an adaptive method, which chooses its own, and for an exact one; otherwise
     * that of the description, or 0.01. */
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

    /* Advances to t. Returns "" or an error message, also if it takes longer than PATIENCE. */
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

    /* Events since the last call. */
    events() {
      const { c, n, nq } = this.engine;
      const count = c.live_take_crossings(this.at);
      const width = 2 + 2 * n;
      const all = this.engine.reals(count ? c.live_crossings(this.at) : 0, count * width).slice();
      return Array.from({ length: count }, (_, k) => {
        const one = all.subarray(k * width, (k + 1) * width);
        return { event: one[0], t: one[1], q: one.slice(2, 2 + nq), v: one.slice(2 + n) };
      });
    }

    free() {
      if (!this.at) return;
      this.engine.c.live_free(this.at);
      this.own.users--;
      this.at = 0;
    }
  }

  return { load };
})();
