"use strict";
/* Integrates all members of a swarm together. `table` has the starts of the members: {columns:
 * [{kind: "q"|"v"|"p", index}], values}, with the values of one member after another. Quantities
 * without a column have the values in params, q and v. */
class EngineSwarm {
  constructor(engine, { method, step, rtol, params, q, v, table, members, inputs = null }) {
    const { c, n, nq } = engine;
    this.engine = engine;
    this.members = members;
    this.width = nq + n;
    this.params = this.made(params, table);
    const [name, held] = [engine.word(method), engine.write(inputs ?? new Float64Array(engine.inputs))];
    this.at = c.pk_swarm_new(this.params, name, step ?? 0.01, rtol ?? 0, held, members);
    c.free(name);
    c.free(held);
    if (!this.at) {
      c.free(this.params);
      throw new Error(engine.text(c.pk_host_why()));
    }
    const start = q && v ? { q, v } : { ...engine.given(params), ...(q && { q }), ...(v && { v }) };
    const states = engine.reals(c.pk_swarm_start(this.at), 2 * n * members);
    const width = table.columns.length;
    for (let i = 0; i < members; i++) {
      states.set(start.q, i * n);
      states.set(start.v, n * members + i * n);
      table.columns.forEach(({ kind, index }, k) => {
        const x = table.values[i * width + k];
        if (kind === "q") states[i * n + index] = x;
        if (kind === "v") states[n * members + i * n + index] = x;
      });
    }
    c.pk_swarm_to(this.at, 0);
  }

  /* Returns the address of the structs of parameters, one per member. */
  made(params, { columns, values }) {
    const { engine, members } = this;
    const { c } = engine;
    const own = columns.some((x) => x.kind === "p");
    const at = c.pk_host_params(members, own ? 1 : 0);
    const size = c.pk_host_params_size();
    const room = c.malloc(8 * Math.max(engine.count, 1));
    if (!at || !room) throw new Error("there is no memory");
    let why = "";
    for (let i = 0; i < (own ? members : 1) && !why; i++) {
      const all = engine.reals(room, engine.count);
      all.set(params);
      columns.forEach(({ kind, index }, k) => {
        if (kind === "p") all[index] = values[i * columns.length + k];
      });
      if (!c.pk_host_set(at + i * size, room)) why = engine.text(c.pk_host_why());
    }
    c.free(room);
    if (why) {
      c.free(at);
      throw new Error(why);
    }
    const bytes = new Uint8Array(c.memory.buffer);
    for (let i = 1; i < members && !own; i++) bytes.copyWithin(at + i * size, at, at + size);
    return at;
  }

  /* Integrates to time t. Returns "", or a message if all members have failed. */
  advance(t) {
    const going = this.engine.c.pk_swarm_to(this.at, t);
    return going ? "" : `no member goes on: ${this.engine.text(this.engine.c.pk_host_why())}`;
  }

  /* Returns columns i and j of the states as {box: [xmin, xmax, ymin, ymax], points: [x, y, ...]},
   * views of memory that the next call overwrites. */
  points(i, j) {
    const { c } = this.engine;
    const at = c.pk_swarm_points(this.at, i, j);
    const all = new Float32Array(c.memory.buffer, at, 4 + 2 * this.members);
    return { box: all.subarray(0, 4), points: all.subarray(4) };
  }

  /* Returns q and v of the first `count` members, a row per member. */
  states(count = this.members) {
    const { c, n, nq } = this.engine;
    const { members, width } = this;
    const all = this.engine.reals(c.pk_swarm_states(this.at), 2 * n * members);
    const found = new Float64Array(count * width);
    for (let i = 0; i < count; i++) {
      for (let k = 0; k < nq; k++) found[i * width + k] = all[i * n + k];
      for (let k = 0; k < n; k++) found[i * width + nq + k] = all[n * members + i * n + k];
    }
    return found;
  }

  free() {
    if (this.at) {
      this.engine.c.pk_swarm_free(this.at);
      this.engine.c.free(this.params);
    }
    this.at = 0;
  }
}
