"""What the page says in words and numbers beside the motion: titles, read-outs, ends, charts."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import browser_, packed_, show_  # noqa: F401

from conftest import ROOT, table, written

PENDULUM = ROOT / "models" / "pendulums" / "pendulum.lag"
CHAIN = ROOT / "models" / "chains" / "fput.lag"
TOP = """model small_top      # a top
param k = 3 [N*m]
param half = k/2
coord phi, theta [rad]   # precession, nutation
coord u, w [m]           # off the axis, far out
kinetic (1 [kg*m^2])*(phi'^2 + theta'^2)/2 + (1 [kg])*(u'^2 + w'^2)/2
potential k*theta^2/2 + half*phi^2
start theta = k/(2 [N*m]), phi' = 0.4 [1/s]
"""


@pytest.mark.parametrize(
    ("comment", "title", "words"),
    [
        ("Huygens' clocks", "Huygens' clocks", ""),
        ("two clocks on a beam", "Small top", "two clocks on a beam"),
        ("They agree.", "Small top", "They agree."),
    ],
)
def test_the_heading_is_the_title_of_the_model(show, tmp_path: Path, comment, title, words):
    page = show(written(tmp_path, TOP.replace("a top", comment)))
    assert page.js("document.title") == f"{title} – pkgen"
    assert page.page.inner_text("#title") == title
    assert page.page.inner_text("#subtitle") == words


def test_what_follows_is_read_until_it_is_set_free(show, tmp_path: Path):
    page = show(written(tmp_path, TOP))
    page.pause()
    half = page.page.locator(".row", has=page.page.locator("#value-p1"))
    theta = page.page.locator(".row", has=page.page.locator("#value-q1"))
    assert half.locator("input:visible").count() == 0
    assert half.locator("output").inner_text() == "= 1.5 J"
    assert theta.locator("output").inner_text() == "= 1.5 rad = 85.94°"
    page.page.locator("#value-p0").fill("1000")  # k to the end of its slider
    assert theta.locator("output").inner_text() != "= 1.5 rad = 85.94°"
    half.get_by_role("button", name="Set half by itself").click()
    assert half.locator("input:visible").count() == 2
    half.get_by_role("button", name="half as the model says").click()
    assert half.locator("input:visible").count() == 0


def test_sliders_show_their_ends_and_degrees_and_captions_once(show, tmp_path: Path):
    page = show(written(tmp_path, TOP))
    page.pause()
    rate = page.page.locator(".row", has=page.page.locator("#value-v0"))
    assert rate.locator(".ends").inner_text().split("\n") == ["−2 rad/s", "2 rad/s"]
    assert rate.locator(".degrees").inner_text() == "22.92°/s"
    words = page.page.locator("#sheet-values .words:visible").all_inner_texts()
    assert [w for w in words if w] == ["precession", "nutation", "u, w: off the axis, far out"]
    assert (
        page.js("""[...document.querySelectorAll("#sheet-values *")].filter((e) =>
        e.checkVisibility() && e.scrollWidth > e.clientWidth + 1 && e.clientWidth)
        .map((e) => e.className)""")
        == []
    )


def _ends(page) -> list[float]:
    """The last time on each chart over time, and that of the clock."""
    return page.js("""lab.panels.places.filter((p) => ["drift", "time", "modes"].includes(p.name))
        .map((p) => Math.max(...p.panel.chart.lines.map((l) => l.x[l.x.length - 1])))
        .concat(lab.runs.t)""")


def test_charts_end_at_the_time_of_the_clock(show):
    page = show(CHAIN)
    assert page.js("lab.panels.places.map((p) => p.name)") == ["drift", "modes", "time"]
    page.frames(40)
    page.pause()
    page.frames(3)
    ends = _ends(page)
    assert ends[-1] > 0 and len(set(ends)) == 1
    page.page.click("#step")
    page.frames(3)
    after = _ends(page)
    assert len(set(after)) == 1 and after[0] > ends[0]


def test_a_recurrence_is_seen_within_a_minute(show):
    page = show(CHAIN, "paused")
    recurrence = page.js("lab.model.sceneNamed.get('recurrence').until")
    assert 10 < recurrence / page.js("lab.speed()") < 60
    assert page.js("lab.speed() / lab.natural") < 5  # swings a second: they are still seen


def _marks(page) -> list[dict]:
    page.pause()
    page.frames(3)
    return page.js("lab.stage.marks.placed")


@pytest.mark.parametrize("size", [(1280, 800), (390, 844)], ids=["wide", "narrow"])
def test_what_is_drawn_says_what_it_is(show, size):
    chain = _marks(show(CHAIN, size=size))
    said = " ".join(m["text"] for m in chain)
    assert "Displacements are drawn 4 times" in said
    numbers = sorted((m["x"], m["text"]) for m in chain if m["text"] in "12345")
    assert [text for _, text in numbers] == [
        "1",
        "2",
        "3",
        "4",
        "5",
    ]  # of the modes, below the bars
    well = show(ROOT / "models" / "particles" / "henon_heiles.lag", size=size)
    found = _marks(well)
    texts = {m["text"] for m in found}
    for (x, y), text in well.js("""lab.stage.levels.marks.map((m) => [m.at, m.text])"""):
        if text in texts:
            value = x * x / 2 + y * y / 2 + x * x * y - y**3 / 3
            assert float(text.replace("−", "-")) == pytest.approx(value, rel=0.15, abs=0.01)
    assert len(texts & set(well.js("lab.stage.levels.marks.map((m) => m.text)"))) >= 2


@pytest.mark.long
@pytest.mark.parametrize("model", ["bodies/free_body", "particles/kepler", "chains/fput"])
def test_words_over_a_scene_keep_apart(show, model):
    page = show(ROOT / "models" / f"{model}.lag", "m=gauss&m=dop853")
    found = _marks(page)
    width, height = page.js("[lab.stage.width, lab.stage.height]")
    for k, a in enumerate(found):
        assert a["x"] >= 0 and a["x"] + a["width"] <= width and 0 < a["y"] < height
        for b in found[:k]:
            apart = a["x"] + a["width"] <= b["x"] or b["x"] + b["width"] <= a["x"]
            assert apart or abs(a["y"] - b["y"]) >= 14, (a, b)


def test_bodies_and_arrows_have_names_and_space_a_scale(show):
    words = {m["text"] for m in _marks(show(ROOT / "models" / "particles" / "kepler.lag"))}
    assert {"sun", "planet", "velocity"} <= words
    space = show(ROOT / "models" / "bodies" / "free_body.lag")
    words = {m["text"] for m in _marks(space)}
    assert {"angular momentum", "angular velocity"} <= words
    assert any(word.endswith(" at the middle") for word in words)
    ink = space.js("""(() => {
        const { camera } = lab.stage;
        const p = camera.project(camera.target);
        const { right } = camera.frame();
        const q = camera.project(camera.target.map((x, k) => x + right[k]));
        return [q[0] - p[0], camera.focal() / camera.distance];
    })()""")
    assert ink[0] == pytest.approx(ink[1], rel=1e-9)


def test_a_scene_plays_its_own_swarm(show, pkgen):
    page = show(PENDULUM, "paused&scene=all_amplitudes")
    assert page.js("lab.settings.view") == "swarm"
    assert page.js("lab.swarm.members") == 1000
    assert page.page.locator("#cloud").is_visible()
    page.js("lab.runs.advance(1); lab.now = 1; lab.dirty = true")
    page.until("lab.swarm.t === 1")
    page.frames(2)
    points = page.js("Array.from(lab.swarm.swarm.points(0, 1).points)")
    last = {}
    asked = ("--scene", "all_amplitudes", "--until", "1", "--every", "1")
    head, table_ = table(pkgen("run", PENDULUM, *asked).stdout)
    for row in table_:
        named = dict(zip(head, row, strict=True))
        if named["t"] == 1:
            last[int(named[head[0]])] = (named["theta"], named["theta'"])
    assert len(last) == 1000
    for k, (x, v) in last.items():
        assert points[2 * k - 2 : 2 * k] == pytest.approx((x, v), abs=1e-5)
    # The scene's end is the swarm's too; an address says which view is meant.
    page.page.click("#view-scene")
    assert "view=scene" in page.js("location.hash")
    page.page.select_option("#scene", "small")
    assert page.js("lab.settings.view") == "scene"


def test_the_points_of_a_swarm_are_read_where_they_are(show):
    page = show(PENDULUM, "paused&view=swarm")
    page.frames(3)
    found = page.js("""(() => {
        const { swarm } = lab.swarm;
        let copies = 0;
        const states = swarm.states.bind(swarm);
        swarm.states = (...given) => { copies++; return states(...given); };
        lab.tick();
        lab.swarm.advance(lab.now);
        lab.swarm.draw(lab.stage.width, lab.stage.height);
        const { box, points } = swarm.points(0, 1);
        const all = states();
        let off = 0;
        for (let k = 0; k < swarm.members; k++)
            off = Math.max(off, Math.abs(points[2 * k] - all[2 * k]),
                Math.abs(points[2 * k + 1] - all[2 * k + 1]));
        return { copies, off, own: points.buffer === lab.engine.c.memory.buffer,
            box: Array.from(box), low: Math.min(...points.filter((_, k) => k % 2 === 0)),
            gl: Boolean(lab.swarm.cloud.gl) };
    })()""")
    assert found["copies"] == 0 and found["own"] and found["off"] < 1e-6
    assert found["box"][0] == found["low"]
    # WebGL has drawn them where the axes say.
    at = page.js("lab.swarm.drawn[0].points[0]")
    ink = page.js("""(() => {
        lab.swarm.draw(lab.stage.width, lab.stage.height);
        const { gl, canvas } = lab.swarm.cloud;
        const all = new Uint8Array(4 * canvas.width * canvas.height);
        gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, all);
        let [x, n] = [0, 0];
        for (let k = 0; k < all.length / 4; k++)
            if (all[4 * k + 3]) { x = Math.max(x, k % canvas.width); n++; }
        return [x, n];
    })()""")
    assert ink[1] > 1000 and ink[0] == pytest.approx(at[0], abs=25)


def test_what_is_not_the_energy_is_not_called_so(show):
    """On a hoop that a motor turns h = q' dL/dq' - L is constant, T + V is not."""
    page = show(ROOT / "models" / "bead_on_hoop.lag")
    assert "Jacobi integral, not T + V" in page.js("document.body.textContent")
    assert page.js("lab.model.description.constants[0].name") == "energy"


@pytest.mark.long
def test_what_shakes_fast_is_shown_at_half_the_real_time(show):
    page = show(ROOT / "models" / "constrained" / "rattleback.lag")
    assert page.js("lab.speed()") >= 0.5
