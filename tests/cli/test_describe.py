"""`pkgen describe`: the description against what other commands say of the same model."""

from __future__ import annotations

import argparse
import json
import math
import random
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from conftest import ROOT, case, ran, run_pkgen, seeds, written
from pkgen.api.arguments import DEFAULTS
from pkgen.compiler import compile_model
from pkgen.describe.drawing import drawing, drawn
from pkgen.front.read import read
from pkgen.run.library import load
from pkgen.run.simulate import build
from pkgen.scenes import run_settings as asked

MODELS = sorted((ROOT / "models").rglob("*.lag"))
PENDULUM = case("drawn")
DRAWN = """draw rod from O to rod
draw bob rod radius l/10 # the bob
draw arrow rod' at rod scale 0.5 [s]
draw body rot([0, 0, 1], theta) at rod box [0.1, 0.2, 0.3]
draw ground y = -l
view plane xy width 3*l
"""


def described(text: str, folder: Path, *more: str) -> dict:
    path = written(folder, text)
    done = ran("describe", path, "--json", *more)
    return json.loads(done.stdout, parse_constant=pytest.fail)


def test_bounds_defaults_and_starts(tmp_path: Path) -> None:
    found = described(PENDULUM, tmp_path, "--set", "m=3")
    m, length, _, k = found["parameters"]
    assert (m["value"], m["lo"], m["hi"], m["lo_open"]) == (3, 0, None, True)
    bounds = [length[name] for name in ("lo", "hi", "lo_open", "hi_open")]
    assert bounds == [0.5, 3, False, True]
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


class Drawn:
    """The drawing of a model, and its numbers at a state by the very library that a page, a film
    and a run have."""

    def __init__(self, text: str, folder: Path):
        path = written(folder, text)
        compilation = compile_model(read(str(path)), use=drawn(None))
        options = argparse.Namespace(**DEFAULTS, scene=None, start=[], set=[])
        settings = asked.settings(options, compilation)
        library = load(build(compilation, settings, None))
        self.run = library.run(settings, idle=True, bare=True)
        self.drawing = drawing(compilation)

    def at(self, t: float, q: list[float], v: list[float]) -> Callable[[object], object]:
        given = (np.array([t]), np.array([q]), np.array([v]))
        out = self.run.evaluate("outputs", *given)[0]

        def value(entry: object) -> object:
            if isinstance(entry, list):
                return [value(x) for x in entry]
            return out[entry["output"]] if isinstance(entry, dict) else entry

        return value


def test_the_numbers_of_a_drawing_are_those_of_the_motion(tmp_path: Path) -> None:
    """Against the places by hand."""
    theta, rate = 0.7, -1.3
    made = Drawn(PENDULUM + DRAWN, tmp_path)
    value, found = made.at(0, [theta], [rate]), made.drawing
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


# Smooth, kinked, jumping, short, tiny, huge, of time: as the language and as Python have them.
FORMS = [
    ("sin({})*{}", lambda a, b: math.sin(a) * b),
    ("abs({}) - {}", lambda a, b: abs(a) - b),
    ("step({})*{}", lambda a, b: (a >= 0) * b),
    ("max({}, {})", max),
    ("exp(-({})^2/0.01)+{}", lambda a, b: math.exp(-(a**2) / 0.01) + b),
    ("1e-12*{} + 1e9*{}", lambda a, b: 1e-12 * a + 1e9 * b),
    ("tanh({})/(1 + ({})^2)", lambda a, b: math.tanh(a) / (1 + b**2)),
]
LEAVES = ["x", "y", "x'", "y'", "t", "k", "0.3", "P.x", "P.y"]


def _random(rng: random.Random, values: dict[str, float], depth: int) -> tuple[str, float]:
    """An expression, and what it is."""
    if depth == 0:
        name = rng.choice(LEAVES)
        return name, values[name]
    form, function = rng.choice(FORMS)
    (a, x), (b, y) = (_random(rng, values, depth - 1) for _ in range(2))
    return "(" + form.format(a, b) + ")", float(function(x, y))


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_random_drawings_have_the_numbers_that_they_say(seed: int, tmp_path: Path) -> None:
    rng = random.Random(seed)
    t, x, y, u, v = (rng.uniform(-2, 2) for _ in range(5))
    values = {"t": t, "x": x, "y": y, "x'": u, "y'": v, "k": 0.7, "0.3": 0.3}
    values |= {"P.x": x * y, "P.y": x - 0.7 * y}
    text = "model m\nparam k = 0.7\ncoord x, y\nlet P = [x*y, x - k*y, 0]\n"
    text += "kinetic (x'^2 + y'^2)/2\npotential (x^2 + y^2)/2\n"
    expected = []
    for _ in range(12):
        parts = [_random(rng, values, rng.randrange(4)) for _ in range(6)]
        a, b = (", ".join(s for s, _ in parts[k : k + 3]) for k in (0, 3))
        text += f"draw rod from [{a}] to [{b}]\n"
        expected.append([number for _, number in parts])
    made = Drawn(text, tmp_path)
    value = made.at(t, [x, y], [u, v])
    for shape, numbers in zip(made.drawing["shapes"], expected, strict=True):
        assert [*value(shape["from"]), *value(shape["to"])] == pytest.approx(numbers, rel=1e-12)


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
    text = case("describe_m")
    for size, members in ((20, 20), (2000, 500)):
        shapes = described(text, tmp_path, "--size", f"N={size}")["drawing"]["shapes"]
        assert len(shapes[0]["points"]) == members and shapes[0]["kind"] == "curve"
        assert shapes[1]["kind"] == "rod"


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_every_model_is_described_and_has_its_drawing(path: Path) -> None:
    done = ran("describe", path, "--json")
    found = json.loads(done.stdout, parse_constant=pytest.fail)
    assert not found["drawing"]["default"] and found["drawing"]["shapes"]
    again = run_pkgen("describe", path, "--json")
    assert again.stdout == done.stdout


def test_bodies_without_a_drawing_are_bobs_at_their_centres(tmp_path: Path) -> None:
    model = tmp_path / "swing.lag"
    body = "body b mass 1 at [0, 0, -1]\njoint j: ground to b revolute [0, 1, 0]\n"
    model.write_text(f"model swing\ngravity [0, 0, -9.81]\n{body}")
    done = ran("describe", model, "--json")
    found = json.loads(done.stdout)["drawing"]
    assert found["shapes"][0]["kind"] == "bob"
