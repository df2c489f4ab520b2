"""`python tools/moving_picture.py`: the README's moving picture, docs/pictures/show.webp: the live
page of the double pendulum with four methods, frame by frame, in headless Chromium."""

from __future__ import annotations

import io
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parent.parent
METHODS = "m=gauss&m=gauss1:0.04&m=rk4:0.07&m=rk2:0.03&ref=1&panels=drift,distance,phase&paused=1"
SIZE = {"width": 1080, "height": 660}
SECONDS, FPS = 8, 15
BROWSER = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--hide-scrollbars"]


def main() -> int:
    frames = []
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        page = Path(folder) / "page.html"
        model = ROOT / "models" / "double_pendulum.lag"
        command = [sys.executable, "-m", "pkgen", "show", str(model), "-o", str(page)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=BROWSER)
        tab = browser.new_page(viewport=SIZE, color_scheme="light")
        tab.goto(f"file://{page}#{METHODS}")
        tab.wait_for_selector("html[data-ready=yes]")
        tab.add_style_tag(content=".hint, .stage-views, .stage-tools { visibility: hidden }")
        tab.evaluate("lab.pause()")
        for _ in range(SECONDS * FPS):
            for _ in range(round(60 / FPS)):
                tab.evaluate("lab.tick()")
            frame = Image.open(io.BytesIO(tab.screenshot())).convert("RGB")
            frames.append(
                frame.crop((0, 45, tab.locator("#side").bounding_box()["x"], SIZE["height"]))
            )
        browser.close()
    width, height = frames[0].size
    frames = [frame.resize((width * 7 // 8, height * 7 // 8), Image.LANCZOS) for frame in frames]
    path = ROOT / "docs" / "pictures" / "show.webp"
    first, *rest = frames
    more = {"append_images": rest, "duration": 1000 // FPS, "loop": 0}
    first.save(path, save_all=True, quality=50, method=4, **more)
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB, {len(frames)} frames")
    return 0


if __name__ == "__main__":
    sys.exit(main())
