"use strict";
/* Formats names, units and numbers for display. */
const Text = (() => {
  const GREEK = new Map(
    Object.entries({
      alpha: "α",
      beta: "β",
      gamma: "γ",
      delta: "δ",
      epsilon: "ε",
      zeta: "ζ",
      eta: "η",
      theta: "θ",
      iota: "ι",
      kappa: "κ",
      lambda: "λ",
      mu: "μ",
      nu: "ν",
      xi: "ξ",
      pi: "π",
      rho: "ρ",
      sigma: "σ",
      tau: "τ",
      phi: "φ",
      chi: "χ",
      psi: "ψ",
      omega: "ω",
      Gamma: "Γ",
      Delta: "Δ",
      Theta: "Θ",
      Lambda: "Λ",
      Sigma: "Σ",
      Phi: "Φ",
      Psi: "Ψ",
      Omega: "Ω",
    }),
  );
  const SUPER = new Map([..."0123456789-"].map((c, k) => [c, "⁰¹²³⁴⁵⁶⁷⁸⁹⁻"[k]]));
  const SUB = [..."₀₁₂₃₄₅₆₇₈₉"];
  const superscript = (text) => [...text].map((c) => SUPER.get(c) || c).join("");
  const subscript = (text) =>
    [...text].map((c) => (c >= "0" && c <= "9" ? SUB[c.charCodeAt(0) - 48] : c)).join("");

  /* Splits theta1' into {letter "θ", sub "1", tail "′"}; a word that is no Greek letter is kept. */
  function parts(name) {
    const rate = /^omega\((\w+)\)\.([xyz])$/.exec(name);
    if (rate)
      return { letter: "ω", sub: (rate[1] === "R" ? "" : rate[1] + ",") + rate[2], tail: "" };
    const found = /^(.*?)('*)((?:\.[A-Za-z]\w*)?)$/s.exec(name);
    let [, body, primes, member] = found;
    let index = "";
    const bracket = /^(.*)\[([^\]]*)\]$/s.exec(body);
    if (bracket) [, body, index] = bracket;
    let sub = "";
    const under = /^([A-Za-z]+)_(\w+)$/.exec(body);
    const digits = /^([A-Za-z]+?)(\d+)$/.exec(body);
    if (under && (GREEK.has(under[1]) || under[1].length === 1)) [, body, sub] = under;
    else if (digits && (GREEK.has(digits[1]) || digits[1].length <= 2)) [, body, sub] = digits;
    const letter = GREEK.get(body) || body;
    sub = GREEK.get(sub) || sub;
    return {
      letter,
      sub: [sub, index].filter(Boolean).join(","),
      tail: "′".repeat(primes.length) + member,
    };
  }

  /* Returns a name as plain text for menus and canvases, with digits as Unicode subscripts. */
  function plain(name) {
    const { letter, sub, tail } = parts(String(name));
    const small = /^[\d]*$/.test(sub) ? subscript(sub) : "_" + sub;
    return letter + (sub ? small : "") + tail;
  }

  function symbol(name) {
    const { letter, sub, tail } = parts(String(name));
    const element = Dom.h("span", { class: letter.length > 2 ? "sym word" : "sym" }, letter);
    if (sub) element.append(Dom.h("sub", null, sub));
    if (tail) element.append(tail);
    return element;
  }

  function unit(text) {
    if (!text || text === "1") return "";
    return text
      .replace(/\*/g, "·")
      .replace(/\^\(?(-?\d+)\)?/g, (_, n) => superscript(n))
      .replace(/\bdeg\b/g, "°")
      .replace(/-/g, "−");
  }

  const minus = (text) => text.replace(/-/g, "−");

  function number(x, digits = 4) {
    if (x === null || x === undefined || Number.isNaN(x)) return "–";
    if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
    if (x === 0) return "0";
    const size = Math.abs(x);
    if (size >= 1e-3 && size < 1e5) return minus(String(Number(x.toPrecision(digits))));
    const [mantissa, exponent] = x.toExponential(Math.max(0, Math.min(digits, 3) - 1)).split("e");
    const head = Number(mantissa);
    const power = "10" + superscript(String(Number(exponent)));
    return minus(Math.abs(head) === 1 ? (head < 0 ? "-" : "") + power : `${head}×${power}`);
  }

  /* Rounds the long numbers in a message. */
  const shorter = (words) => words.replace(/\d+\.\d{6,}(e[-+]?\d+)?/g, (x) => number(Number(x), 6));

  const powerOfTen = (x) => {
    const k = Math.round(Math.log10(x));
    return Math.abs(Math.log10(x) - k) < 1e-9 ? "10" + superscript(String(k)) : "";
  };

  const quantity = (x, u, digits) => {
    const written = unit(u);
    return number(x, digits) + (written ? (written === "°" ? "" : " ") + written : "");
  };

  /* Returns radians as degrees, such as "74.5°", and rates as "°/s"; "" for other units. */
  const degrees = (x, u) =>
    /^rad\b/.test(u || "") ? number((x * 180) / Math.PI, 4) + "°" + unit(u.slice(3)) : "";

  /* Returns the label of an axis, such as "θ₁ [rad]". */
  const axis = (name, u) => plain(name) + (unit(u) ? ` [${unit(u)}]` : "");

  return { plain, symbol, unit, number, quantity, degrees, axis, powerOfTen, minus, shorter };
})();
