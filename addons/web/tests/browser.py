"""A browser without a window, and pages of models in it.

Debian's Chromium is driven by Playwright; WebGL is drawn in software (SwiftShader through ANGLE).
Where there is no browser, or no clang for WebAssembly, these tests are skipped.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from conftest import run_pkgen

FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
READY = 120_000  # ms: a busy machine starts slowly


def opened() -> Iterator:
    """The browser."""
    api = pytest.importorskip("playwright.sync_api", reason="no Playwright here")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.skip("no Chromium here")
    with api.sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        yield found
        found.close()


class Packer:
    """Pages of models, each made once."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.made: dict[tuple, Path] = {}

    def __call__(self, model: Path, *more: str) -> Path:
        key = (model, model.read_text(encoding="utf-8"), *more)
        if key not in self.made:
            path = self.folder / f"{len(self.made)}.html"
            done = run_pkgen("show", model, *more, "-o", path)
            if done.returncode and "install" in done.stderr:
                pytest.skip(done.stderr.strip().splitlines()[0])
            assert done.returncode == 0, done.stderr
            self.made[key] = path
        return self.made[key]


class Page:
    """A page that is ready; what its console says is kept."""

    def __init__(self, page, path: Path, fragment: str):
        self.page = page
        self.said: list[str] = []
        self.asked: list[str] = []
        page.on("console", self.hear)
        page.on("pageerror", lambda error: self.said.append(f"error: {error}"))
        page.on("request", lambda request: self.asked.append(request.url))
        page.goto(f"file://{path}" + (f"#{fragment}" if fragment else ""))
        page.wait_for_selector("html[data-ready=yes]", timeout=READY)

    def hear(self, message) -> None:
        # Chromium's own words on drawing in software are none of the page's.
        if "GPU stall" not in message.text:
            self.said.append(f"{message.type}: {message.text}")

    def js(self, expression: str):
        return self.page.evaluate(expression)

    def pause(self) -> None:
        self.js("lab.pause()")

    def frames(self, count: int = 2) -> None:
        """As many frames later, at least."""
        self.page.evaluate(
            "n => new Promise(done => {"
            " const next = () => n-- ? requestAnimationFrame(next) : done(); next(); })",
            count,
        )

    def until(self, condition: str, seconds: float = 60) -> None:
        """Asks by evaluate(): the page's policy forbids what Playwright waits with."""
        end = time.monotonic() + seconds
        while not self.js(condition):
            assert time.monotonic() < end, condition
            self.page.wait_for_timeout(50)

    def drawn(self, kind: str, run: int = 0) -> list[list[list[float]]]:
        """Where the shapes of a kind stand on the stage, in pixels."""
        self.js("lab.dirty = true")
        self.frames()
        shapes = self.js("lab.stage.drawn()")
        return [s["points"] for s in shapes if s["kind"] == kind and s["run"] == run]


@pytest.fixture(scope="module", name="browser")
def browser_() -> Iterator:
    yield from opened()


@pytest.fixture(scope="module", name="packed")
def packed_(tmp_path_factory: pytest.TempPathFactory) -> Packer:
    return Packer(tmp_path_factory.mktemp("pages"))


@pytest.fixture(name="show")
def show_(browser, packed) -> Iterator[Callable[..., Page]]:
    contexts = []

    def shown(model: Path, fragment: str = "", size=(1280, 800), **context: object) -> Page:
        width, height = size
        contexts.append(browser.new_context(viewport={"width": width, "height": height}, **context))
        return Page(contexts[-1].new_page(), packed(model), fragment)

    yield shown
    for context in contexts:
        context.close()
