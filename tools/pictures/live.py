"""The live page of the double pendulum in headless Chromium: docs/pictures/show.webp, which moves,
and show.png."""

from __future__ import annotations

import io
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from rows import MODELS

METHODS = "m=gauss&m=gauss1:0.04&m=rk4:0.07&m=rk2:0.03&ref=1&panels=drift,distance,phase&paused=1"
STILL = "m=gauss&m=rk4:0.05&m=gauss1:0.05&m=euler:0.005&ref=1&panels=drift,distance,time&paused=1"
# As wide as the pages that show them, so that letters are as large there; so many pixels each.
SIZE, STILL_SIZE, PIXELS = {"width": 900, "height": 620}, {"width": 960, "height": 740}, 2
SECONDS, FPS, TICKS = 8, 15, 60
STILL_AT = 6.6  # seconds
BROWSER = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--hide-scrollbars"]


@contextmanager
def page(fragment: str, size: dict[str, int]) -> Iterator:
    """It stands still, at its start."""
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        file = Path(folder) / "page.html"
        model = str(MODELS / "double_pendulum.lag")
        command = [sys.executable, "-m", "pkgen", "show", model, "-o", str(file)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=BROWSER)
        tab = browser.new_page(viewport=size, color_scheme="light", device_scale_factor=PIXELS)
        tab.goto(f"file://{file}#{fragment}")
        tab.wait_for_selector("html[data-ready=yes]")
        tab.evaluate("lab.pause()")
        yield tab
        browser.close()


def tick(tab, count: int) -> None:
    for _ in range(count):
        tab.evaluate("lab.tick()")


def still() -> bytes:
    """With the list of methods."""
    with page(STILL, STILL_SIZE) as tab:
        tab.get_by_role("tab", name="Methods").click()
        tick(tab, round(STILL_AT * TICKS))
        seen = Image.open(io.BytesIO(tab.screenshot())).convert("RGB")
    file = io.BytesIO()
    seen.quantize(128).save(file, "png", optimize=True)
    return file.getvalue()


def moving() -> bytes:
    frames = []
    with page(METHODS, SIZE) as tab:
        tab.add_style_tag(content=".hint, .stage-views, .stage-tools { visibility: hidden }")
        for _ in range(SECONDS * FPS):
            tick(tab, round(TICKS / FPS))
            frame = Image.open(io.BytesIO(tab.screenshot())).convert("RGB")
            side = tab.locator("#side").bounding_box()["x"]
            frame = frame.crop((0, 45, side, SIZE["height"]))
            width, height = frame.size
            frames.append(frame.resize((width * 7 // 8, height * 7 // 8), Image.LANCZOS))
    file = io.BytesIO()
    first, *rest = frames
    more = {"append_images": rest, "duration": 1000 // FPS, "loop": 0}
    first.save(file, "webp", save_all=True, quality=50, method=4, **more)
    return file.getvalue()
