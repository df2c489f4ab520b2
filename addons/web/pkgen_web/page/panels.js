"use strict";
/* The row of panels below the canvas; a menu in the header of each panel selects its content. */
const Panels = (() => {
  const PLACES = 3;
  const KINDS = new Map([
    [
      "drift",
      { title: "Drift", make: PanelsTime.drift, suits: (m) => m.description.constants.length > 0 },
    ],
    ["time", { title: "Over time", make: PanelsTime.time, suits: () => true }],
    ["phase", { title: "Phase plane", make: PanelsPlane.phase, suits: () => true }],
    [
      "section",
      {
        title: "Section",
        make: PanelsPlane.section,
        suits: (m) => m.description.events.some((e) => !e.hidden),
      },
    ],
    ["spectrum", { title: "Spectrum", make: PanelsPlane.spectrum, suits: () => true }],
    ["modes", { title: "Modes", make: PanelsModes.modes, suits: PanelsModes.suits }],
    ["distance", { title: "Error", make: PanelsTime.distance, suits: () => true }],
  ]);

  /* Returns the default panels of a model: drifts first, then those typical of its kind. */
  function usual(model) {
    const { coordinates, events } = model.description;
    const list = [];
    if (KINDS.get("drift").suits(model)) list.push("drift");
    const chain = coordinates.filter((c) => c.family).length;
    if (chain > 6 && PanelsModes.suits(model)) list.push("modes");
    list.push("time", "phase", "spectrum");
    if (events.some((e) => /section/.test(e.name))) list.splice(1, 0, "section");
    return list.slice(0, PLACES);
  }

  class Panels_ {
    constructor(lab) {
      this.lab = lab;
      this.element = Dom.$("panels");
      const wanted = (lab.settings.panels || usual(lab.model)).filter(
        (name) => KINDS.has(name) && KINDS.get(name).suits(lab.model),
      );
      for (const name of ["time", "phase", "spectrum"])
        if (!wanted.includes(name)) wanted.push(name);
      this.places = wanted.slice(0, PLACES).map((name) => this.place(name));
    }

    place(name) {
      const head = Dom.h("header");
      const tools = Dom.h("div", { class: "panel-tools" });
      const body = Dom.h("div", { class: "panel-body" });
      const place = { name, body, tools, panel: null };
      const choices = [...KINDS]
        .filter(([, kind]) => kind.suits(this.lab.model))
        .map(([key, kind]) => [key, kind.title]);
      head.append(
        Dom.select(
          choices,
          name,
          (value) => {
            this.show(place, value);
            this.lab.settings.panels = this.places.map((p) => p.name);
            this.lab.changed();
          },
          { class: "panel-title", "aria-label": "Panel" },
        ),
        tools,
      );
      this.element.append(Dom.h("section", { class: "panel" }, head, body));
      this.show(place, name);
      return place;
    }

    show(place, name) {
      if (place.panel) place.panel.free();
      place.name = name;
      Dom.fill(place.tools);
      Dom.fill(place.body);
      place.panel = KINDS.get(name).make(this.lab, place.body, place.tools);
      this.lab.dirty = true;
    }

    /* Shows a panel in the last position, unless it is visible already. */
    bring(name) {
      if (this.places.some((place) => place.name === name)) return;
      const place = this.places[PLACES - 1];
      place.body.closest(".panel").querySelector(".panel-title").value = name;
      this.show(place, name);
    }

    update() {
      const runs = this.lab.runs.all().filter((run) => !run.refused);
      if (!runs.length) return;
      for (const place of this.places) if (place.body.clientHeight) place.panel.update(runs);
    }
  }

  return { make: (lab) => new Panels_(lab), KINDS, usual };
})();
