"use strict";
/* The map of a sweep: each pixel is a member; a click on it starts that member's motion. */
const SheetMap = (() => {
  const { h, $, say } = Dom;

  const numbers = (text, Kind) => {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Kind(bytes.buffer);
  };

  function make(lab) {
    const map = lab.model.description.map;
    if (!map) return { refresh() {} };
    const { columns, rows } = map;
    const members = numbers(map.members, Float64Array);
    const values = numbers(map.values, Float64Array);
    const drawn = map.drawn.map((one) => ({ key: one.key, of: numbers(one.of, Float64Array) }));
    let at = null; /* the selected pixel */

    const cross = h("span", { class: "map-cross", hidden: true });
    const words = h("p", { class: "words", role: "status" }, "Choose a member: click, or use the arrow keys.");
    const image = h("img", { src: map.image, alt: "", draggable: "false" });
    const frame = h(
      "div",
      {
        class: "map-frame",
        tabindex: "0",
        role: "application",
        "aria-label": `Map of ${map.value} over ${map.x.label} and ${map.y.label}`,
        onclick: (event) => {
          const box = frame.getBoundingClientRect();
          const part = (x, length, n) => Math.min(n - 1, Math.max(0, Math.floor((x / length) * n)));
          choose(
            part(event.clientX - box.left, box.width, columns),
            rows - 1 - part(event.clientY - box.top, box.height, rows),
          );
        },
        onkeydown: (event) => {
          const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
          const step = by[event.key];
          if (!step) return;
          event.preventDefault();
          event.stopPropagation();
          const [x, y] = at || [columns >> 1, rows >> 1];
          const within = (k, n) => Math.min(n - 1, Math.max(0, k));
          choose(within(x + step[0], columns), within(y + step[1], rows));
        },
      },
      image,
      cross,
    );

    function choose(x, y) {
      at = [x, y];
      const k = y * columns + x;
      cross.hidden = false;
      cross.style.left = `${((x + 0.5) / columns) * 100}%`;
      cross.style.bottom = `${((y + 0.5) / rows) * 100}%`;
      if (!members[k]) {
        say(words, "No member of the sweep is here.");
        return;
      }
      const value = Number.isNaN(values[k]) ? "none" : Text.number(values[k], 5);
      say(words, `Member ${members[k].toLocaleString("en")}: ${map.value} about ${value}`);
      const keys = new URLSearchParams(location.hash.slice(1));
      for (const one of drawn) keys.set(one.key, one.of[k]);
      location.hash = keys.toString();
    }

    const ends = (axis) => axis.ends.map((x) => Text.number(x, 3));
    const [left, right] = ends(map.x);
    const [bottom, top] = ends(map.y);
    $("sheet-map").append(
      h("h2", { class: "first" }, map.value),
      h("p", { class: "map-y" }, h("span", null, `${map.y.label} up to ${top}`)),
      frame,
      h("p", { class: "map-x" }, h("span", null, left), h("span", null, map.x.label), h("span", null, right)),
      h("p", { class: "words" }, `${map.y.label} from ${bottom}. ${map.title}.`),
      h(
        "p",
        { class: "map-scale" },
        h("span", null, Text.number(map.scale.low, 3)),
        h("img", { src: map.scale.image, alt: "colours from the smallest to the largest value" }),
        h("span", null, Text.number(map.scale.high, 3)),
      ),
      words,
    );
    return { refresh() {} };
  }

  return { make };
})();
