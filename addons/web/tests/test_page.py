"""The page of `pkgen show` in a browser: it loads, moves, and does what the command line does."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from browser import browser_, packed_, show_  # noqa: F401

from conftest import ROOT, SHOWN, long_but, rows, written

MODELS = SHOWN
PENDULUM = ROOT / "models" / "double_pendulum.lag"
KEPLER = ROOT / "models" / "particles" / "kepler.lag"
TOP = ROOT / "models" / "heavy_top.lag"
CHAIN = ROOT / "models" / "chains" / "fput.lag"
QUICK = {PENDULUM, TOP}
PIXELS = 2.0


@pytest.mark.parametrize("model", long_but(QUICK, MODELS), ids=lambda m: m.stem)
def test_every_model_starts_and_moves_and_nothing_complains(show, model):
    page = show(model)
    page.frames(20)
    assert page.js("lab.runs.error") == ""
    assert page.js("lab.runs.t") > 0
    assert page.js("lab.stage.drawn().length") > 0
    assert page.said == []
    assert [url for url in page.asked if not url.startswith(("file:", "blob:", "data:"))] == []


def test_bodies_move_and_stand_still_when_paused(show):
    page = show(PENDULUM)
    page.pause()
    at = page.drawn("bob")
    page.frames(5)
    assert page.drawn("bob") == at
    page.page.click("#step")
    assert page.drawn("bob") != at


def test_energy_of_gauss_over_a_minute(show):
    page = show(PENDULUM, "m=gauss&m=rk4:0.02")
    page.pause()
    drifts = page.js("""(() => {
        while (lab.runs.t < 60) lab.tick();
        return lab.runs.list.map((run) => Math.max(...run.drifts.columns[0]) / run.sizes[0]);
    })()""")
    assert 0 < drifts[0] < 1e-9
    assert drifts[1] > 1e-6  # rk4 does not keep it


@pytest.mark.parametrize("method", ["gauss", "dop853"])
def test_a_slider_changes_the_motion_as_set_does(show, pkgen, method):
    page = show(PENDULUM, f"m={method}::1e-12")
    page.pause()
    page.js("""(() => {
        const slider = document.getElementById("value-" + lab.model.byName.get("l1").key);
        slider.value = Number(slider.value) + 70;
        slider.dispatchEvent(new Event("input"));
    })()""")
    length = page.js("lab.settings.values.get(lab.model.byName.get('l1').key)")
    assert length > 1.1
    page.js("lab.runs.advance(3)")
    asked = ("--set", f"l1={length!r}", "--until", "3", "--every", "3", "--method", method)
    last = rows(pkgen, PENDULUM, *asked, "--rtol", "1e-12")[-1]
    assert page.js("lab.runs.list[0].t") == pytest.approx(3, abs=1e-12)
    for name, q in zip(
        ("theta1", "theta2"), page.js("Array.from(lab.runs.list[0].q)"), strict=True
    ):
        assert q == pytest.approx(last[name], abs=1e-9)
    unchanged = rows(pkgen, PENDULUM, "--until", "3", "--every", "3", "--method", method)[-1]
    assert abs(unchanged["theta1"] - last["theta1"]) > 1e-3


def test_a_value_out_of_bounds_is_refused_in_words(show):
    page = show(PENDULUM)
    page.pause()
    field = page.page.locator("#value-p0").locator("xpath=..").locator("input.number")
    field.fill("-1")
    field.press("Enter")
    row = page.page.locator(".row", has=page.page.locator("#value-p0"))
    assert "must be above 0" in row.locator(".why").inner_text()
    assert page.js("lab.settings.values.size") == 0


def _dragged(page, bob: int, by: tuple[float, float]) -> tuple[float, float]:
    """How far a bob is from where it was dropped."""
    page.pause()
    stage = page.page.locator("#stage").bounding_box()
    (x, y) = page.drawn("bob")[bob][0]
    mouse = page.page.mouse
    mouse.move(stage["x"] + x, stage["y"] + y)
    mouse.down()
    mouse.move(stage["x"] + x + by[0] / 2, stage["y"] + y + by[1] / 2, steps=3)
    page.frames()
    mouse.move(stage["x"] + x + by[0], stage["y"] + y + by[1], steps=3)
    page.frames()
    mouse.up()
    after = page.drawn("bob")[bob][0]
    return after[0] - x - by[0], after[1] - y - by[1]


@pytest.mark.parametrize(("model", "bob"), [(PENDULUM, 1), (KEPLER, -1)], ids=["rods", "free"])
def test_a_body_stays_where_it_was_dropped(show, model, bob):
    page = show(model)
    off = _dragged(page, bob, (-40, -25))
    assert math.hypot(*off) < PIXELS
    assert page.js("lab.runs.t") == 0
    # The link says so: another page with the same address starts there.
    q = page.js("Array.from(lab.runs.list[0].q)")
    again = show(model, page.js("location.hash").removeprefix("#"))
    again.pause()
    again.page.click("#reset")
    assert again.js("Array.from(lab.runs.list[0].q)") == pytest.approx(q, abs=1e-12)


def test_out_of_reach_a_body_goes_as_near_as_it_can(show):
    page = show(PENDULUM)
    page.pause()
    pivot = page.js("lab.stage.camera.project([0, 0, 0])")
    scale = page.js("lab.stage.camera.scale")
    bob = page.drawn("bob")[0][0]
    # Straight away from the pivot: nearest is where it is.
    out = [(b - p) * 0.4 for b, p in zip(bob, pivot, strict=False)]
    _dragged(page, 0, (out[0], out[1]))
    after = page.drawn("bob")[0][0]
    assert math.dist(after, bob) < PIXELS
    assert math.dist(after, pivot[:2]) == pytest.approx(scale, rel=1e-6)


def test_methods_over_each_other_and_one_that_fails(show):
    page = show(PENDULUM, "m=gauss&m=rk4:0.01&m=euler:0.05&ref=1")
    page.js("lab.setSpeed(3)")
    page.until("lab.runs.t > 20")
    page.pause()
    assert page.js("lab.runs.list.length") == 3
    assert page.page.locator("#legend li").count() == 4
    runs = {shape["run"] for shape in page.js("lab.stage.drawn()") if shape["kind"] == "bob"}
    assert runs >= {-1, 0, 1}
    errors = page.js("lab.runs.list.map((run) => run.drifts.last(1))")
    assert errors[0] < errors[1]


def test_methods_that_do_not_apply_say_why(show):
    page = show(PENDULUM)
    page.page.click("#tab-methods")
    reasons = page.page.locator("#sheet-methods .reasons")
    page.page.locator("#sheet-methods summary").click()
    assert "verlet" in reasons.inner_text()
    assert "separable" in reasons.inner_text()
    offered = page.page.locator("#sheet-methods .card select").first.inner_text()
    assert "verlet" not in offered


def test_swarm_keeps_the_area_of_its_loop(show):
    page = show(ROOT / "models" / "pendulums" / "pendulum.lag", "view=swarm")
    page.until("lab.runs.t > 2")
    page.pause()
    assert page.js("lab.swarm.members") == 10000
    change = page.js("lab.swarm.measure() / lab.swarm.first - 1")
    assert abs(change) < 1e-3
    assert page.js("lab.swarm.drawn[0].members") == 10000


def test_scenes_by_menu(show, pkgen):
    page = show(PENDULUM)
    page.page.select_option("#scene", "slow")
    page.pause()
    page.page.click("#reset")
    assert page.js("Array.from(lab.runs.list[0].q)") == pytest.approx(
        [1e-4, math.sqrt(2) * 1e-4], rel=1e-12
    )
    assert "scene=slow" in page.js("location.hash")


HOSTILE = """
model hostile   # </script><script>document.title = "taken"</script> <!-- & "quotes" 'too'
param constructor = 1 [kg] in (0, inf)      # <img src=x onerror="document.title='taken'">
param valueOf = 2 [m] in (0, inf)     # </template><b>bold</b>
param hasOwnProperty = 9.81 [m/s^2]
coord toString [rad]                      # ${alert(1)} ]]> \\u003c/script\\u003e
let x = [valueOf*sin(toString), -valueOf*cos(toString), 0]
kinetic constructor/2*dot(x', x')
potential constructor*hasOwnProperty*x.y
start toString = 1
draw rod from O to x                      # </script>
draw bob x                                # <u>label</u>
"""


def test_names_and_comments_are_never_markup_or_script(show, tmp_path: Path):
    page = show(written(tmp_path, HOSTILE))
    page.frames(10)
    assert page.said == []
    assert page.js("document.title") == "Hostile – pkgen"
    assert page.js("document.querySelectorAll('main img, main b, main u, main script').length") == 0
    assert page.page.locator("#subtitle").inner_text().startswith("</script>")
    page.js("""(() => {
        const entry = lab.model.byName.get("constructor");
        lab.settings.values.set(entry.key, 3);
        lab.restart();
        lab.changed();
    })()""")
    assert "p.constructor=3" in page.js("location.hash")
    again = show(written(tmp_path, HOSTILE), page.js("location.hash").removeprefix("#"))
    assert again.js("lab.runs.start.params[0]") == 3


@pytest.mark.parametrize(
    "fragment",
    [
        "p.l1=-1&q.theta1=NaN&m=nonsense&m=verlet&speed=1e99&panels=x,y&scene=%3Cscript%3E",
        "m=gauss:0:0&p.m1=Infinity&view=%00&ref=2&p.__proto__=1&q.constructor=2",
        "%E0%A4%A",
    ],
)
def test_an_address_is_anybodys_text(show, fragment):
    page = show(PENDULUM, fragment)
    page.frames(5)
    assert page.said == []
    assert page.js("lab.runs.error") == ""
    assert page.js("lab.settings.values.size") == 0


def test_keys(show):
    page = show(PENDULUM)
    page.page.keyboard.press(" ")
    assert page.js("lab.playing") is False
    t = page.js("lab.runs.t")
    page.page.keyboard.press("ArrowRight")
    assert page.js("lab.runs.t") > t
    page.page.keyboard.press("r")
    assert page.js("lab.runs.t") == 0
    page.page.keyboard.press("+")
    assert page.js("lab.settings.speed") == 1
    page.page.keyboard.press("?")
    assert page.page.locator("#keys").is_visible()


def test_who_wants_no_motion_gets_none(show):
    page = show(PENDULUM, reduced_motion="reduce")
    page.frames(10)
    assert page.js("lab.runs.t") == 0
    assert page.page.locator("#play").get_attribute("aria-label") == "Play"


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1280, 800), (390, 844)], ids=["wide", "narrow"])
def test_everything_fits_and_can_be_read(show, size, scheme):
    page = show(PENDULUM, size=size, color_scheme=scheme)
    page.pause()
    assert page.js("document.documentElement.scrollWidth") <= size[0]
    for tab in ("values", "methods", "swarm", "model"):
        page.page.click(f"#tab-{tab}")
        assert page.js("document.documentElement.scrollWidth") <= size[0]
        assert page.js(CONTRASTS) == []


# Each text that is seen, against the nearest background behind it that is not transparent: what
# stands below 4.5:1 (WCAG 2.2, 1.4.3).
CONTRASTS = """(() => {
    const rgb = (text) => (text.match(/[\\d.]+/g) || []).map(Number);
    const light = ([r, g, b]) => [r, g, b].map((x) => x / 255)
        .map((x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4))
        .reduce((sum, x, k) => sum + x * [0.2126, 0.7152, 0.0722][k], 0);
    const behind = (element) => {
        for (let e = element; e; e = e.parentElement) {
            const c = rgb(getComputedStyle(e).backgroundColor);
            if (c.length === 3 || c[3] > 0.99) return c;
        }
        return [255, 255, 255];
    };
    const low = [];
    for (const e of document.querySelectorAll("body *")) {
        const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
        if (!own || !e.checkVisibility() || e.closest(":disabled, option")) continue;
        const pair = [light(rgb(getComputedStyle(e).color)), light(behind(e))];
        const [a, b] = pair.sort((x, y) => y - x);
        if ((a + 0.05) / (b + 0.05) < 4.5) low.push(e.outerHTML.slice(0, 80));
    }
    return low;
})()"""


def test_each_control_has_a_name(show):
    page = show(PENDULUM)
    nameless = page.js("""[...document.querySelectorAll("button, select, input")].filter((e) =>
        !(e.getAttribute("aria-label") || e.textContent.trim() || (e.labels && e.labels.length)))
        .map((e) => e.outerHTML.slice(0, 90))""")
    assert nameless == []


def test_rods_and_bobs_stand_where_the_model_has_them(show):
    """What is drawn where, in pixels, against the lengths and angles of the start."""
    page = show(PENDULUM)
    page.pause()
    page.page.click("#reset")
    l1, l2 = 1.0, 1.0
    t1, t2 = 1.3, -0.9
    x1, y1 = l1 * math.sin(t1), -l1 * math.cos(t1)
    x2, y2 = x1 + l2 * math.sin(t2), y1 - l2 * math.cos(t2)
    scale = page.js("lab.stage.camera.scale")
    ox, oy, _ = page.js("lab.stage.camera.project([0, 0, 0])")
    bobs = page.drawn("bob")
    for (px, py), (x, y) in zip((bobs[0][0], bobs[1][0]), ((x1, y1), (x2, y2)), strict=True):
        assert px == pytest.approx(ox + scale * x, abs=0.01)
        assert py == pytest.approx(oy - scale * y, abs=0.01)
    width, height = page.js("[lab.stage.width, lab.stage.height]")
    for bob in bobs:
        assert 0 < bob[0][0] < width
        assert 0 < bob[0][1] < height
