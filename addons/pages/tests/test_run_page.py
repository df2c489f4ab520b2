"""`pkgen run --report`: one page of a run, well or not."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from conftest import ROOT, case, run_pkgen

TOP = ROOT / "models/heavy_top.lag"
FALL = case("report_fall")


class Page(HTMLParser):
    """Tags, headings and the text of a page."""

    def __init__(self, html: str):
        super().__init__()
        self.html, self.tags, self.text, self.addresses = html, [], [], []
        self.feed(html)
        self.said = " ".join(" ".join(self.text).split())

    def handle_starttag(self, tag: str, attributes: list) -> None:
        self.tags.append(tag)
        assert not any(name.startswith("on") for name, _ in attributes)
        self.addresses += [v for k, v in attributes if k in ("src", "href", "xlink:href") and v]

    def handle_data(self, data: str) -> None:
        if self.tags[-1:] != ["style"]:
            self.text.append(data)


def made(folder: Path, *words: object, code: int = 0) -> Page:
    out = folder / "report.html"
    done = run_pkgen("run", *words, "--report", out)
    assert done.returncode == code and done.stdout == "", done.stderr
    assert "Traceback" not in done.stderr and "internal" not in done.stderr
    return Page(out.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    (folder / "fall.lag").write_text(FALL)
    return folder


def test_all_of_a_run_is_on_its_page(folder: Path) -> None:
    page = made(folder, TOP, "--set", "l=0.3", "--diagnose", "spectrum")
    assert page.tags.count("svg") == 3
    for said in ("Done", "p_phi", "spectrum: theta:", "gauss: t = 10 s after"):
        assert said in page.said, said
    assert any(how in page.said for how in ("round-off", "random walk", "secular, as t"))
    headings = re.findall(r"<h2>(.*?)</h2>", page.html)
    assert headings[:3] == ["Pictures", "Drifts", "Diagnostics"] and "Settings" in headings
    assert "φ" in page.said and "[rad]" in page.said
    for name, value, unit in (("l", "0.3", "m"), ("psi&#x27;", "18", "rad/s")):
        assert re.search(rf">{name}</td>\s*<td[^>]*>{value}</td>\s*<td>{unit}<", page.html)


def test_the_page_asks_for_nothing_and_runs_nothing(folder: Path) -> None:
    page = made(folder, TOP)
    assert "script" not in page.tags and "default-src 'none'" in page.html
    assert all(a.startswith(("#", "data:image/png")) for a in page.addresses)
    assert not re.search(r"https?://", page.html)


def test_names_are_text(folder: Path) -> None:
    page = made(folder, folder / "fall.lag", "--until", 1)
    assert not {"script", "img", "b "} & set(page.tags) and page.tags.count("b") == 1
    assert "alert(2)" in page.html and "<script" not in page.html and "&lt;script&gt;" in page.html


def test_a_run_that_fails_says_so_first(folder: Path) -> None:
    page = made(folder, folder / "fall.lag", code=4)
    status, pictures = page.html.index("Failed: "), page.html.index("<h2>Pictures")
    assert status < pictures and "vanishes at t = 1.11" in page.html[status:pictures]
    assert page.tags.count("svg") >= 2 and "as far as it came" in page.said
    assert re.search(r"near</td>\s*<td[^>]*>1<", page.html)
    assert "status failed" in page.html


def test_one_that_does_not_start_has_its_page(folder: Path) -> None:
    page = made(folder, folder / "fall.lag", "--start", "x=0", code=4)
    assert "no pictures" in page.said and "svg" not in page.tags
    assert "vanishes at t = 0" in page.said and "status failed" in page.html


def test_what_was_expected_is_told(folder: Path) -> None:
    page = made(folder, folder / "fall.lag", "--scene", "expected", code=4)
    assert "expectations are missed" in page.said and "1 of 2 expectations met" in page.said
    assert page.html.count("class=failed") == 1 and "is not below 0.9" in page.said


def test_members(folder: Path) -> None:
    well = ROOT / "models/particles/henon_heiles.lag"
    page = made(folder, well, "--scene", "sections", "--until", 100)
    assert "60 of 60 members done" in page.said and page.tags.count("svg") >= 2
    assert len(page.html) < 1_500_000


def test_a_view_comes_first(folder: Path) -> None:
    page = made(folder, TOP, "--phase", "theta")
    assert page.html.index("As asked") < page.html.index("Over time")


def test_the_page_is_replaced_whole(folder: Path) -> None:
    out = folder / "kept.html"
    out.write_text("old")
    done = run_pkgen("run", TOP, "--report", out, "--method", "rk5")
    assert done.returncode == 2 and out.read_text() == "old"
    done = run_pkgen("run", TOP, "--report", out, "-o", folder / "rows.csv")
    assert done.returncode == 0 and out.read_text().startswith("<!DOCTYPE html>")
    assert (folder / "rows.csv").exists() and not [*folder.glob("*.partial")]


def test_a_column_that_is_none_leaves_no_page(folder: Path) -> None:
    out = folder / "none.html"
    done = run_pkgen("run", TOP, "--report", out, "--columns", "aa")
    assert done.returncode == 2 and "--columns aa" in done.stderr and not out.exists()
