"""Through positions where branches of a motion meet: a parallelogram that lies flat stays one, an
antiparallelogram too, by each family of methods; or the run ends and says so."""

import math
import random
import subprocess
import sys

import numpy
import pytest

import pkgen
from conftest import case, seeds

FOUR_BAR = case("four_bar")
METHODS = [
    {"method": "dop853"},
    {"method": "dopri5", "rtol": 1e-6},
    {"method": "gauss"},
    {"method": "gauss", "rtol": 1e-4},
    {"method": "radau"},
    {"method": "rk4", "step": 0.01},
    {"method": "gauss4", "step": 0.02},
    {"method": "rattle", "step": 0.01},
    {"method": "lie_midpoint4", "step": 0.02},
    {"method": "rk4", "step": 0.03},
    {"method": "gauss4", "step": 0.04},
]


def closed(a: float, L: float, r: float) -> tuple[float, float]:
    """b and c of the crossed branch."""
    far = numpy.array([r * math.cos(a) - L, r * math.sin(a)])  # from the second pivot to the joint
    d = math.hypot(*far)
    cosine = (r * r + d * d - L * L) / (2 * r * d)
    candidates = []
    for sign in (1, -1):
        b = math.atan2(far[1], far[0]) + sign * math.acos(cosine)
        x, y = L + r * math.cos(b) - r * math.cos(a), r * math.sin(b) - r * math.sin(a)
        candidates.append((b, math.atan2(y, x)))
    return max(candidates, key=lambda bc: abs(math.remainder(bc[0] - a, 2 * math.pi)))


def drawn(seed: int, crossed: bool) -> tuple[dict, dict]:
    """Parameters, and a start."""
    draw = random.Random(seed)
    of = {x: draw.uniform(0.5, 2) for x in ("m1", "m2", "J")}
    of |= {"L": draw.uniform(1, 1.5), "r": draw.uniform(0.4, 0.8), "g": draw.choice((0, 2))}
    a, va = draw.uniform(0.4, 1.2), draw.uniform(3, 6) * draw.choice((-1, 1))
    if not crossed:
        return of, {"a": a, "b": a, "c": 0, "a'": va, "b'": va, "c'": 0}
    L, r, h = of["L"], of["r"], 1e-6
    b, c = closed(a, L, r)
    (bp, cp), (bm, cm) = (closed(a + x, L, r) for x in (h, -h))
    rows = numpy.array([[-r * math.sin(a), r * math.sin(b), -L * math.sin(c)],
                        [r * math.cos(a), -r * math.cos(b), L * math.cos(c)]])  # fmt: skip
    vb, vc = (float(x) for x in numpy.linalg.solve(rows[:, 1:], -rows[:, 0] * va))
    assert abs(vb / va - (bp - bm) / (2 * h)) < 1e-4 and abs(vc / va - (cp - cm) / (2 * h)) < 1e-4
    return of, {"a": a, "b": b, "c": c, "a'": va, "b'": vb, "c'": vc}


@pytest.fixture(scope="module")
def four_bar(tmp_path_factory):
    path = tmp_path_factory.mktemp("passage") / "four_bar.lag"
    path.write_text(FOUR_BAR)
    return pkgen.load(str(path))


def off_branch(rows, of, crossed: bool) -> float:
    """By the relation each branch has: b = a; tan(a/2) / tan(b/2) constant, of the crossed one."""
    a, b = rows["a"], rows["b"]
    if not crossed:
        return float(numpy.abs(b - a).max())
    k = (of["L"] - of["r"]) / (of["L"] + of["r"])
    one, other = numpy.sin(a / 2) * numpy.cos(b / 2), numpy.cos(a / 2) * numpy.sin(b / 2)
    return float(min(numpy.abs(one - x * other).max() for x in (k, -k, 1 / k, -1 / k)))


