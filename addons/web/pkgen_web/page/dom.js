"use strict";
/* Creates DOM elements. Texts of a model become text nodes, never HTML. */
const Dom = (() => {
  const $ = (id) => document.getElementById(id);

  /* Example: h("p", {class: "note", onclick: f}, "text", node, ...) */
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

  /* Returns a menu of [[value, text, reason], ...]; a row with a reason is disabled. */
  function select(rows, value, onchange, props) {
    const element = h("select", props);
    for (const [key, text, disabled] of rows)
      element.append(h("option", { value: key, disabled: Boolean(disabled) }, text));
    element.value = value;
    element.addEventListener("change", () => onchange(element.value));
    return element;
  }

  /* Sets a text only if it changes, so that a static page causes no layout. */
  function say(element, text) {
    if (element.textContent !== text) element.textContent = text;
  }

  /* Sets the size of a canvas in device pixels; returns whether it changed. */
  function fitCanvas(canvas, width, height) {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const w = Math.max(1, Math.round(width * ratio));
    const h_ = Math.max(1, Math.round(height * ratio));
    if (canvas.width === w && canvas.height === h_) return false;
    canvas.width = w;
    canvas.height = h_;
    return true;
  }

  /* Returns a 2D context drawn by the CPU: thousands of points are drawn faster than they are sent
   * to a GPU, and machines without one are as fast. */
  const pen = (canvas) => canvas.getContext("2d", { willReadFrequently: true });

  /* Clears the canvas; returns its context, scaled to CSS pixels. */
  function blank(canvas, width, height) {
    fitCanvas(canvas, width, height);
    const g = pen(canvas);
    g.setTransform(canvas.width / width, 0, 0, canvas.height / height, 0, 0);
    g.clearRect(0, 0, width, height);
    return g;
  }

  return { $, h, fill, select, say, fitCanvas, pen, blank };
})();
