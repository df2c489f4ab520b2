"use strict";
/* The methods tab: up to four methods, the reference, and the methods that do not apply. */
const SheetMethods = (() => {
  const { h, $ } = Dom;

  function make(lab) {
    const { model } = lab;
    const element = $("sheet-methods");
    const cards = h("div", { class: "cards" });
    const add = h(
      "button",
      {
        type: "button",
        class: "wide",
        onclick: () => {
          const used = new Set(lab.settings.methods.map((m) => m.method));
          const next =
            ["rk4", "verlet", "gauss", "dop853", "gauss1", "euler"].find(
              (name) => !used.has(name) && (model.methodNamed.get(name) || {}).applies,
            ) || (model.applying.find((m) => !used.has(m.name)) || model.applying[0]).name;
          lab.settings.methods.push({ method: next, step: null, rtol: null });
          if (lab.settings.methods.length === 2 && !lab.settings.reference)
            lab.settings.reference = true;
          if (lab.settings.reference) lab.panels.bring("distance");
          renew();
        },
      },
      "Lay another method over it",
    );
    const reference = h("input", {
      type: "checkbox",
      id: "reference",
      onchange: () => {
        lab.settings.reference = reference.checked;
        renew();
      },
    });
    const note = h(
      "label",
      { class: "check", for: "reference" },
      reference,
      h(
        "span",
        null,
        "Reference beside them: ",
        model.reference() || "none",
        h("small", null, " dashed, at the finest tolerance"),
      ),
    );
    const unfit = model.offered.filter((m) => !m.applies);
    element.append(
      h(
        "section",
        { class: "group" },
        h("h2", null, "Methods against each other"),
        cards,
        add,
        note,
      ),
    );
    if (unfit.length)
      element.append(
        h(
          "details",
          { class: "group" },
          h(
            "summary",
            null,
            `${unfit.length} that ${unfit.length === 1 ? "does" : "do"} not apply`,
          ),
          h(
            "dl",
            { class: "reasons" },
            ...unfit.flatMap((m) => [h("dt", null, m.name), h("dd", null, m.why)]),
          ),
        ),
      );

    function renew() {
      lab.restart();
      lab.changed();
      build();
    }

    function field(spec, key, label, hint) {
      const input = h("input", {
        type: "text",
        inputmode: "decimal",
        class: "number",
        placeholder: hint,
        "aria-label": label,
        value: spec[key] === null ? "" : String(spec[key]),
        onchange: () => {
          const x = SheetValues.read(input.value);
          spec[key] = x > 0 ? x : null;
          if (spec[key] === null) input.value = "";
          lab.restart();
          lab.changed();
        },
      });
      return h("label", { class: "small" }, label, input);
    }

    function card(spec, k) {
      const row = model.methodNamed.get(spec.method) || {};
      const menu = Dom.select(
        model.applying.map((m) => [m.name, m.name]),
        spec.method,
        (name) => {
          Object.assign(spec, { method: name, step: null, rtol: null });
          renew();
        },
        { "aria-label": `Method ${k + 1}` },
      );
      const facts = [
        row.order ? `order ${row.order}` : "",
        row.adaptive ? "adaptive" : "",
        row.symplectic ? "symplectic" : "",
      ]
        .filter(Boolean)
        .join(", ");
      const away =
        lab.settings.methods.length > 1
          ? h(
              "button",
              {
                type: "button",
                class: "quiet icon",
                "aria-label": `Take ${spec.method} away`,
                onclick: () => {
                  lab.settings.methods.splice(k, 1);
                  renew();
                },
              },
              "×",
            )
          : null;
      return h(
        "article",
        { class: `card m${k}` },
        h(
          "div",
          { class: "card-head" },
          h("span", { class: "swatch", "aria-hidden": "true" }),
          menu,
          away,
        ),
        h("p", { class: "facts", title: row.doc || "" }, facts),
        h(
          "div",
          { class: "card-body" },
          field(spec, "step", "step", row.adaptive ? "auto" : Text.number(lab.stepOf(spec))),
          row.adaptive
            ? field(spec, "rtol", "rtol", lab.rtol ? Text.number(lab.rtol) : "auto")
            : null,
        ),
        h("p", { class: "counts" }),
        h("p", { class: "status", role: "status" }),
      );
    }

    function build() {
      Dom.fill(cards, ...lab.settings.methods.map(card));
      add.hidden = lab.settings.methods.length >= Settings.MOST_METHODS;
      reference.checked = lab.settings.reference;
      counts();
    }

    /* Shows the numbers of steps and evaluations of each run. */
    function counts() {
      [...cards.children].forEach((element_, k) => {
        const run = lab.runs.list[k];
        if (!run) return;
        const { motion } = run;
        Dom.say(
          element_.querySelector(".counts"),
          motion
            ? `${motion.steps.toLocaleString("en")} steps, ${motion.evaluations.toLocaleString("en")} evaluations`
            : "",
        );
        Dom.say(element_.querySelector(".status"), Text.shorter(run.status));
      });
    }

    build();
    return { build, counts };
  }

  return { make };
})();
