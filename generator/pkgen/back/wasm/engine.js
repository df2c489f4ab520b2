"use strict";
/* Calls the model and the runtime in WebAssembly, through the interface pk_host.h. Parameters are a
 * flat Float64Array in the order of the description. The array q has the coordinates, v the rates
 * and after them the first-order variables; y is q followed by v. All numbers are in SI units. */
const Engine = (() => {
  /* Stubs of the system calls that wasi-libc imports: no file is read or written. */
  const WASI = { fd_close: () => 0, fd_seek: () => 70, fd_write: () => 0, fd_fdstat_get: () => 0,
    proc_exit: (code) => { throw new Error("the model's code ended with " + code); } };
  const BUDGET = 20000;    /* integration steps between two checks of the time */
  const PATIENCE = 1500;   /* largest duration of a call of advance(), in ms */
  const KEPT = 16;         /* largest number of parameter sets in memory */
  const [ACCELERATIONS, ENERGY, OUTPUTS, CLAIMS, MOMENTA] = [0, 1, 2, 3, 4]; /* enum pk_host_kind */

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
      this.base = c.pk_host_params(1, 1);
      if (!this.base) throw new Error("there is no memory");
      this.n = c.pk_host_n(this.base);
      this.nq = c.pk_host_coordinates(this.base);
      this.count = c.pk_host_parameters(this.base);
      this.inputs = description.inputs.length;
      this.nOut = description.outputs.length;
      this.constants = description.constants;
      this.claims = this.constants.filter((x) => x.kind === "claim").length;
      this.sets = new Map();                            /* parameters -> their struct */
      this.room = c.malloc(8 * (1 + this.nq + this.n + this.inputs + Math.max(this.nOut, this.claims, this.n, 1)));
    }

    /* Makes a new view each time: views become invalid when WebAssembly's memory grows. */
    reals(at, length) {
      return new Float64Array(this.c.memory.buffer, at, length);
    }

    /* Returns copies of the arrays q and v of the state at a memory address. */
    split(at) {
      return [this.reals(at, this.nq).slice(), this.reals(at + 8 * this.nq, this.n).slice()];
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

    /* Returns the parameters and the initial state of the description, or of its scene. */
    defaults() {
      const params = new Float64Array(this.count).fill(NaN);
      for (const p of this.description.parameters) if (!p.follows) params[p.index] = p.value;
      return this.given(params);
    }

    /* Returns all parameters, of which those that are NaN are computed from the others, and the
     * initial state. */
    given(params) {
      const { c } = this;
      const at = this.write(params);
      const good = c.pk_host_set(this.base, at);
      const all = this.reals(at, this.count).slice();
      c.free(at);
      if (!good) throw new Error(this.text(c.pk_host_why()));
      const start = c.malloc(16 * this.n);
      c.pk_host_start(this.base, start);
      const [q, v] = this.split(start);
      c.free(start);
      this.asDescribed(all, q, v);
      return { params: all, q, v };
    }

    /* Sets initial values that the description has, from a scene or from options. An initial value
     * that depends on parameters is set only if all parameters are those of the description. */
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

    /* Returns null, or as text why the model cannot have these parameters. */
    prepare(params) {
      try {
        this.prepared(params);
        return null;
      } catch (error) {
        return error.message;
      }
    }

    /* Returns the address of a struct with these parameters. The structs used last stay in memory,
     * and those that a motion uses. */
    prepared(params) {
      return this.set(params).at;
    }

    set(params) {
      const key = params.join();
      let set = this.sets.get(key);
      if (set) this.sets.delete(key);
      else set = { key, at: this.made(params), users: 0 };
      this.sets.set(key, set);                          /* the set used last comes last */
      if (this.sets.size > KEPT) this.forget();
      return set;
    }

    made(params) {
      const { c } = this;
      const [made, at] = [c.pk_host_params(1, 1), this.write(params)];
      const good = made && c.pk_host_set(made, at);
      c.free(at);
      if (good) return made;
      c.free(made);
      throw new Error(made ? this.text(c.pk_host_why()) : "there is no memory");
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

    /* Returns the `count` values of one kind, such as momenta, at a state; null if there are none. */
    values(kind, count, params, t, q, v, u) {
      const at = this.room;
      const out = at + 8 * (1 + this.nq + this.n + this.inputs);
      this.state(at, t, q, v, u);
      const of = this.prepared(params);
      const found = this.c.pk_host_values(of, kind, 1, at, at + 8, at + 8 * (1 + this.nq + this.n), out);
      return found ? this.reals(out, count).slice() : null;
    }

    /* Writes t, the state q and v, and the inputs u at a memory address. */
    state(at, t, q, v, u) {
      const room = this.reals(at, 1 + this.nq + this.n + this.inputs).fill(0);
      room[0] = t;
      room.set(q, 1);
      room.set(v, 1 + this.nq);
      if (u) room.set(u, 1 + this.nq + this.n);
    }

    acceleration(...at) {
      return this.values(ACCELERATIONS, this.n, ...at);
    }

    outputs(...at) {
      return this.values(OUTPUTS, this.nOut, ...at) ?? new Float64Array(0);
    }

    energy(...at) {
      return this.values(ENERGY, 1, ...at)?.[0] ?? NaN;
    }

    momenta(...at) {
      return this.values(MOMENTA, this.n, ...at) ?? new Float64Array(this.n).fill(NaN);
    }

    claimed(...at) {
      return this.values(CLAIMS, this.claims, ...at) ?? new Float64Array(this.claims).fill(NaN);
    }

    /* Returns the constants of the motion at a state, in the order of the description. */
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

  /* One trajectory. The constructor throws an error with the reason if the runtime refuses the
   * method, its settings or the initial state. */
  class Motion {
    constructor(engine, { method, step, rtol, params, q, v, t = 0, inputs = null }) {
      const { c, n } = engine;
      this.engine = engine;
      this.params = params;
      this.inputs = inputs;
      const own = engine.set(params);
      const width = 1 + engine.nq + n;
      const [name, start] = [engine.word(method), c.malloc(8 * (width + engine.inputs))];
      engine.state(start, t, q, v, inputs);
      const h = step ?? this.usual(engine, method);
      const tolerance = rtol ?? engine.description.run.rtol;
      this.at = c.pk_host_motion_new(own.at, name, h, tolerance, t, start + 8, start + 8 * width);
      c.free(name);
      c.free(start);
      if (!this.at) throw new Error(engine.text(c.pk_host_why()));
      this.own = own;
      own.users++;
      this.step = step ?? h;
      this.read();
    }

    /* Returns the step for a method that needs one: 0.01 if the description has none. Returns 0 for
     * an adaptive or exact method, which chooses its own. */
    usual(engine, method) {
      const known = engine.description.methods.find((x) => x.name === method);
      return known && (known.adaptive || known.exact) && !known.fixed ? 0 : engine.description.run.step || 0.01;
    }

    read() {
      const { c } = this.engine;
      this.t = c.pk_host_t(this.at);
      [this.q, this.v] = this.engine.split(c.pk_host_y(this.at));
      this.inputs = this.engine.reals(c.pk_host_u(this.at), this.engine.inputs).slice();
      this.steps = c.pk_host_steps(this.at);
      this.evaluations = c.pk_host_evaluations(this.at);
    }

    /* Integrates to t. Returns "", or the reason for a failure. Gives up after PATIENCE ms. */
    advance(t) {
      const { c } = this.engine;
      const until = performance.now() + PATIENCE;
      let code = 1;
      while (code === 1) {
        code = c.pk_host_to(this.at, t, BUDGET);
        if (code === 1 && performance.now() > until) {
          this.read();
          return "its steps are too many for a live page: choose a longer one, or a looser tolerance";
        }
      }
      this.read();
      return code ? this.engine.text(c.pk_host_why()) : "";
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

    /* Returns the event crossings since the last call of events(). */
    events() {
      const { c, n, nq } = this.engine;
      const count = c.pk_host_crossed(this.at);
      const width = 2 + nq + n;
      const all = this.engine.reals(count ? c.pk_host_crossings(this.at) : 0, count * width).slice();
      return Array.from({ length: count }, (_, k) => {
        const one = all.subarray(k * width, (k + 1) * width);
        return { event: one[0], t: one[1], q: one.slice(2, 2 + nq), v: one.slice(2 + nq) };
      });
    }

    free() {
      if (!this.at) return;
      this.engine.c.pk_host_free(this.at);
      this.own.users--;
      this.at = 0;
    }
  }

  return { load };
})();
