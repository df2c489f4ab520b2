"""`pkgen describe`: the description against what other commands say of the same model."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest
from conftest import ROOT, run_pkgen

MODELS = sorted((ROOT / "models").rglob("*.lag"))
PENDULUM = """
model drawn
param m = 1 [kg] in (0, inf)
param l = 2 [m] in [0.5, 3)
param g = 9.81 [m/s^2]
param k = m*g/l
coord theta [rad]
let rod = [l*sin(theta), -l*cos(theta), 0]
kinetic m/2*dot(rod', rod')
potential m*g*rod.y
conserve H = m/2*l^2*theta'^2 - m*g*l*cos(theta)
event top: theta - 3 rising
start theta = 0.5, theta' = k/(4.905 [kg/s])
"""
DRAWN = """draw rod from O to rod
draw bob rod radius l/10 # the bob
draw arrow rod' at rod scale 0.5 [s]
draw body rot([0, 0, 1], theta) at rod box [0.1, 0.2, 0.3]
draw ground y = -l
view plane xy width 3*l
"""


def described(text: str, folder: Path, *more: str) -> dict:
    path = folder / "m.lag"
    path.write_text(text)
    done = run_pkgen("describe", path, "--json", *more)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout, parse_constant=pytest.fail)


def test_bounds_defaults_and_starts(tmp_path: Path) -> None:
    found = described(PENDULUM, tmp_path, "--set", "m=3")
    m, length, _, k = found["parameters"]
    assert (m["value"], m["lo"], m["hi"], m["lo_open"]) == (3, 0, None, True)
    assert (length["lo"], length["hi"], length["lo_open"], length["hi_open"]) == (
        0.5,
        3,
        False,
        True,
    )
    assert k["follows"] and k["value"] == pytest.approx(3 * 9.81 / 2, rel=1e-15)
    (theta,) = found["coordinates"]
    assert theta["q"] == 0.5 and theta["v"] == pytest.approx(3.0) and theta["periodic"]
    assert [c["kind"] for c in found["constants"]] == ["energy", "claim"]
    assert found["events"][0]["direction"] == 1


def test_methods_that_do_not_apply_say_why(tmp_path: Path) -> None:
    methods = {m["name"]: m for m in described(PENDULUM, tmp_path)["methods"]}
    assert methods["gauss"]["default"] and methods["gauss"]["applies"]
    assert methods["verlet"]["applies"]
    bent = PENDULUM.replace("kinetic m/2*", "kinetic (1 + theta^2)*m/2*").replace(
        "conserve H", "observe H"
    )
    methods = {m["name"]: m for m in described(bent, tmp_path)["methods"]}
    assert not methods["verlet"]["applies"] and "separable" in methods["verlet"]["why"]


def test_the_numbers_of_a_drawing_are_those_of_the_motion(tmp_path: Path) -> None:
    """By the hidden outputs of the very library, against the places by hand."""
    import argparse

    import numpy as np
    from pkgen.api.model import DEFAULTS
    from pkgen.compiler import compile_model
    from pkgen.describe.drawing import drawing, drawn
    from pkgen.front.read import read
    from pkgen.run.library import load
    from pkgen.run.simulate import build
    from pkgen.scenes import asked

    path = tmp_path / "m.lag"
    path.write_text(PENDULUM + DRAWN)
    compilation = compile_model(read(str(path)), use=drawn(None))
    options = argparse.Namespace(**DEFAULTS, scene=None, start=[], set=[])
    settings = asked.settings(options, compilation)
    run = load(build(compilation, settings, None)).run(settings, idle=True, bare=True)
    theta, rate = 0.7, -1.3
    out = run.evaluate("outputs", np.zeros(1), np.array([[theta]]), np.array([[rate]]))[0]

    def value(entry):
        if isinstance(entry, list):
            return [value(x) for x in entry]
        return out[entry["output"]] if isinstance(entry, dict) else entry

    found = drawing(compilation)
    rod, bob, arrow, body, ground = found["shapes"]
    at = [2 * math.sin(theta), -2 * math.cos(theta), 0]
    assert value(rod["to"]) == pytest.approx(at) and value(rod["from"]) == [0, 0, 0]
    assert value(bob["radius"]) == pytest.approx(0.2) and bob["label"] == "the bob"
    speed = [2 * rate * math.cos(theta), 2 * rate * math.sin(theta), 0]
    assert value(arrow["vector"]) == pytest.approx([x / 2 for x in speed])
    c, s = math.cos(theta), math.sin(theta)
    assert value(body["turn"]) == pytest.approx([c, s, 0, -s, c, 0, 0, 0, 1])
    assert value(ground["at"]) == -2 and ground["axis"] == "y"
    view = found["view"]
    assert view["axes"] == ["x", "y"] and value(view["width"]) == 6 and not found["default"]


@pytest.mark.parametrize(
    ("model", "kinds", "view"),
    [
        ("kinetic (x'^2 + y'^2)/2\npotential x^2\n", ["bob"], "plane"),
        (
            "kinetic (x'^2 + y'^2)/2\npotential x^2\nlet P = [x, y, x*y]\nobserve s = P\n",
            ["bob", "bob"],
            "space",
        ),
    ],
)
def test_without_draw_places_are_bobs(model: str, kinds: list, view: str, tmp_path: Path) -> None:
    found = described(f"model m\ncoord x, y\n{model}", tmp_path)["drawing"]
    assert found["default"] and found["view"]["kind"] == view
    assert {shape["kind"] for shape in found["shapes"]} == set(kinds)


def test_without_places_coordinates_are_curves(tmp_path: Path) -> None:
    found = described("model m\ncoord a, b\nkinetic (a'^2 + b'^2)/2\npotential a*b\n", tmp_path)
    assert found["drawing"]["shapes"] == [{"kind": "graph", "columns": [0, 1]}]


WORDS = ("draw", "view", "rod", "ground", "top", "radius", "bob", "to", "plane", "space", "width")


@pytest.mark.parametrize("word", WORDS)
def test_words_of_drawings_are_names_elsewhere(word: str, tmp_path: Path) -> None:
    other = "lasting" if word != "lasting" else "turns"
    text = f"""model m
