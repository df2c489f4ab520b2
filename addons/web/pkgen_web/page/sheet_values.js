"use strict";
/* The values tab: sliders and number fields of parameters and starts. A value that the model
 * computes from others is read-only until the user unlocks it. */
const SheetValues = (() => {
  const { h, $ } = Dom;
  const LONG = 8; /* families with at least this many members are collapsed */

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

    function row(entry, words = entry.description) {
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
      const ends = [h("span"), h("span"), h("span", { class: "degrees" })];
      const shown = h("output", { class: "reading" });
      const free = h(
        "button",
        {
          type: "button",
          class: "quiet small-button",
          title: "It follows from the others: give it a value of its own",
          "aria-label": `Set ${entry.name} by itself`,
          onclick: () => {
            put(current(entry), true);
            slider.focus();
          },
        },
        "Set",
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
        const own = lab.settings.values.has(entry.key);
        const reads = Boolean(entry.follows && !own && !lab.runs.start?.given?.has(entry.key));
        input.hidden = reads;
        read_.hidden = !reads;
        back.hidden = !own;
        const angle = Text.degrees(x, entry.unit);
        if (reads) {
          Dom.say(shown, `= ${Text.quantity(x, entry.unit, 6)}${angle && ` = ${angle}`}`);
          return;
        }
        if (document.activeElement !== slider) slider.value = Ranges.toPlace(range, x);
        if (document.activeElement !== field) field.value = written(x);
        slider.setAttribute("aria-valuetext", Text.quantity(x, entry.unit));
        Dom.say(ends[0], Text.quantity(range.lo, entry.unit, 3));
        Dom.say(ends[1], Text.quantity(range.hi, entry.unit, 3));
        Dom.say(ends[2], angle);
      }
      rows.push(refresh);
      const label = h(
        "label",
        { for: id, title: entry.description || entry.name },
        Text.symbol(entry.name),
      );
      const input = h(
        "div",
        { class: "row-body" },
        slider,
        field,
        h("span", { class: "unit", title: Text.unit(entry.unit) }, Text.unit(entry.unit)),
        h("span", { class: "ends" }, ends[0], ends[1]),
        ends[2],
      );
      const read_ = h("div", { class: "row-read", hidden: true }, shown, free);
      return h(
        "div",
        { class: "row" },
        h("div", { class: "row-head" }, label, words && h("span", { class: "words" }, words), back),
        input,
        read_,
        why,
      );
    }

    function fold(title, list) {
      const details = h("details", null, h("summary", null, title));
      details.addEventListener("toggle", () => {
        if (details.open && details.children.length === 1) {
          details.append(...list.map((entry) => row(entry, "")));
          refresh();
        }
      });
      return details;
    }

    /* Members of a long family are in a collapsible section. */
    function group(title, list) {
      if (!list.length) return null;
      const section = h("section", { class: "group" }, h("h2", null, title));
      const families = by(list, (entry) => {
        const found = /^(.*)\[[^\]]*\](.*)$/s.exec(entry.name);
        return found ? found[1] + found[2] : entry.name;
      });
      const alike = by(list, (entry) => entry.kind + (entry.description || entry.key));
      for (const [family, members] of families) {
        const long = members.length >= LONG;
        for (const entry of long ? members.slice(0, 1) : members) {
          const same = alike.get(entry.kind + (entry.description || entry.key));
          const each = same.length > 1 ? apart(entry.description, same) : [entry.description];
          if (!each && same[0] === entry)
            section.append(h("p", { class: "words shared" }, together(same)));
          if (!long) section.append(row(entry, each ? each[same.indexOf(entry)] : ""));
        }
        if (long)
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

  function by(list, key) {
    const found = new Map();
    for (const entry of list) {
      if (!found.has(key(entry))) found.set(key(entry), []);
      found.get(key(entry)).push(entry);
    }
    return found;
  }

  /* Splits a description like "precession, nutation, spin" into a word per quantity, else null. */
  function apart(words, same) {
    const each = words.split(", ");
    return each.length === same.length && each.every((word) => /^\S+$/.test(word)) ? each : null;
  }

  /* Returns a common caption, such as "q₁, q₂, q₃: displacements from rest". */
  function together(same) {
    const all = same.map((entry) => Text.plain(entry.name));
    const named = all.length > 4 ? `${all[0]} … ${all[all.length - 1]}` : all.join(", ");
    return `${named}: ${same[0].description}`;
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
