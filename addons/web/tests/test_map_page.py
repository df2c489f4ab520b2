"""`pkgen show` of a sweep: a member that is clicked moves, with what the plan sets and draws."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import Page, browser_  # noqa: F401

from conftest import ROOT

pytest.importorskip("pyarrow")
pytestmark = [pytest.mark.long, pytest.mark.needs_addon("sweep")]
PLAN = """until = 1
method = "rk4"
step = 0.01
keep = ["max(theta2)"]
set = ["l1=2 [m]"]
[grid]
theta1 = ["-1 .. 1 [rad]", 9]
theta2 = ["0 .. 1 [rad]", 11]
m2 = [1, 2]
"""


def test_a_member_that_is_clicked_moves(browser, pkgen, tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(PLAN)
    model = ROOT / "models/double_pendulum.lag"
    done = pkgen("sweep", model, "--plan", tmp_path / "plan.toml", "-o", tmp_path / "s")
    assert done.returncode == 0, done.stderr
    done = pkgen("show", tmp_path / "s", "-o", tmp_path / "s.html")
    if done.returncode and "install" in done.stderr:
        pytest.skip(done.stderr.strip().splitlines()[0])
    assert done.returncode == 0, done.stderr
    page = Page(browser.new_page(viewport={"width": 1280, "height": 800}), tmp_path / "s.html", "")
    page.pause()
    box = page.page.locator(".map-frame").bounding_box()
    assert box["width"] > 200
    # The second column from the left, the third row from below: theta1 = -0.75, theta2 = 0.2.
    page.page.mouse.click(box["x"] + box["width"] * 1.5 / 9, box["y"] + box["height"] * 8.5 / 11)
    page.frames(3)
    said = page.page.locator("#sheet-map").inner_text()
    assert "Member 27: max(theta2) [rad] about" in said, said
    values = page.js("Object.fromEntries(lab.settings.values)")
    assert sorted(values.values()) == pytest.approx([-0.75, 0.2, 1.0])
    page.page.keyboard.press("ArrowRight")
    page.frames(3)
    values = page.js("Object.fromEntries(lab.settings.values)")
    assert sorted(values.values()) == pytest.approx([-0.5, 0.2, 1.0])
    assert page.js("lab.model.byName.get('l1').value") == 2
    assert page.said == []
