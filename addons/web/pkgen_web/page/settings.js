"use strict";
/* The user's settings, and their form in the address after #, so that a link shows the same state.
 *
 *     #scene=slow&p.l1=2&q.theta1=0.5&v.theta1=0&m=verlet:0.01&m=gauss&ref=1&speed=3
 */
const Settings = (() => {
  const MOST_METHODS = 4;

  const fresh = () => ({
    scene: null,
    values: new Map() /* value by key, for each value that differs from the default */,
    methods: [] /* {method, step, rtol}; a null is replaced by the method's default */,
    reference: false,
    speed: 0 /* number of steps 1, 2, 5, 10, ... above the natural speed: see lab.js */,
    panels: null /* names of panels; null: the defaults of the model */,
    view: "scene",
  });

  const number = (text) => {
    const x = Number(text);
    return text !== "" && text !== null && Number.isFinite(x) ? x : null;
  };
  const positive = (text) => {
    const value = number(text ?? "");
    return value > 0 ? value : null;
  };

  function chosen(model, scene) {
    const row = scene ? model.sceneNamed.get(scene) : null;
    const method =
      row && row.method && (model.methodNamed.get(row.method) || {}).applies
        ? row.method
        : model.method;
    return { method, step: row ? row.step : null, rtol: row ? row.rtol : null };
  }

  /* Returns the default view: "swarm" for a scene that is a swarm. */
  const usual = (model, scene) =>
    model.sceneNamed.get(scene)?.swarm?.columns ? "swarm" : "scene";

  /* Selects a scene: its values, starts and method. */
  function enter(model, settings, scene) {
    settings.scene = scene;
    settings.values = new Map();
    settings.methods = [chosen(model, scene)];
    settings.view = usual(model, scene) === "swarm" ? "swarm" : settings.view;
    return settings;
  }

  /* Returns the values that a scene sets, key → number. */
  function ofScene(model, scene) {
    const values = new Map();
    const row = scene ? model.sceneNamed.get(scene) : null;
    if (!row) return values;
    for (const part of [row.set, row.start])
      for (const name of Object.keys(part || {})) {
        const entry = model.byName.get(name);
        if (entry && typeof part[name] === "number") values.set(entry.key, part[name]);
      }
    return values;
  }

  function write(model, settings) {
    const out = [];
    const put = (key, value) => out.push(`${encodeURIComponent(key)}=${encodeURIComponent(value)}`);
    if (settings.scene) put("scene", settings.scene);
    for (const [key, value] of settings.values) {
      const entry = model.byKey.get(key);
      if (entry)
        put(
          `${entry.kind}.${
            entry.kind === "v" && entry.coordinate ? entry.coordinate.name : entry.name
          }`,
          value,
        );
      else if (key.startsWith("r")) put(key, value);
    }
    const said = JSON.stringify([chosen(model, settings.scene)]);
    if (JSON.stringify(settings.methods) !== said)
      for (const { method, step, rtol } of settings.methods)
        put("m", [method, step ?? "", rtol ?? ""].join(":").replace(/:+$/, ""));
    if (settings.reference) put("ref", 1);
    if (settings.speed) put("speed", settings.speed);
    if (settings.panels) put("panels", settings.panels.join(","));
    if (settings.view !== usual(model, settings.scene)) put("view", settings.view);
    return out.join("&");
  }

  /* Reads the settings from the address; ignores unknown names and invalid numbers in it. */
  function read(model, fragment) {
    const settings = fresh();
    const query = new URLSearchParams(fragment.replace(/^#/, ""));
    const scene = query.get("scene");
    enter(
      model,
      settings,
      scene !== null && model.sceneNamed.has(scene) ? scene : model.description.scene,
    );
    for (const [name, text] of query) {
      const found = /^([pquv])\.(.+)$/s.exec(name);
      const value = number(text);
      if (value === null) continue;
      if (/^r\d+[xyz]$/.test(name)) settings.values.set(name, value);
      if (!found) continue;
      const entry =
        found[1] === "v"
          ? model.list.find(
              (e) =>
                e.kind === "v" &&
                (e.coordinate ? e.coordinate.name === found[2] : e.name === found[2]),
            )
          : model.byName.get(found[2]);
      if (entry && entry.kind === found[1] && !Ranges.refuse(entry, value))
        settings.values.set(entry.key, value);
    }
    const methods = [];
    for (const text of query.getAll("m").slice(0, MOST_METHODS)) {
      const [method, step, rtol] = text.split(":");
      const row = model.methodNamed.get(method);
      if (row && row.applies)
        methods.push({ method, step: positive(step), rtol: positive(rtol) });
    }
    if (methods.length) settings.methods = methods;
    settings.reference = query.get("ref") === "1";
    const speed = number(query.get("speed") ?? "");
    if (speed !== null) settings.speed = Math.max(-12, Math.min(12, Math.round(speed)));
    if (query.get("panels")) settings.panels = query.get("panels").split(",").slice(0, 6);
    if (["swarm", "scene"].includes(query.get("view"))) settings.view = query.get("view");
    return settings;
  }

  return { read, write, enter, ofScene, chosen, usual, fresh, MOST_METHODS };
})();
