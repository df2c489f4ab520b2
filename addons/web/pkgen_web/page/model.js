"use strict";
/* The description of the model, indexed by keys. A key is a letter and an index: p3 is a parameter,
 * u0 an input, q0 a coordinate, v1 a rate or a first-order variable (the indices of first-order
 * variables follow those of rates), o0 an output. Names are looked up in Maps, so that a parameter
 * may be called __proto__. */
const Model = (() => {
  function entries(description) {
    const list = [];
    for (const p of description.parameters) list.push({ ...p, key: "p" + p.index, kind: "p" });
    for (const u of (description.inputs || []).filter((u) => !u.sampled_by))
      list.push({
        name: u.name,
        key: "u" + u.index,
        kind: "u",
        index: u.index,
        unit: u.unit,
        description: u.description || "an input, held",
        value: 0,
        lo: null,
        hi: null,
      });
    for (const c of description.coordinates) {
      list.push({
        name: c.name,
        key: "q" + c.index,
        kind: "q",
        index: c.index,
        unit: c.unit,
        description: c.description,
        value: c.q,
        follows: c.q_follows,
        lo: null,
        hi: null,
        periodic: c.periodic,
        coordinate: c,
      });
      list.push({
        name: c.rate,
        key: "v" + c.index,
        kind: "v",
        index: c.index,
        unit: c.rate_unit,
        description: "",
        value: c.v,
        follows: c.v_follows,
        lo: null,
        hi: null,
        coordinate: c,
      });
    }
    for (const s of description.states || [])
      list.push({
        name: s.name,
        key: "v" + s.index,
        kind: "v",
        index: s.index,
        unit: s.unit,
        description: s.description,
        value: s.value,
        follows: s.follows,
        lo: null,
        hi: null,
        state: s,
      });
    /* The angular velocities of a body about its own axes are rates of no coordinate, and are
     * listed here. */
    for (const r of description.rotations || [])
      (r.rate_indices || []).forEach((index, k) => {
        if (index !== null)
          list.push({
            name: r.rates[k],
            key: "v" + index,
            kind: "v",
            index,
            unit: r.rate_unit,
            description: `${r.name}: about the body's ${"xyz"[k]}`,
            value: r.rate_values[k],
            lo: null,
            hi: null,
          });
      });
    return list;
  }

  function make(description) {
    const list = entries(description);
    /* Outputs of the model are shown like the state; their keys o0, o1, ... follow this order. */
    const outputs = (description.outputs || []).filter((o) => !o.hidden).slice(0, 200);
    outputs.forEach((o, k) =>
      list.push({
        name: o.name,
        key: "o" + k,
        kind: "o",
        index: k,
        unit: o.unit,
        description: o.description,
        value: null,
        lo: null,
        hi: null,
        output: o.index,
      }),
    );
    const byKey = new Map(list.map((entry) => [entry.key, entry]));
    const byName = new Map(list.map((entry) => [entry.name, entry]));
    const turned = new Set();
    for (const rotation of description.rotations || [])
      for (const name of rotation.quaternion) turned.add(name);
    /* The methods of GSL are not compiled to WebAssembly. */
    const offered = description.methods.filter((method) => !method.gsl);
    const applying = offered.filter((method) => method.applies);
    const preferred = applying.find((method) => method.default) || applying[0];
    return {
      description,
      list,
      byKey,
      byName,
      offered,
      applying,
      outputs,
      method: preferred ? preferred.name : null,
      methodNamed: new Map(offered.map((method) => [method.name, method])),
      sceneNamed: new Map((description.scenes || []).map((scene) => [scene.name, scene])),
      isQuaternion: (name) => turned.has(name),
      time: description.dimensionless ? "" : "s",
      shapes: description.drawing.shapes,
      view: description.drawing.view,
      reference: () => best(applying, description.coordinates.length),
    };
  }

  /* Returns the name of the reference method: the most accurate adaptive method that applies to the
   * model. For more than MANY coordinates an explicit method is preferred, since implicit methods
   * factor large matrices. */
  const MANY = 60;
  function best(applying, count) {
    const names = ["exponential", "gauss", "dop853", "radau"];
    if (count > MANY) names.unshift("dop853");
    for (const name of names) {
      const found = applying.find((method) => method.name === name);
      if (found) return found.name;
    }
    const adaptive = applying.filter((m) => m.adaptive).sort((a, b) => b.order - a.order);
    return (adaptive[0] || applying[0] || { name: null }).name;
  }

  /* Returns the quantities of a row of a run's history after the time: q, v, outputs. */
  const quantities = (model) =>
    model.list.filter((e) => "qvo".includes(e.kind) && !model.isQuaternion(e.name)).slice(0, 600);

  return { make, quantities };
})();
