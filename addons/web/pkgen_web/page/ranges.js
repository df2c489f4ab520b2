"use strict";
/* The range of a slider. It is given by the bounds in the model, if a quantity has both. Otherwise
 * a positive parameter with lower bound 0 has a logarithmic range, from a tenth of its value to ten
 * times its value. The range of an angle is one turn. The range of any other quantity extends to
 * three times its value; if the value is 0, to three times the largest value with the same unit, or
 * else to 1. The number field next to the slider accepts any value within the model's bounds. */
const Ranges = (() => {
  const finite = (x) => typeof x === "number" && Number.isFinite(x);

  function nice(x) {
    if (!(x > 0) || !Number.isFinite(x)) return 1;
    const power = 10 ** Math.floor(Math.log10(x));
    const head = x / power;
    return (head <= 1 ? 1 : head <= 2 ? 2 : head <= 5 ? 5 : 10) * power;
  }

  /* Returns {lo, hi, log}. `peers` is the largest magnitude among values of the same unit. */
  function of(entry, value, peers) {
    const lo = finite(entry.lo) ? entry.lo : null;
    const hi = finite(entry.hi) ? entry.hi : null;
    if (lo !== null && hi !== null) {
      if (lo > 0 && hi / lo > 1000) return { lo, hi, log: true };
      return { lo, hi, log: false };
    }
    const size = Math.abs(value);
    if (lo !== null && lo >= 0 && value > lo) {
      if (lo === 0) return { lo: value / 10, hi: value * 10, log: true };
      return { lo, hi: nice(lo + 3 * (value - lo)), log: false };
    }
    const angle = entry.unit === "rad" || entry.periodic;
    const reach = angle ? Math.max(Math.PI, size) : nice(3 * size || 3 * (peers || 0) || 1);
    return { lo: lo === null ? -reach : lo, hi: hi === null ? reach : hi, log: false };
  }

  /* A slider has STEPS positions; its value is rounded to the resolution of one position. */
  const STEPS = 1000;
  function toPlace(range, value) {
    const [a, b, x] = range.log
      ? [range.lo, range.hi, value].map(Math.log)
      : [range.lo, range.hi, value];
    return Math.round(STEPS * Math.min(1, Math.max(0, (x - a) / (b - a || 1))));
  }
  function fromPlace(range, place) {
    const s = place / STEPS;
    if (place <= 0) return range.lo;
    if (place >= STEPS) return range.hi;
    const x = range.log
      ? range.lo * (range.hi / range.lo) ** s
      : range.lo + s * (range.hi - range.lo);
    const grain = range.log ? x / 300 : (range.hi - range.lo) / STEPS;
    const power = 10 ** Math.floor(Math.log10(grain));
    return Number((Math.round(x / power) * power).toPrecision(12));
  }

  /* Returns null, or the reason why a number is not allowed. */
  function refuse(entry, x) {
    if (!Number.isFinite(x)) return "not a number";
    if (finite(entry.lo) && (x < entry.lo || (entry.lo_open && x === entry.lo)))
      return `${entry.lo_open ? "must be above" : "at least"} ${Text.number(entry.lo)}`;
    if (finite(entry.hi) && (x > entry.hi || (entry.hi_open && x === entry.hi)))
      return `${entry.hi_open ? "must be below" : "at most"} ${Text.number(entry.hi)}`;
    return null;
  }

  return { of, toPlace, fromPlace, refuse, nice, STEPS };
})();
