"""Equilibria along a parameter: their bifurcations where closed forms have them."""

import json
import math
import random
import shlex

import numpy
import pytest
from continued import HOOP, THREE, VAN_DER_POL, found, kinds, loaded

from conftest import ran, seeds
from pkgen import UsageError


@pytest.mark.parametrize("seed", seeds(range(12), 4))
def test_folds_of_random_cubics(seed, tmp_path) -> None:
    """p = a x + c x^3 turns where its derivative is 0."""
    rng = random.Random(seed)
    a, c = -rng.uniform(0.2, 3), rng.uniform(0.2, 3)
    rate = rng.choice(["rate x = p - ({a})*x - {c}*x^3", "rate x = ({a})*x + {c}*x^3 - p"])
    model = f"model cubic\nparam p = 0\nstate x\n{rate.format(a=a, c=c)}\nstart x = 0.1\n"
    place = math.sqrt(-a / (3 * c))
    top = abs(a * place + c * place**3)
    (branch,) = found(model, tmp_path, "p", -2 * top, 2 * top).branches
    assert [point.kind for point in branch.special] == ["fold", "fold"]
    for point in branch.special:
        assert abs(abs(point.value) - top) < 1e-9 * top
        assert abs(abs(point.state["x"]) - place) < 1e-5 * place
    for point in branch.points:
        x, slope = point.state["x"], a + 3 * c * point.state["x"] ** 2
        assert abs(a * x + c * x**3 - point.value) < 1e-9 * top
        if not point.kind:
            assert point.stable == (slope > 0 if "p - " in rate else slope < 0)


@pytest.mark.parametrize("seed", seeds(range(12), 4))
def test_pitchforks_of_random_potentials(seed, tmp_path) -> None:
    """V = (b - p) x^2/2 + c x^4/4 + ... with friction: x = 0, and from p = b on x^2 = (p - b)/c."""
    rng = random.Random(seed)
    b, c, d = rng.uniform(-1, 1), rng.uniform(0.3, 3), rng.uniform(0, 2)
    model = (
        f"model arch\nparam p = 0\ncoord x\nkinetic x'^2/2\npotential ({b} - p)*x^2/2 + {c}*x^4/4\n"
        f"dissipation {d}*x'^2/2\nstart x = 0.1\n"
    )
    made = found(model, tmp_path, "p", -2.0, 2.0)
    assert kinds(made) == ["pitchfork"] and len(made.branches) == 2
    assert abs(made.special[0].value - b) < 1e-9
    (fork,) = [branch for branch in made.branches if branch.begins]
    for point in fork.points:
        assert abs(point.state["x"] ** 2 - max(0.0, point.value - b) / c) < 1e-8
        assert point.stable


def test_a_transcritical_point_and_its_branches(tmp_path) -> None:
    model = "model logistic\nparam p = 0\nstate x\nrate x = p*x - x^2\nstart x = 0.1\n"
    made = found(model, tmp_path, "p", -1.0, 1.5)
    assert kinds(made) == ["branch point"] and abs(made.special[0].value) < 1e-9
    ends = {round(b.points[-1].state["x"] - b.points[0].state["x"], 9) for b in made.branches}
    assert {abs(end) for end in ends} == {0, 2.5}


def test_the_bead_on_the_hoop_leaves_the_bottom(tmp_path) -> None:
    made = found(HOOP, tmp_path, "Omega", 0.0, 8.0)
    (point,) = made.special
    assert point.kind == "pitchfork" and abs(point.value - math.sqrt(9.81)) < 1e-12
    (fork,) = [branch for branch in made.branches if branch.begins]
    for p in fork.points:
        assert abs(math.cos(p.state["theta"]) - 9.81 / p.value**2) < 1e-9 and p.stable
    bottom = next(b for b in made.branches if all(p.state["theta"] == 0 for p in b.points))
    assert [p.stable for p in bottom.points if not p.kind] == [
        p.value < math.sqrt(9.81) for p in bottom.points if not p.kind
    ]
    given = fork.start(3)
    model = loaded(HOOP, tmp_path)
    model.params["Omega"] = given["set"]["Omega"]
    rows = model.run(5, start=given["start"])
    assert numpy.ptp(rows["theta"]) < 1e-9