param {word} = 2
coord {other}
let P = [{word}*{other}, ({word}
), 0]
kinetic {other}'^2/2
potential {word}*{other}^2
draw bob P radius {word}
draw rod from O to P
draw rod from [{word}, 0, 0] to [{other}, {word}, 0]
start {other} = {word}
"""
    found = described(text, tmp_path)
    assert [shape["kind"] for shape in found["drawing"]["shapes"]] == ["bob", "rod", "rod"]
    plain = text.split("draw")[0] if word != "draw" else text[: text.index("draw bob")]
    (tmp_path / "plain.lag").write_text(plain)
    assert run_pkgen("check", tmp_path / "plain.lag").returncode == 0


def test_the_c_is_the_same_with_and_without_a_drawing(tmp_path: Path) -> None:
    texts = []
    for name, text in (("a", PENDULUM), ("b", PENDULUM + DRAWN)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "m.lag").write_text(text)
        assert run_pkgen(tmp_path / name / "m.lag", "-o", tmp_path / name).returncode == 0
        texts.append((tmp_path / name / "drawn.c").read_text().partition("#include")[2])
        texts[-1] = re.sub(r"[0-9a-f]{64}", "", texts[-1])  # of the source
    assert texts[0] == texts[1]


def test_a_family_is_drawn_member_by_member_and_as_a_curve(tmp_path: Path) -> None:
    text = """model m
size N = 20
coord q[1..N]
fixed q[0] = 0, q[N+1] = 0
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum((q[i+1] - q[i])^2/2, i = 0..N)
start q[i = 1..N] = i/10
draw curve [i, q[i], 0], i = 1..N
draw rod from [i, q[i], 0] to [i + 1, q[i+1], 0], i = 1..N-1
"""
    for size, members in ((20, 20), (2000, 500)):
        shapes = described(text, tmp_path, "--size", f"N={size}")["drawing"]["shapes"]
        assert len(shapes[0]["points"]) == members and shapes[0]["kind"] == "curve"
        assert shapes[1]["kind"] == "rod"


@pytest.mark.long
@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_every_model_is_described_and_has_its_drawing(path: Path) -> None:
    done = run_pkgen("describe", path, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout, parse_constant=pytest.fail)
    assert not found["drawing"]["default"] and found["drawing"]["shapes"]
    again = run_pkgen("describe", path, "--json")
    assert again.stdout == done.stdout
