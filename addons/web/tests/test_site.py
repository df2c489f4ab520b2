"""`make site`: links lead somewhere, nothing is loaded from elsewhere, and axe finds no fault.

Takes minutes: each model's live page is made.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tarfile
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

import pytest

from conftest import ROOT, SHOWN

# The site is made once, with the equations of each model.
pytestmark = [
    pytest.mark.long,
    pytest.mark.xdist_group("site"),
    pytest.mark.needs_addon("pages"),
]
SITE = ROOT / "build" / "site"
AXE = "axe-core@4.14.1"
FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
LOCAL = ("file:", "data:", "blob:", "about:")
OFF = {"empty-table-header": {"enabled": False}}  # the first column of a table may speak for itself
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]


@pytest.fixture(scope="module")
def site() -> Path:
    done = subprocess.run(["make", "-s", "site"], cwd=ROOT, capture_output=True, text=True)
    if "install" in done.stderr and "no live page" in done.stderr:
        pytest.skip(done.stderr.strip().splitlines()[0])
    if "No matching distribution" in done.stderr or "No module named" in done.stderr:
        pytest.skip("MkDocs is not to be had here")
    assert done.returncode == 0, done.stdout + done.stderr
    return SITE


class Read(HTMLParser):
    """The ids of a page, its links, and what it loads."""

    def __init__(self, path: Path):
        super().__init__()
        self.ids, self.links, self.loads = {"", "__top"}, [], []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, given: list[tuple[str, str | None]]) -> None:
        values = {k: v or "" for k, v in given}
        self.ids |= {values[k] for k in ("id", "name") if k in values}
        if tag in ("a", "area") and "href" in values:
            self.links.append(values["href"])
        elif tag == "link" and values.get("rel") not in ("canonical", "prev", "next"):
            self.loads.append(values["href"])
        elif "src" in values:
            self.loads.append(values["src"])


def pages(site: Path) -> Iterator[Path]:
    """All but the live ones, which have tests of their own."""
    return (p for p in sorted(site.rglob("*.html")) if p.parent.name != "live")


def test_links_lead_somewhere(site: Path) -> None:
    read = {path: Read(path) for path in pages(site)}
    assert len(read) > 70
    wrong = []
    for path, page in read.items():
        if path.name == "404.html":
            continue
        for address in (*page.links, *page.loads):
            if re.match(r"(https?|mailto|data):", address):
                continue
            file, anchor = urldefrag(unquote(address))
            target = (path.parent / file).resolve() if file else path
            if not target.is_file():
                wrong.append(f"{path.name}: {address}")
            elif anchor and target in read and anchor not in read[target].ids:
                wrong.append(f"{path.name}: {address}: no such place")
    assert not wrong, "\n".join(wrong)


def test_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    for path in pages(site):
        assert not [x for x in Read(path).loads if re.match(r"(https?:)?//", x)], path
    for path in site.rglob("*.css"):
        assert not re.search(r"url\(\s*['\"]?(https?:)?//|@import", path.read_text()), path


def test_each_model_has_its_page(site: Path) -> None:
    for model in SHOWN:
        page = (site / f"models/{model.stem}.html").read_text(encoding="utf-8")
        assert f'src="../live/{model.stem}.html"' in page and "<math" in page
        assert (site / f"live/{model.stem}.html").stat().st_size < 1_500_000


# -- in a browser ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def axe() -> str:
    """The checker, by npm; kept in build/."""
    folder = ROOT / "build" / "axe"
    script = folder / f"{AXE}.js"
    if not script.exists():
        if shutil.which("npm") is None:
            pytest.skip("no npm here, by which axe-core comes")
        folder.mkdir(parents=True, exist_ok=True)
        done = subprocess.run(["npm", "pack", AXE], cwd=folder, capture_output=True, text=True)
        if done.returncode:
            pytest.skip("axe-core is not to be had here")
        with tarfile.open(folder / done.stdout.split()[-1]) as packed:
            script.write_bytes(packed.extractfile("package/axe.min.js").read())
    return script.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def browser() -> Iterator:
    api = pytest.importorskip("playwright.sync_api", reason="no Playwright here")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.skip("no Chromium here")
    with api.sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        yield found
        found.close()


@pytest.mark.parametrize(("scheme", "width"), [("light", 1300), ("dark", 390)])
def test_axe_finds_no_fault(site: Path, axe: str, browser, scheme: str, width: int) -> None:
    context = browser.new_context(
        color_scheme=scheme, viewport={"width": width, "height": 900}, reduced_motion="reduce"
    )
    asked: list[str] = []
    context.route("**/live/**", lambda route: route.abort())  # they have tests of their own
    context.on("request", lambda request: asked.append(request.url))
    faults = []
    for path in pages(site):
        if path.name == "404.html":  # its addresses are of a server's root
            continue
        page = context.new_page()
        page.goto(path.as_uri(), wait_until="load")
        page.evaluate(axe)
        page.wait_for_timeout(100)  # two frames, after which what scrolls can be reached
        options = {"runOnly": {"type": "tag", "values": RULES}, "iframes": False, "rules": OFF}
        found = page.evaluate("options => axe.run(document, options)", options)
        for fault in found["violations"]:
            node = fault["nodes"][0]
            where = f"{len(fault['nodes'])} such as {node['html'][:160]}"
            faults.append(f"{path.name}: {fault['id']}: {fault['help']}: {where}")
        if width < 500:
            wide = page.evaluate("document.documentElement.scrollWidth")
            faults += [f"{path.name}: {wide} px wide"] if wide > width else []
        page.close()
    context.close()
    elsewhere = [x for x in asked if not x.startswith(LOCAL)]
    assert not elsewhere and not faults, "\n".join([*elsewhere[:5], *faults])


def test_search_works_from_a_folder(site: Path, browser) -> None:
    page = browser.new_page(viewport={"width": 1300, "height": 900})
    page.goto((site / "models/double_pendulum.html").as_uri())
    page.locator(".md-search__input").first.fill("rattleback")
    page.wait_for_selector(".md-search-result__item", state="attached", timeout=30_000)
    page.close()
