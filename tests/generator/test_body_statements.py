"""`body` and `joint`: trees against Newton's and Euler's equations, each kind of joint beside the
same model by hand, names, places."""

import random
import re

import numpy as np
import pytest
from random_states import state_of
from trees_of_bodies import FREEDOMS, KINDS, Motion, random_tree, written

from conftest import case, seeds
from pkgen.compiler import compile_model
from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.derive.derive import derive
from pkgen.source import ModelError, Source


def model_of(text: str):
    return check_text(Source("tree.lag", text))[0]


def warnings_of(text: str):
    return check_text(Source("tree.lag", text))[1]


def compared(links, text: str, draw: random.Random, kernels=None) -> None:
    model = model_of(text)
    e = derive(model, kernels)
    n = sum(FREEDOMS[b.kind] for b in links)
    assert len(model.coordinates) == n
    for _ in range(2):
        symbols, values, rates = state_of(model, draw)
        motion = Motion(links, values, rates)
        order = motion.order(model)
        found = np.array(evaluate(e.graph, e.acceleration[:n], symbols))[order]
        wanted = motion.accelerations()
        assert abs(found - wanted).max() < 1e-10 * max(1, abs(wanted).max())
        assert n <= 2 or abs(wanted).max() > 1e-3
        (energy,) = evaluate(e.graph, [e.energy], symbols)
        assert energy == pytest.approx(motion.energy(), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("seed", seeds(range(3), 57))
def test_random_trees_move_as_newton_and_euler_say(seed):
    draw = random.Random(seed)
    kinds = [draw.choice(KINDS) for _ in range(draw.randint(1, 5))]
    if not any(FREEDOMS[k] for k in kinds):
        kinds.append("revolute")
    links = random_tree(draw, kinds)
    compared(links, written(links, draw), draw)


LONG = [("free", "revolute", 17), ("free", "revolute", 30), ("spherical", "spherical", 12)]


@pytest.mark.parametrize("chain", LONG)
def test_long_chains_are_solved_along_their_tree(chain):
    """More coordinates than M can be eliminated for in straight-line code."""
    first, others, count = chain
    draw = random.Random(count)
    kinds = [first] + [others] * (count - 1)
    links = random_tree(draw, kinds)
    for k, link in enumerate(links):
        link.parent = k - 1
    compared(links, written(links, draw), draw, frozenset({"acceleration"}))


@pytest.mark.parametrize("kind", [k for k in KINDS if FREEDOMS[k]])
@pytest.mark.parametrize("chained", [False, True])
def test_each_kind_alone_and_on_a_turning_body(kind, chained):
    draw = random.Random(kind + str(chained))
    links = random_tree(draw, ["revolute", kind] if chained else [kind])
    links[-1].parent = len(links) - 2
    compared(links, written(links, draw), draw)


HAND = {
    "revolute": (
        "body b mass 2 [kg] inertia [0.1, 0.2, 0.3] at [0, 0, -0.5]\n"
        "joint a: ground to b revolute [0, 1, 0]",
        "coord a [rad]\nkinetic (2 [kg])/2*(0.25 [m^2])*a'^2 + (0.2 [kg*m^2])/2*a'^2\n"
        "potential -(2 [kg])*(9.81 [m/s^2])*(0.5 [m])*cos(a)",
    ),
    "prismatic": (
        "body b mass 2 [kg]\njoint a: ground to b prismatic [0, 3, 4]",
        "coord a [m]\nkinetic (2 [kg])/2*a'^2\npotential (2 [kg])*(9.81 [m/s^2])*0.8*a",
    ),
    "planar": (
        "body b mass 2 [kg] inertia [1, 1, 0.3] at [0.5, 0, 0]\n"
        "joint a: ground to b planar [0, 0, 1]",
        "coord a_1, a_2 [m], a [rad]\n"
        "let x = a_1 + (0.5 [m])*cos(a)\nlet y = a_2 + (0.5 [m])*sin(a)\n"
        "kinetic (2 [kg])/2*(x'^2 + y'^2) + (0.3 [kg*m^2])/2*a'^2",
    ),
    "spherical": (
        "body b mass 2 [kg] inertia [0.1, 0.2, 0.3] at [0, 0, 0.5]\njoint a: ground to b spherical",
        "rotation a\nlet w = omega(a)\nkinetic (2 [kg])/2*(0.25 [m^2])*(w.x^2 + w.y^2)\n"
        "kinetic (0.1 [kg*m^2])/2*w.x^2 + (0.2 [kg*m^2])/2*w.y^2 + (0.3 [kg*m^2])/2*w.z^2\n"
        "potential (2 [kg])*(9.81 [m/s^2])*(a*[0, 0, 0.5 [m]]).z",
    ),
    "free": (
        "body b mass 2 [kg] inertia [0.1, 0.2, 0.3]\njoint a: ground to b free",
        "coord a_x, a_y, a_z [m]\nrotation a\nlet w = omega(a)\n"
        "kinetic (2 [kg])/2*(a_x'^2 + a_y'^2 + a_z'^2)\npotential (2 [kg])*(9.81 [m/s^2])*a_z\n"
        "kinetic (0.1 [kg*m^2])/2*w.x^2 + (0.2 [kg*m^2])/2*w.y^2 + (0.3 [kg*m^2])/2*w.z^2",
    ),
    "driven": (
        "param W = 2 [rad/s]\nbody b mass 2 [kg] at [0, 0, -0.5]\n"
        "joint a: ground to b revolute [0, 1, 0] at [(0.3 [m])*sin(W*t), 0, (0.1 [m/s^2])*t^2]",
        "param W = 2 [rad/s]\ncoord a [rad]\nlet x = (0.3 [m])*sin(W*t) - (0.5 [m])*sin(a)\n"
        "let z = (0.1 [m/s^2])*t^2 - (0.5 [m])*cos(a)\n"
        "kinetic (2 [kg])/2*(x'^2 + z'^2)\npotential (2 [kg])*(9.81 [m/s^2])*z",
    ),
}


@pytest.mark.parametrize("case", HAND)
def test_the_same_by_hand(case):
    """Each alone, with units, and by the names that docs/bodies.md gives the coordinates."""
    bodies, hand = HAND[case]
    gravity = "gravity [0, 0, -9.81 [m/s^2]]\n" if case != "planar" else ""
    models = [model_of(f"model m\n{text}\n") for text in (gravity + bodies, hand)]
    assert [c.name for c in models[0].coordinates] == [c.name for c in models[1].coordinates]
    assert [c.unit for c in models[0].coordinates] == [c.unit for c in models[1].coordinates]
    symbols, _, _ = state_of(models[0], random.Random(case))
    if case == "driven":
        symbols[Symbol(Kind.PARAMETER, 0)] = 2.0
    found = []
    for model in models:
        e = derive(model)
        n = len(model.coordinates)
        found.append(evaluate(e.graph, [*e.acceleration[:n], e.energy], symbols))
    assert found[0] == pytest.approx(found[1], rel=1e-12, abs=1e-12)
    assert max(map(abs, found[0])) > 0.1


OWN = case("own")


def test_the_words_are_names_elsewhere():
    model = model_of(OWN)
    assert [c.name for c in model.coordinates] == ["joint", "body", "prismatic"]
    assert not warnings_of(OWN)


def test_the_words_are_names_beside_bodies_too():
    """A value may be a name that is a word, where a value is due."""
    text = OWN.replace("coord body,", "coord") + (
        "body body mass mass inertia [inertia, inertia, inertia] at [0, 0, turned]\n"
        "joint spherical: ground to body spherical at [0, 0, ground]\ngravity [0, 0, -gravity]\n"
    ).replace("body body", "body other").replace("to body", "to other")
    text = (
        text.replace("body'^2 + ", "").replace("*body +", "*prismatic +").replace("[body,", "[0,")
    )
    model = model_of(text.replace("let com = ", "let place = ").replace("com", "place"))
    assert [r.name for r in model.rotations] == ["spherical"]


def test_places_are_of_use_everywhere():
    text = case("used")
    model = model_of(text)
    assert len(model.drawings) == 4 and len(model.events) == 1
    assert [name for name, _ in model.drawings[0].parts] == ["turn", "at", "sizes"]


def test_the_order_of_statements_is_free():
    text = (
        "model m\njoint b: one to two revolute [0, 1, 0]\nbody two mass 1\n"
        "joint a: ground to one revolute [0, 1, 0]\nbody one mass 1\n"
    )
    assert [c.name for c in model_of(text).coordinates] == ["b", "a"]


@pytest.mark.parametrize("n, most", [(6, 1732), (12, 4826)])
def test_an_arm_takes_no_more_than_by_places(n, most):
    """Operations of an acceleration; the bounds are those of the same arm by hand, whose bodies
    have one moment of inertia each (docs/dev/architecture.md)."""
    axes = ["[0,0,1]", "[0,1,0]", "[0,1,0]", "[1,0,0]", "[0,1,0]", "[1,0,0]", "[0,1,0]"]
    text = "model arm\nparam g = 9.81 [m/s^2]\ngravity [0, 0, -g]\n"
    for i in range(1, n + 1):
        text += f"param m{i} = 1 [kg]\nparam I{i} = 0.02 [kg*m^2]\n"
        text += f"body b{i} mass m{i} inertia [I{i}, 2*I{i}, 3*I{i}] at [0, 0, 0.15]\n"
        parent, at = (f"b{i - 1}", 0.3) if i > 1 else ("ground", 0)
        text += f"joint q{i}: {parent} to b{i} revolute {axes[(i - 1) % 7]} at [0, 0, {at}]\n"
    out = compile_model(Source("arm.lag", text), kernels=frozenset(["acceleration"]))
    header = out.files["arm.h"]
    operations = int(re.search(r"acceleration +([0-9]+) operations", header)[1])
    assert most // 3 < operations <= most


RIGHT = case("body_statements_m")
MISTAKES = {  # by the line that is wrong what it says, and what is said of it
    ("body a mass", "body aa mass"): "unknown body 'a'",
    ("to a revolute", "to a revolut"): "there is no joint 'revolut'",
    ("to b revolute", "to bb revolute"): "unknown body 'bb'",
    ("body a mass 1 [kg]", "body a mass 1 [m]"): "unit mismatch: 1 [m] is a length",
    ("body a mass 1 [kg]", "body a"): "the body 'a' has no mass",
    ("coord phi", "cord phi"): "the joint 'two' has no part 'cord'",
    ("a to b revolute [0, 1, 0]", "a to b revolute"): "a revolute joint has an axis",
    ("b revolute [0, 1, 0]", "b spherical [0, 1, 0]"): "a spherical joint has no axis",
    ("b revolute [0, 1, 0]", "b planar [0, 1, 0]"): "a planar joint has 3 coordinates",
    ("ground to a", "to a"): "'[0, 1, 0]' has no place here",
    ("ground to a", "grond to a"): "unknown body 'grond'",
    ("ground to a", "a to ground"): "the ground hangs on no joint",
    ("joint two: a", "joint two: b"): "the joints two go round in a circle",
    ("joint two:", "joint one:"): "'one' is declared already",
}


@pytest.mark.parametrize("old, new", MISTAKES)
def test_one_mistake_is_one_message(old, new):
    """Whatever reads the places and the coordinates of what is wrong."""
    model_of(RIGHT)
    with pytest.raises(ModelError) as error:
        model_of(RIGHT.replace(old, new))
    (only,) = error.value.diagnostics
    assert only.message.startswith(MISTAKES[old, new])


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_bodies_that_are_fixed_to_each_other(seed):
    """Two in a row, on what turns, and something that turns on them."""
    draw = random.Random(seed)
    links = random_tree(draw, ["revolute", "fixed", "fixed", "revolute"])
    for k, link in enumerate(links):
        link.parent = k - 1
        link.turned = link.turned or [(np.array([0.3, 1.0, -0.2]), 0.7)]
    compared(links, written(links, draw), draw, frozenset({"acceleration"}))


def test_what_is_fixed_costs_little():
    """Of six links, and a seventh body, turned, on the last: by its own velocities 650 more."""
    text = "model arm\ngravity [0, 0, -9.81]\n"
    for i in range(6):
        text += f"body b{i} mass 1 inertia [0.02, 0.03, 0.04] at [0, 0, 0.15]\n"
        parent, at = (f"b{i - 1}", 0.3) if i else ("ground", 0)
        axis = ["[0, 0, 1]", "[0, 1, 0]", "[0, 1, 0]", "[1, 0, 0]"][i % 4]
        text += f"joint q{i}: {parent} to b{i} revolute {axis} at [0, 0, {at}]\n"
    flange = (
        "body f mass 1 inertia [0.1, 0.2, 0.3] at [0, 0, 0.02]\n"
        "joint on: b5 to f fixed at [0, 0, 0.1] turned rot([1, 2, 0], 0.3)\n"
    )
    counts = []
    for model in (text, text + flange):
        out = compile_model(Source("arm.lag", model), kernels=frozenset(["acceleration"]))
        counts.append(int(re.search(r"acceleration +([0-9]+) op", out.files["arm.h"])[1]))
    assert 0 < counts[1] - counts[0] < 350
