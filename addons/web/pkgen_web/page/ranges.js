"use strict";
/* The ends of a slider. A model bounds few of its parameters on both sides, so a rule gives the
 * others: positive ones go from a tenth to ten times their value on a logarithmic scale, others
 * three times their value to either side, angles a turn, rates and zeros one unit or as much as
 * their kind shows elsewhere. The field beside takes any value within the bounds. */
const Ranges = (() => {
  const finite = (x) => typeof x === "number" && Number.isFinite(x);

  function nice(x) {
    if (!(x > 0) || !Number.isFinite(x)) return 1;
    const power = 10 ** Math.floor(Math.log10(x));
    const head = x / power;
    return (head <= 1 ? 1 : head <= 2 ? 2 : head <= 5 ? 5 : 10) * power;
  }

  /* {lo, hi, log}. `peers` is the largest size among values of the same unit. */
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

  /* A slider has 1000 places; its value is rounded to what a place can tell apart. */
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

  /* null, or why a number is not allowed. */
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
