"use strict";
/* Elements. Text of a model goes in as text nodes alone, never as HTML. */
const Dom = (() => {
  const $ = (id) => document.getElementById(id);

  /* h("p", {class: "note", onclick: f}, "text", node, ...) */
  function h(tag, props, ...children) {
    const element = document.createElement(tag);
    for (const [key, value] of Object.entries(props || {})) {
      if (value === null || value === undefined || value === false) continue;
      if (key === "class") element.className = value;
      else if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
      else if (key === "value" || key === "checked" || key === "disabled") element[key] = value;
      else element.setAttribute(key, value === true ? "" : value);
    }
    element.append(...children.filter((child) => child !== null && child !== undefined));
    return element;
  }

  function fill(element, ...children) {
    element.replaceChildren(...children.filter((child) => child !== null && child !== undefined));
    return element;
  }

  /* A menu of [[value, text, why not], ...]; a row with a reason cannot be chosen. */
  function select(rows, value, onchange, props) {
    const element = h("select", props);
    for (const [key, text, disabled] of rows)
      element.append(h("option", { value: key, disabled: Boolean(disabled) }, text));
    element.value = value;
    element.addEventListener("change", () => onchange(element.value));
    return element;
  }

  /* Text set only where it changes, so that a page at rest costs nothing. */
  function say(element, text) {
    if (element.textContent !== text) element.textContent = text;
  }

  /* The size of a canvas in device pixels; true where it changed. */
  function fitCanvas(canvas, width, height) {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const w = Math.max(1, Math.round(width * ratio));
    const h_ = Math.max(1, Math.round(height * ratio));
    if (canvas.width === w && canvas.height === h_) return false;
    canvas.width = w;
    canvas.height = h_;
    return true;
  }

  /* A canvas that the processor draws: thousands of points are sooner drawn than sent away, and a
   * machine without a graphics card shows them as smoothly. */
  const pen = (canvas) => canvas.getContext("2d", { willReadFrequently: true });

  /* The pen of an empty canvas of that size, which measures in CSS pixels. */
  function blank(canvas, width, height) {
    fitCanvas(canvas, width, height);
    const g = pen(canvas);
    g.setTransform(canvas.width / width, 0, 0, canvas.height / height, 0, 0);
    g.clearRect(0, 0, width, height);
    return g;
  }

  return { $, h, fill, select, say, fitCanvas, pen, blank };
})();
