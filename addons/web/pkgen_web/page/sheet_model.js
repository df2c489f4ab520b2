"use strict";
/* The model tab: equations as typeset by `pkgen explain`, proved constants, declarations. */
const SheetModel = (() => {
  const { h, $ } = Dom;

  function list(title, rows) {
    if (!rows.length) return null;
    return h(
      "section",
      { class: "group" },
      h("h2", null, title),
      h(
        "dl",
        { class: "reasons" },
        ...rows.flatMap(([name, text]) => [
          h("dt", null, typeof name === "string" ? Text.symbol(name) : name),
          h("dd", null, text),
        ]),
      ),
    );
  }

  function make(lab) {
    const d = lab.model.description;
    const element = $("sheet-model");
    const { content } = $("explained");
    if (content.childElementCount) {
      /* Formulas may be wider than the tab: a button shows them in the whole window. */
      const wide = h(
        "dialog",
        { class: "reading", "aria-label": "The model" },
        h("form", { method: "dialog" }, h("button", { class: "icon", "aria-label": "Close" }, "×")),
        h("h2", null, "Equations and structure"),
        h("div", { class: "explained" }, content.cloneNode(true)),
      );
      document.body.append(wide);
      element.append(
        h(
          "button",
          { type: "button", class: "wide", onclick: () => wide.showModal() },
          "Read it at full width",
        ),
        h("h2", { class: "first" }, "Equations and structure"),
        h("div", { class: "explained" }, content.cloneNode(true)),
      );
    }
    element.append(
      ...[
        list(
          "Proved constant",
          d.constants.map((c) => [
            c.label || c.name,
            [
              c.why ||
                {
                  energy: "the Lagrangian does not name t",
                  claim: "claimed and proved",
                  momentum: "its coordinate is cyclic",
                }[c.kind] ||
                "",
              Text.unit(c.unit),
            ]
              .filter(Boolean)
              .join(", "),
          ]),
        ),
        list(
          "Events",
          d.events.filter((e) => !e.hidden).map((e) => [
            e.name,
            [
              { 1: "rising through zero", "-1": "falling through zero" }[e.direction] ||
                "through zero",
              e.stop ? "stops the run" : "",
              e.description,
            ]
              .filter(Boolean)
              .join("; "),
          ]),
        ),
        list(
          "Constraints",
          (d.constraints || []).map((c) => [c.name, c.holonomic ? "of places" : "of rates"]),
        ),
      ].filter(Boolean),
    );
    element.append(
      h(
        "p",
        { class: "source" },
        `${d.source}, pkgen ${d.pkgen}`,
        h("br"),
        h("span", { class: "hash", title: "SHA-256 of the model" }, (d.sha256 || "").slice(0, 16)),
      ),
    );
  }

  return { make };
})();