def test_two_frequencies_meet_at_the_mass_ratio_of_routh(tmp_path) -> None:
    made = found(THREE, tmp_path, "mu", 0.03, 0.05, scene="L4")
    collisions = [point for point in made.special if point.kind == "Krein collision"]
    assert len(collisions) == 2 and len(made.special) == 2
    for point in collisions:
        assert abs(point.value - (1 - math.sqrt(69) / 9) / 2) < 1e-10


def test_a_hopf_bifurcation(tmp_path) -> None:
    (point,) = found(VAN_DER_POL, tmp_path, "mu", -1.0, 0.7).special
    assert point.kind == "hopf" and abs(point.value) < 1e-9
    assert numpy.allclose(sorted(z.imag for z in point.values), [-1, 1], atol=1e-9)


def test_a_top_turns_steadily_along_its_weight(tmp_path) -> None:
    """Cyclic momenta are those of the start: p_phi' = 0 has the same roots by the search."""
    from conftest import ROOT

    path = ROOT / "models/heavy_top.lag"
    made = found(path, tmp_path, "g", 5.0, 20.0)
    points = [branch.points[-1] for branch in made.branches]
    model = loaded(path, tmp_path)
    model.params["g"] = 20.0
    states = [at["state"]["theta"] for at in model.equilibria()]
    assert sorted(math.cos(p.state["theta"]) for p in points) == pytest.approx(
        sorted(map(math.cos, states)), abs=1e-8
    )


def test_the_command_writes_data_and_a_picture(tmp_path) -> None:
    file = tmp_path / "hoop.svg"
    how = ("--free", "Omega=0:8", "-o", file, "--show", "theta")
    record = json.loads(ran("continue", HOOP, *how, "--json").stdout)
    assert record["free"] == "Omega" and record["unit"] == "rad/s"
    special = [p for b in record["branches"] for p in b["points"] if "kind" in p]
    assert [p["set"]["Omega"] for p in special] == pytest.approx([math.sqrt(9.81)])
    assert "pitchfork" in file.read_text()
    text = ran("continue", HOOP, "--free", "Omega=0:8").stdout
    assert "pitchfork at Omega = 3.132091953" in text
    line = next(line for line in text.splitlines() if "--set" in line)
    rest = ran("run", HOOP, *shlex.split(line), "--until", "1", "--every", "1").stdout
    assert [float(x) for x in rest.splitlines()[-1].split(",")[1:3]] == [0, 0]


@pytest.mark.parametrize(
    ("free", "more", "said"),
    [
        (("Omega", 1.0, 1.0), {}, "FROM is to be less than TO"),
        (("omega", 0.0, 1.0), {}, "did you mean 'Omega'"),
        (("energy", -1.0, 1.0), {}, "is of orbits"),
        (("m", -1.0, 1.0), {}, "bounds"),
        (("Omega", 0.0, 8.0), {"orbit": "hopf"}, "no Hopf bifurcation"),
        (("Omega", 0.0, 8.0), {"orbit": "centre"}, "along"),
        (("Omega", 0.0, 8.0), {"section": "x"}, "x"),
        (("Omega", 0.0, 8.0), {"close": "theta"}, "of a return map"),
    ],
)
def test_what_cannot_be_is_said(free, more, said, tmp_path) -> None:
    name, low, high = free
    with pytest.raises(UsageError, match=said):
        found(HOOP, tmp_path, name, low, high, **more)


def test_a_parameter_without_influence_is_refused(tmp_path) -> None:
    model = VAN_DER_POL + "param idle = 1\nobserve twice = 2*idle\n"
    with pytest.raises(UsageError, match="the motion does not depend on it"):
        found(model, tmp_path, "idle", 0.0, 1.0)


def test_no_equilibrium_is_said(tmp_path) -> None:
    falls = "model falls\nparam g = 9.81\ncoord x\nkinetic x'^2/2\npotential g*x\nstart x = 1\n"
    with pytest.raises(UsageError, match="no equilibrium was found"):
        found(falls, tmp_path, "g", 5.0, 10.0)
    with pytest.raises(UsageError, match="nothing rests"):
        found(
            falls.replace("g*x", "g*x^2*cos(t)").replace("model falls", "model shaken"),
            tmp_path,
            "g",
            5.0,
            10.0,
        )
