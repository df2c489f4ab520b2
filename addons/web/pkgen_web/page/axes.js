"use strict";
/* Axes of a large picture: grid lines at round numbers, with the numbers as labels. */
const Axes = (() => {
  function each([lo, hi], pieces, use) {
    const step = Ranges.nice((hi - lo) / pieces);
    for (let k = Math.ceil(lo / step); k * step <= hi; k++) use(Number((k * step).toPrecision(12)));
  }

  /* Draws the axes. The frame is from left to right and from top to bottom, in pixels. The
   * functions X and Y map values to pixels. x and y are the ranges of the values. below and beside
   * are the names of the two axes. */
  function draw(g, { left, right, top, bottom, X, Y, x, y, below, beside }) {
    const theme = Theme.now();
    g.font = `12px ${theme.font}`;
    g.lineWidth = 1;
    g.strokeStyle = theme.faint;
    g.fillStyle = theme.soft;
    g.beginPath();
    g.textAlign = "right";
    each(y, Math.max(3, (bottom - top) / 64), (v) => {
      g.moveTo(left, Math.round(Y(v)) + 0.5);
      g.lineTo(right, Math.round(Y(v)) + 0.5);
      g.fillText(Text.number(v, 4), left - 8, Y(v) + 4);
    });
    g.textAlign = "center";
    each(x, Math.max(3, (right - left) / 110), (v) => {
      g.moveTo(Math.round(X(v)) + 0.5, top);
      g.lineTo(Math.round(X(v)) + 0.5, bottom);
      g.fillText(Text.number(v, 4), X(v), bottom + 18);
    });
    g.stroke();
    g.fillText(below, (left + right) / 2, bottom + 35);
    if (!beside) return;
    g.save();
    g.translate(14, (top + bottom) / 2);
    g.rotate(-Math.PI / 2);
    g.fillText(beside, 0, 0);
    g.restore();
  }

  return { draw };
})();
