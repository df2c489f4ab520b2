"use strict";
/* Starts the page: reads the description, loads the engine, connects the controls. */
const Main = (() => {
  const { $, h, say } = Dom;
  const KEYS = [
    ["space", "play or pause"],
    ["→", "one frame on"],
    ["R", "back to the start"],
    ["+ −", "faster, slower"],
    ["F", "fit all in"],
    ["S", "scene or swarm"],
    ["D", "dark or light"],
    ["?", "these keys"],
  ];
  const TABS = [
    ["values", "Values"],
    ["methods", "Methods"],
    ["swarm", "Swarm"],
    ["model", "Model"],
  ];
  const MAP = ["map", "Map"]; /* the tab of a sweep's map */

  async function bytes() {
    const text = $("wasm").textContent.trim();
    if (!text) return new Uint8Array();
    const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  function tabs() {
    const list = $("tabs");
    const choose = (name) => {
      for (const [key] of TABS) {
        $("sheet-" + key).hidden = key !== name;
        const tab = $("tab-" + key);
        tab.setAttribute("aria-selected", String(key === name));
        tab.tabIndex = key === name ? 0 : -1;
      }
    };
    TABS.forEach(([key, title], k) => {
      list.append(
        h(
          "button",
          {
            type: "button",
            role: "tab",
            id: "tab-" + key,
            class: "tab",
            "aria-controls": "sheet-" + key,
            onclick: () => choose(key),
            onkeydown: (event) => {
              const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
              if (!by) return;
              event.stopPropagation();
              event.preventDefault();
              const [next] = TABS[(k + by + TABS.length) % TABS.length];
              choose(next);
              $("tab-" + next).focus();
            },
          },
          title,
        ),
      );
      $("sheet-" + key).setAttribute("aria-labelledby", "tab-" + key);
    });
    choose(TABS[0][0]);
  }

  function controls(lab) {
    $("play").addEventListener("click", () => lab.toggle());
    const step = () => {
      lab.pause();
      lab.tick();
    };
    const reset = () => {
      lab.restart();
    };
    $("step").addEventListener("click", step);
    $("reset").addEventListener("click", reset);
    $("speed").addEventListener("input", () => lab.setSpeed(Number($("speed").value)));
    const theme = () => {
      Theme.toggle();
      lab.shown();
    };
    $("theme").addEventListener("click", theme);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      Theme.read();
      lab.shown();
    });
    $("view-scene").addEventListener("click", () => lab.show("scene"));
    $("view-swarm").addEventListener("click", () => lab.show("swarm"));
    $("view-swarm").hidden = !lab.swarm.can();
    $("share").addEventListener("click", async () => {
      lab.changed();
      try {
        await navigator.clipboard.writeText(location.href);
        say($("share"), "Copied");
      } catch (error) {
        say($("share"), "See the address");
      }
      setTimeout(() => say($("share"), "Copy link"), 1500);
    });
    const help = () => $("keys").showModal();
    $("help").addEventListener("click", help);
    $("keys").append(
      h(
        "form",
        { method: "dialog" },
        h("h2", null, "Keys"),
        h(
          "dl",
          null,
          ...KEYS.flatMap(([key, what]) => [
            h("dt", null, h("kbd", null, key)),
            h("dd", null, what),
          ]),
        ),
        h(
          "p",
          null,
          "Drag a body to set the start; drag beside it to move the view; wheel or pinch to zoom.",
        ),
        h("button", { class: "wide" }, "Close"),
      ),
    );
    const keys = {
      " ": () => lab.toggle(),
      ArrowRight: step,
      r: reset,
      f: () => lab.stage.fit(),
      d: theme,
      "?": help,
      "+": () => lab.setSpeed(lab.settings.speed + 1),
      "=": () => lab.setSpeed(lab.settings.speed + 1),
      "-": () => lab.setSpeed(lab.settings.speed - 1),
      s: () => {
        if (lab.swarm.can()) lab.show(lab.settings.view === "swarm" ? "scene" : "swarm");
      },
    };
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.target.closest("input, select, textarea, dialog, summary")) return;
      if (event.key === " " && event.target.closest("button")) return;
      const act = keys[event.key] || keys[event.key.toLowerCase()];
      if (!act) return;
      event.preventDefault();
      act();
    });
    window.addEventListener("hashchange", () => {
      lab.settings = Settings.read(lab.model, location.hash);
      lab.restart();
      lab.sheets.methods.build();
    });
  }

  function head(lab) {
    const { description } = lab.model;
    const words = description.description === description.title ? "" : description.description;
    say($("title"), description.title);
    say($("subtitle"), words || "");
    $("subtitle").title = words || "";
    const scenes = description.scenes || [];
    const rows = [
      ["", "as the model says"],
      ...scenes.map((s) => [s.name, s.name.replace(/_/g, " ")]),
    ];
    for (const [value, text] of rows) $("scene").append(h("option", { value }, text));
    $("scene-field").hidden = !scenes.length;
    $("scene").addEventListener("change", () => lab.enter($("scene").value || null));
  }

  async function open() {
    const description = JSON.parse($("description").textContent);
    if (description.map) TABS.unshift(MAP);
    tabs();
    const engine = await Engine.load(await bytes(), description);
    const lab = Lab.make(engine, Model.make(description));
    window.lab = lab;
    head(lab);
    lab.open();
    controls(lab);
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    say($("hint"), lab.drag.can() ? "Drag a body to set the start" : "");
    setTimeout(() => $("hint").classList.add("gone"), 6000);
    if (!still && !/[#&]paused/.test(location.hash)) lab.play();
    document.documentElement.dataset.ready = "yes";
  }

  return {
    open: () =>
      open().catch((error) => {
        say($("note"), "The page could not start: " + (error.message || error));
        document.documentElement.dataset.ready = "no";
        throw error;
      }),
  };
})();
Main.open();
