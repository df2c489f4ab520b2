"""`python -m bench show [--docs]`: `pkgen show` of every model, opened in headless Chromium.

A row a model: bytes of the page, seconds to make it when its C is compiled for the first time and
again, frames a second with one method, steps a second of the page's rk4 beside those of a native
run (of gauss4 where rk4 does not apply). Exit code 4 if a page has an error, or does not move.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from . import machine
from .tables import table

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "addons/web/README.md"
MARK = "<!-- python -m bench show --docs -->\n"
HEAD = ("model", "kB", "made, s", "again, s", "frames/s", "steps/s", "native", "ratio")
BROWSER = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader")
STEPS = """async ([method, step, count]) => {
  const { engine } = lab;
  const start = engine.defaults();
  const m = engine.motion({ method, step, params: start.params, q: start.q, v: start.v });
  m.advance(step * 10);
  const before = m.steps, began = performance.now();
  m.advance(step * count);
  const seconds = (performance.now() - began) / 1000;
  return (m.steps - before) / seconds;
}"""
FRAMES = """() => new Promise((done) => {
  let count = 0;
  const began = performance.now();
  const tick = (now) => {
    count++;
    if (now - began < 2000) requestAnimationFrame(tick); else done(count / ((now - began) / 1000));
  };
  requestAnimationFrame(tick);
})"""


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench show", description=__doc__)
    parser.add_argument("--docs", action="store_true", help="write the table into its page")
    options = parser.parse_args(words)
    from playwright.sync_api import sync_playwright

    rows, wrong = [], []
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        chromium = playwright.chromium
        browser = chromium.launch(executable_path="/usr/bin/chromium", args=list(BROWSER))
        for model in sorted((ROOT / "models").rglob("*.lag")):
            page = Path(folder) / f"{model.stem}.html"
            cold, warm = (_made(model, page, Path(folder)) for _ in range(2))
            row, errors = _opened(browser, page, model)
            wrong += [f"{model.stem}: {error}" for error in errors]
            rows.append((model.stem, page.stat().st_size / 1000, cold, warm, *row))
            print(
                " ".join(f"{x:.3g}" if isinstance(x, float) else str(x) for x in rows[-1]),
                flush=True,
            )
        browser.close()
    for line in wrong:
        print(line, file=sys.stderr)
    if options.docs:
        _write(rows)
    return 4 if wrong else 0


def _made(model: Path, page: Path, folder: Path) -> float:
    """Seconds. The model's own part of the cache is new; that of the runtime stays."""
    began = time.monotonic()
    command = [sys.executable, "-m", "pkgen", "show", str(model), "-o", str(page)]
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "pkgen"
    own = folder / "cache"
    if not own.exists():
        own.mkdir()
        for kind in ("runtime", "runtime-wasm", "parser", "methods"):
            if (cache / kind).exists():
                (own / kind).symlink_to(cache / kind)
    subprocess.run(
        command, env={**os.environ, "PKGEN_CACHE": str(own)}, check=True, capture_output=True
    )
    return time.monotonic() - began


def _opened(browser, page: Path, model: Path) -> tuple[tuple[float, ...], list[str]]:
    errors: list[str] = []
    tab = browser.new_page(viewport={"width": 1280, "height": 800})
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
    tab.goto(f"file://{page}")
    tab.wait_for_selector("html[data-ready]", timeout=20000)
    tab.wait_for_timeout(500)
    before = tab.evaluate("lab.runs.t")
    frames = tab.evaluate(FRAMES)
    now = tab.evaluate("lab.runs.t")
    if not now > before and not now > 1:  # it may have come to an event that stops it
        errors.append(f"it does not move: {tab.inner_text('#note')}")
    methods = {m["name"]: m for m in tab.evaluate("lab.model.description.methods")}
    method = "rk4" if methods["rk4"]["applies"] else "gauss4"
    step, count = 1e-4, 20000
    try:
        here = tab.evaluate(STEPS, [method, step, count])
    except Exception as error:
        here = float("nan")
        errors.append(f"{method}: {error}")
    tab.close()
    native = _native(model, method, step, count)
    return (frames, here, native, here / native), errors


def _native(model: Path, method: str, step: float, count: int) -> float:
    command = [sys.executable, "-m", "pkgen", "run", str(model), "--json", "--method", method]
    more = ["--step", str(step), "--until", str(step * count), "--every", str(step * count)]
    done = subprocess.run([*command, *more], capture_output=True, text=True)
    report = json.loads(done.stdout)["report"]
    return report["steps"] / report["seconds"]


def _write(rows: list[tuple]) -> None:
    before, mark, _ = PAGE.read_text(encoding="utf-8").partition(MARK)
    shown = [
        (
            name,
            f"{kb:.0f}",
            f"{cold:.1f}",
            f"{warm:.1f}",
            f"{fps:.0f}",
            f"{a:.2g}",
            f"{b:.2g}",
            f"{r:.2f}",
        )
        for name, kb, cold, warm, fps, a, b, r in rows
    ]
    said = "\n".join(machine.describe().lines())
    assert mark
    PAGE.write_text(f"{before}{mark}\n{table(HEAD, shown)}\n\n{said}\n", encoding="utf-8")
