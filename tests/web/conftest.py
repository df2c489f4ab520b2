"""A browser without a window, and pages of models in it.

Debian's Chromium is driven by Playwright; WebGL is drawn in software (SwiftShader through ANGLE).
Where there is no browser, or no clang for WebAssembly, these tests are skipped.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import quote

import pytest
from conftest import run_pkgen

FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
READY = 60_000  # ms: a busy machine starts slowly


@pytest.fixture(scope="session")
def browser() -> Iterator:
    api = pytest.importorskip("playwright.sync_api", reason="no Playwright here")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.skip("no Chromium here")
    with api.sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        yield opened
        opened.close()


@pytest.fixture(scope="session")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """The page of a model, made once."""
    folder = tmp_path_factory.mktemp("pages")
    made: dict[tuple, Path] = {}

    def pack(model: Path, *more: str) -> Path:
        key = (model, *more)
        if key not in made:
            path = folder / f"{len(made)}.html"
            done = run_pkgen("show", model, *more, "-o", path)
            if done.returncode and "install" in done.stderr:
                pytest.skip(done.stderr.strip().splitlines()[0])
            assert done.returncode == 0, done.stderr
            made[key] = path
        return made[key]

    return pack


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
        self.page.wait_for_function(
            "n => new Promise(done => { const next = () => n-- ? requestAnimationFrame(next) : done(1);"
            " next(); })",
            arg=count,
        )

    def drawn(self, kind: str, run: int = 0) -> list[list[list[float]]]:
        """Where the shapes of a kind stand on the stage, in pixels."""
        self.js("lab.dirty = true")
        self.frames()
        shapes = self.js("lab.stage.drawn()")
        return [s["points"] for s in shapes if s["kind"] == kind and s["run"] == run]


@pytest.fixture
def show(browser, packed) -> Iterator[Callable[..., Page]]:
    contexts = []

    def opened(
        model: Path,
        fragment: str | dict[str, object] = "",
        *,
        size: tuple[int, int] = (1280, 800),
        more: tuple[str, ...] = (),
        **context: object,
    ) -> Page:
        width, height = size
        contexts.append(
            browser.new_context(viewport={"width": width, "height": height}, **context)
        )
        if isinstance(fragment, dict):
            fragment = "&".join(f"{quote(k)}={quote(str(v))}" for k, v in fragment.items())
        return Page(contexts[-1].new_page(), packed(model, *more), fragment)

    yield opened
    for context in contexts:
        context.close()
