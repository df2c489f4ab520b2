"use strict";
/* The swarm tab: the settings of the swarm, and the phase-space area within the loop of its first
 * members. */
const SheetSwarm = (() => {
  const { h, $ } = Dom;

  function make(lab) {
    const element = $("sheet-swarm");
    const { swarm, model } = lab;
    if (!swarm.can()) {
      element.append(
        h(
          "p",
          { class: "words" },
          "No swarm here: it takes a coordinate and a method of fixed step.",
        ),
      );
      return { refresh() {} };
    }
    const again = () => {
      lab.restart();
      lab.changed();
    };
    const coordinates = model.list.filter((e) => e.kind === "q").slice(0, 200);
    const size = h("output", null, "");
    const spread = h("input", {
      type: "range",
      min: 1,
      max: 100,
      value: 100 * swarm.share,
      id: "spread",
      oninput: () => {
        swarm.share = Number(spread.value) / 100;
        again();
      },
    });
    const step = h("input", {
      type: "text",
      inputmode: "decimal",
      class: "number",
      placeholder: "auto",
      onchange: () => {
        swarm.stepAsked = SheetValues.read(step.value) || null;
        again();
      },
    });
    const facts = h("dl", { class: "facts-list" });
    const area = h("dd", null, "–");
    const change = h("dd", null, "–");
    const status = h("p", { class: "status", role: "status" });
    facts.append(
      h(
        "dt",
        null,
        lab.engine.momenta ? "Area of the loop in (q, p)" : "Area of the loop in (q, q′)",
      ),
      area,
      h("dt", null, "Change since the start"),
      change,
    );
    const own = h("p", { class: "words" }, "The scene's own swarm: its starts, method and step.");
    const disc = h(
        "section",
        { class: "group" },
        h("h2", null, "A cloud of neighbours"),
        h(
          "p",
          { class: "words" },
          "A disc of starts about this one, and the loop round it. Motion from a " +
            "Lagrangian keeps the loop's area in (q, p), however long it is drawn.",
        ),
        h(
          "label",
          { class: "line" },
          "In the plane of",
          Dom.select(
            coordinates.map((e) => [e.key, Text.plain(e.name)]),
            swarm.x.key,
            (key) => {
              swarm.x = model.byKey.get(key);
              again();
            },
          ),
        ),
        h(
          "label",
          { class: "line" },
          "Members",
          Dom.select(
            [1000, 3000, 10000, 30000].map((n) => [n, n.toLocaleString("en")]),
            swarm.asked,
            (n) => {
              swarm.asked = Number(n);
              again();
            },
          ),
        ),
        h("label", { class: "line" }, "Width", spread, size),
        h(
          "label",
          { class: "line" },
          "Method",
          Dom.select(
            swarm.methods.map((name) => [name, name]),
            swarm.method,
            (name) => {
              swarm.method = name;
              again();
            },
          ),
        ),
        h("label", { class: "line" }, "Step", step),
        facts,
      );
    element.append(own, disc, status);
    return {
      refresh() {
        Dom.say(size, `${Math.round(swarm.share * 100)} %`);
        Dom.say(status, swarm.status);
        disc.hidden = Boolean(swarm.own());
        own.hidden = !disc.hidden;
        if (lab.settings.view !== "swarm" || !swarm.swarm) return;
        const now = swarm.measure();
        Dom.say(area, Text.number(Math.abs(now), 6));
        Dom.say(change, Text.number((now - swarm.first) / Math.abs(swarm.first), 2));
      },
    };
  }

  return { make };
})();
