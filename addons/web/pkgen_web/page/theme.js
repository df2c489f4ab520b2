"use strict";
/* Colours for the canvases, read from the variables of the style sheet. The four colours of the
 * methods are distinguishable with any colour vision (Okabe, Ito); their dashes differ too. */
const Theme = (() => {
  const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3]];
  let colours = null;

  function read() {
    const style = getComputedStyle(document.documentElement);
    const of = (name) => style.getPropertyValue(name).trim();
    colours = {
      ink: of("--ink"),
      soft: of("--soft"),
      faint: of("--faint"),
      line: of("--line"),
      page: of("--page"),
      stage: of("--stage"),
      body: of("--body"),
      metal: of("--metal"),
      methods: [of("--m0"), of("--m1"), of("--m2"), of("--m3")],
      reference: of("--reference"),
      shapes: [of("--s0"), of("--s1"), of("--s2"), of("--s3")],
      font: of("--font"),
      dark:
        document.documentElement.dataset.theme === "dark" ||
        (!document.documentElement.dataset.theme &&
          matchMedia("(prefers-color-scheme: dark)").matches),
    };
    return colours;
  }

  const now = () => colours || read();
  const ofRun = (run) => (run.index < 0 ? now().reference : now().methods[run.index]);
  const dashOf = (run) => (run.index < 0 ? [4, 4] : DASHES[run.index]);

  /* Converts #rrggbb to [r, g, b] in 0..1. */
  function rgb(hex) {
    const n = parseInt(hex.slice(1), 16);
    return [(n >> 16) / 255, ((n >> 8) & 255) / 255, (n & 255) / 255];
  }

  function toggle() {
    document.documentElement.dataset.theme = now().dark ? "light" : "dark";
    read();
  }

  return { now, read, toggle, ofRun, dashOf, rgb };
})();
