/* node engine_runner.js PAGE.html: reads jobs as JSON from standard input, answers in JSON. */
"use strict";
const fs = require("fs");
const path = require("path");
const vm = require("vm");
const zlib = require("zlib");

const page = fs.readFileSync(process.argv[2], "utf8");
const hole = (id) => page.match(new RegExp(`id="${id}">([^<]*)<`))[1];
const description = JSON.parse(hole("description"));
const bytes = zlib.gunzipSync(Buffer.from(hole("wasm"), "base64"));
const own = (name) => fs.readFileSync(path.join(__dirname, "../..", name), "utf8");
const Engine = vm.runInThisContext(own("web/pkgen_web/page/engine_swarm.js")
  + own("../generator/pkgen/back/wasm/engine.js") + "\nEngine");

function run(engine, job) {
  const start = job.params ? engine.given(Float64Array.from(job.params, (x) => x ?? NaN)) : engine.defaults();
  const motion = engine.motion({ method: job.method, step: job.step ?? null, rtol: job.rtol ?? null,
    params: start.params, q: job.q ?? start.q, v: job.v ?? start.v, t: 0 });
  const rows = [];
  let status = "";
  const began = performance.now();
  for (const t of job.times) {
    status = motion.advance(t);
    rows.push([motion.t, ...motion.q, ...motion.v]);
    if (status) break;
  }
  const took = performance.now() - began;
  const found = { rows, status, energy: motion.energy(), outputs: [...motion.outputs()], steps: motion.steps,
    constants: [...motion.constants()], events: motion.events().map((e) => ({ ...e, q: [...e.q], v: [...e.v] })), ms: took };
  motion.free();
  return found;
}

function swarm(engine, job) {
  const start = engine.defaults();
  const made = engine.swarm({ method: job.method, step: job.step, params: start.params, members: job.members,
    table: { columns: job.columns, values: Float64Array.from(job.values) } });
  const began = performance.now();
  const statuses = job.times.map((t) => made.advance(t));
  const took = performance.now() - began;
  const states = [...made.states()];
  made.free();
  return { states, statuses, ms: took };
}

(async () => {
  const engine = await Engine.load(bytes, description);
  const jobs = JSON.parse(fs.readFileSync(0, "utf8"));
  const found = jobs.map((job) => {
    try {
      if (job.kind === "swarm") return swarm(engine, job);
      if (job.kind === "prepare") return { why: engine.prepare(Float64Array.from(job.params)) };
      return run(engine, job);
    } catch (error) {
      return { error: error.message };
    }
  });
  const memory = engine.c.memory.buffer.byteLength;
  process.stdout.write(JSON.stringify({ found, memory, n: engine.n, nq: engine.nq }));
})();