@pytest.mark.parametrize("crossed", [False, True])
@pytest.mark.parametrize("seed", seeds([1, 0, 2], 21))
def test_a_branch_is_kept_or_the_run_ends(seed, crossed, four_bar):
    of, start = drawn(seed, crossed)
    arrived = 0
    for name, value in of.items():
        four_bar.params[name] = value
    for options in METHODS:
        try:
            rows = four_bar.run(
                until=6, every=0.05, start=start, record=["a", "b", "energy"], **options
            )
        except pkgen.RunError as ended:
            assert "last valid time" in str(ended), options
            continue
        arrived += 1
        turns = numpy.sin(rows["a"])
        assert (turns[1:] * turns[:-1] < 0).sum() > 2  # it does lie flat on the way
        assert off_branch(rows, of, crossed) < 1e-5, options
    assert arrived >= len(METHODS) - 2


SLIDER = case("slider")


@pytest.fixture(scope="module")
def slider(tmp_path_factory):
    path = tmp_path_factory.mktemp("passage") / "slider.lag"
    path.write_text(SLIDER)
    return pkgen.load(str(path))


@pytest.mark.parametrize("way", ["event", "row", "end"])
@pytest.mark.parametrize("options", [METHODS[i] for i in (0, 2, 5)], ids=str)
def test_a_state_at_the_singular_position_itself(slider, options, way):
    at = 0.466305263674
    where = {"event": {"until": 1, "at": "top"}, "row": {"until": 1, "every": at / 4},
             "end": {"until": at, "every": at}}[way]  # fmt: skip
    record = ["a", "a'", "b'", "x'", "energy"]
    rows = slider.run(**where, record=record, **options)
    k = int(numpy.argmin(abs(rows["t"] - at)))
    rtol = 3e-4 if options["method"] == "rattle" else 1e-6
    # by the energy: (a')^2/2 (1 + 4 M sin(a)^2 + 1/5) + g sin(a)
    rate = math.sqrt((8 * (1.2 + 2.8 * math.sin(0.3) ** 2) + 2 * math.sin(0.3) - 2) / 2)
    assert abs(rows["a"][k] - math.pi / 2) < 10 * rtol
    for name, value in (("a'", rate), ("b'", -rate), ("x'", -2 * rate)):
        assert abs(rows[name][k] / value - 1) < rtol, (name, rows[name][k], value)
    assert abs(rows["energy"][k] / rows["energy"][0] - 1) < rtol


@pytest.mark.parametrize("method", ["dop853", "gauss"])
def test_what_is_lost_at_the_singular_position_is_nan_and_told(slider, tmp_path, method):
    (tmp_path / "slider.lag").write_text(SLIDER.replace("event", "observe E = g*sin(a)\nevent"))
    show = ["--record", "a,E,a'',lambda_up", "--at", "top", "--method", method]
    done = subprocess.run([sys.executable, "-m", "pkgen", "run", str(tmp_path / "slider.lag"),
                           "--until", "0.5", *show], capture_output=True, text=True)  # fmt: skip
    assert done.returncode == 0
    assert "warning: a'' is lost to rounding, and nan, in 1 of 1 rows" in done.stderr
    cells = [float(x) for x in done.stdout.splitlines()[1].split(",")]
    assert abs(cells[2] - 2) < 1e-6 and all(math.isnan(x) for x in cells[3:])
    rows = slider.run(until=1, every=0.05, record=["a''", "lambda_up"], method=method)
    assert numpy.isfinite(rows["a''"]).all() and numpy.isfinite(rows["lambda_up"]).all()


@pytest.mark.parametrize("options", [METHODS[i] for i in (0, 2, 5)], ids=str)
def test_a_stop_at_the_singular_position_keeps_its_state(tmp_path, options):
    (tmp_path / "stop.lag").write_text(SLIDER.replace("rising", "rising stop"))
    rows = pkgen.load(str(tmp_path / "stop.lag")).run(until=1, every=0.1, **options)
    assert abs(rows["a"][-1] - math.pi / 2) < 1e-9
    assert abs(rows["a'"][-1] / -rows["b'"][-1] - 1) < 1e-6
    assert abs(rows["energy"][-1] / rows["energy"][0] - 1) < 1e-6
