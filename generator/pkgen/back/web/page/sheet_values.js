"use strict";
/* Sliders and fields of parameters and starts. A row not touched follows what the model makes of
 * the others. */
const SheetValues = (() => {
  const { h, $ } = Dom;
  const LONG = 8; /* from so many members on a family is folded */

  function make(lab) {
    const { model } = lab;
    const element = $("sheet-values");
    const rows = [];

    const current = (entry) => {
      const { start } = lab.runs;
      if (!start || start.error) return lab.settings.values.get(entry.key) ?? entry.value ?? 0;
      if (entry.kind === "r") return lab.settings.values.get(entry.key) || 0;
      return { p: start.params, u: start.inputs, q: start.q, v: start.v }[entry.kind][entry.index];
    };
    const peers = (entry) =>
      Math.max(
        0,
        ...model.list
          .filter((e) => e.kind === entry.kind && e.unit === entry.unit)
          .slice(0, 200)
          .map((e) => Math.abs(e.value || 0)),
      );

    function row(entry) {
      const id = "value-" + entry.key;
      let range = Ranges.of(entry, current(entry), peers(entry));
      const slider = h("input", {
        type: "range",
        min: 0,
        max: Ranges.STEPS,
        step: 1,
        id,
        oninput: () => put(Ranges.fromPlace(range, Number(slider.value)), false),
      });
      const field = h("input", {
        type: "text",
        inputmode: "decimal",
        class: "number",
        autocomplete: "off",
        "aria-label": `${entry.name}${entry.unit ? " in " + entry.unit : ""}`,
        onchange: () => put(read(field.value), true),
        onkeydown: (event) => {
          if (event.key === "Enter") field.blur();
        },
      });
      const back = h(
        "button",
        {
          type: "button",
          class: "back",
          title: "As the model says",
          "aria-label": `${entry.name} as the model says`,
          onclick: () => {
            lab.settings.values.delete(entry.key);
            range = Ranges.of(entry, entry.value ?? 0, peers(entry));
            lab.restart();
            lab.changed();
          },
        },
        "↺",
      );
      const why = h("p", { class: "why", role: "alert", hidden: true });
      function put(x, exact) {
        const refusal = Ranges.refuse(entry, x);
        why.hidden = !refusal;
        Dom.say(why, refusal ? `${Text.plain(entry.name)} ${refusal}` : "");
        if (refusal) return;
        if (exact && (x < range.lo || x > range.hi)) range = Ranges.of(entry, x, Math.abs(x));
        lab.settings.values.set(entry.key, x);
        lab.restart();
        lab.changed();
      }
      function refresh() {
        const x = current(entry);
        if (!Number.isFinite(x)) return;
        if (x < range.lo || x > range.hi)
          range = Ranges.of(entry, x, Math.max(Math.abs(x), peers(entry)));
        if (document.activeElement !== slider) slider.value = Ranges.toPlace(range, x);
        if (document.activeElement !== field) field.value = written(x);
        slider.setAttribute("aria-valuetext", Text.quantity(x, entry.unit));
        back.hidden = !lab.settings.values.has(entry.key);
        field.classList.toggle(
          "follows",
          Boolean(entry.follows) && !lab.settings.values.has(entry.key),
        );
      }
      rows.push(refresh);
      const label = h(
        "label",
        { for: id, title: entry.description || entry.name },
        Text.symbol(entry.name),
      );
      const words = entry.description
        ? h("span", { class: "words", title: entry.description }, entry.description)
        : null;
      return h(
        "div",
        { class: "row" },
        h("div", { class: "row-head" }, label, words, back),
        h(
          "div",
          { class: "row-body" },
          slider,
          field,
          h("span", { class: "unit", title: Text.unit(entry.unit) }, Text.unit(entry.unit)),
        ),
        why,
      );
    }

    function fold(title, list) {
      const details = h("details", null, h("summary", null, title));
      details.addEventListener("toggle", () => {
        if (details.open && details.children.length === 1) {
          details.append(...list.map(row));
          refresh();
        }
      });
      return details;
    }

    /* Members of long families go into a fold each. */
    function group(title, list) {
      if (!list.length) return null;
      const section = h("section", { class: "group" }, h("h2", null, title));
      const families = new Map();
      for (const entry of list) {
        const found = /^(.*)\[[^\]]*\](.*)$/s.exec(entry.name);
        const family = found ? found[1] + found[2] : entry.name;
        if (!families.has(family)) families.set(family, []);
        families.get(family).push(entry);
      }
      for (const [family, members] of families) {
        if (members.length < LONG) section.append(...members.map(row));
        else
          section.append(
            fold(`${Text.plain(family)}: ${members.length} values`, members.slice(0, 300)),
          );
      }
      return section;
    }

    const turns = (model.description.rotations || []).flatMap((rotation, k) =>
      ["x", "y", "z"].map((axis) => ({
        key: `r${k}${axis}`,
        kind: "r",
        name: `${rotation.name}.${axis}`,
        unit: "rad",
        description: `turned about ${axis}`,
        value: 0,
        lo: null,
        hi: null,
        periodic: true,
      })),
    );
    const starts = model.list.filter((e) => "qv".includes(e.kind) && !model.isQuaternion(e.name));
    element.append(
      ...[
        group(
          "Parameters",
          model.list.filter((e) => e.kind === "p"),
        ),
        group(
          "Inputs",
          model.list.filter((e) => e.kind === "u"),
        ),
        group("Start", [...starts, ...turns]),
      ].filter(Boolean),
    );
    const all = h(
      "button",
      {
        type: "button",
        class: "quiet undo",
        onclick: () => {
          lab.settings.values.clear();
          lab.restart();
          lab.changed();
        },
      },
      "↺ All as the model says",
    );
    element.prepend(all);

    function refresh() {
      for (const one of rows) one();
      all.hidden = lab.settings.values.size === 0;
    }
    return { refresh };
  }

  const written = (x) => {
    const size = Math.abs(x);
    if (size !== 0 && (size >= 1e6 || size < 1e-4))
      return String(Number(x.toPrecision(5)).toExponential());
    return String(Number(x.toPrecision(6)));
  };
  const read = (text) => Number(text.trim().replace(/−/g, "-").replace(/,/g, ".") || NaN);

  return { make, read, written };
})();
