"""Rows that follow from others: random mechanisms with and without them move alike, by each family
of methods; rows that cease to follow, or contradict, end a run or are refused."""

import random

import numpy
import pytest

import pkgen
from conftest import case, seeds
from pkgen.source import ModelError


def rods(draw: random.Random) -> tuple[str, list[str], list[str]]:
    """Bobs on rods one after the other, in a plane, some of them with a spring."""
    n = draw.randint(2, 4)
    lines = ["param l = 0.7 in (0, inf)"]
    x = y = 0.0
    rows, starts = [], []
    for i in range(1, n + 1):
        angle, m = draw.uniform(-2, 2), draw.uniform(0.5, 2)
        x, y = x + 0.7 * numpy.cos(angle), y + 0.7 * numpy.sin(angle)
        before = (f"x{i - 1}", f"y{i - 1}") if i > 1 else ("0", "0")
        lines += [f"coord x{i}, y{i}", f"kinetic {m!r}/2*(x{i}'^2 + y{i}'^2)"]
        lines += [f"potential {m!r}*9.81*y{i} + {draw.uniform(0, 1)!r}*x{i}^2"]
        rows.append(f"((x{i} - {before[0]})^2 + (y{i} - {before[1]})^2)/(2*l) - l/2")
        starts.append(f"start x{i} = {float(x)!r}, y{i} = {float(y)!r}")
    return "\n".join(lines), rows, starts


def body(draw: random.Random) -> tuple[str, list[str], list[str]]:
    """A body that turns about a point of it, told by a bob at its end; M depends on its place."""
    c = draw.uniform(0.3, 0.9)
    text = f"""\
coord x, y, z
rotation R
let w = omega(R)
kinetic (1 + {c!r})/2*(x'^2 + y'^2 + z'^2) + (0.9*w.x^2 + 1.7*w.y^2 + 2.1*w.z^2)/2
potential 3*y + z"""
    rows = ["(R*[0, 1, 0]).x - x", "(R*[0, 1, 0]).y - y", "(R*[0, 1, 0]).z - z"]
    starts = ["start x = 0, y = 1, z = 0, omega(R) = [1, 0.5, 0.3], x' = -0.3, z' = 1"]
    return text, rows, starts


def more_rows(draw: random.Random, rows: list[str], linear: bool) -> list[str]:
    """What follows: rows again, sums of them, the roll of one, and, unless all are to be linear in
    the others, functions of them that are 0 with them."""
    found = []
    for _ in range(draw.randint(1, 3)):
        a, b = draw.choice(rows), draw.choice(rows)
        c, d = draw.choice((-1, 1)) * draw.uniform(0.5, 2), draw.uniform(-2, 2)
        kinds = [a, f"{c!r}*({a})", f"{c!r}*({a}) + {d!r}*({b})"]
        if a == b:
            kinds.pop()
        if not linear:
            kinds = [f"exp({c!r}*({a})) - 1", f"sin({a}) + ({b})^2", f"({a})*(2 + x1 + y1)"]
            kinds = kinds[:2] if "(R*" in a else kinds
        found.append(draw.choice(kinds))
    return found


def models(seed: int, linear: bool, tmp_path):
    draw = random.Random(seed)
    text, rows, starts = draw.choice((rods, body))(draw)
    extra = more_rows(draw, rows, linear)
    mixed = rows + extra
    draw.shuffle(mixed)
    made = []
    for name, these in (("plain", rows), ("more", mixed)):
        lines = [f"constraint c{k}: {row} = 0" for k, row in enumerate(these)]
        path = tmp_path / f"{name}{seed}.lag"
        path.write_text("\n".join([f"model {name}", text, *lines, *starts]) + "\n")
        made.append(pkgen.load(str(path)))
    return made, len(extra)


METHODS = [
    {"method": "rk4", "step": 0.005},
    {"method": "dop853", "rtol": 1e-12},
    {"method": "gauss", "rtol": 1e-12},
    {"method": "gauss4", "step": 0.01},
    {"method": "rattle4", "step": 0.01},
    {"method": "lie_midpoint", "step": 0.01},
    {"method": "radau", "rtol": 1e-11},
    {"method": "rkmk4", "step": 0.005},
]


def off(a, b) -> float:
    names = [x for x in a.columns if x != "t"]
    return max(float(numpy.abs(a[x] - b[x]).max()) for x in names if x != "energy")


@pytest.mark.parametrize("seed", seeds([1, 0, 2], 3))
def test_redundant_rows_change_no_motion(seed, tmp_path):
    """Sums of rows: what is solved is the same off the constraints too, and so is each step."""
    (plain, more), _ = models(seed, True, tmp_path)
    for options in METHODS:
        if options["method"] == "rkmk4" and "R" not in str(plain.coordinates):
            continue
        one, other = (m.run(until=1.5, every=0.5, **options) for m in (plain, more))
        assert off(one, other) < 1e-9, options
        assert off(one, one) == 0 and float(numpy.abs(one["energy"]).max()) > 0


@pytest.mark.parametrize("seed", seeds([21, 20, 22], 3))
def test_rows_that_geometry_implies_change_no_motion(seed, tmp_path):
    """Functions of rows: alike on the constraints alone, so that steps differ by their error."""
    (plain, more), _ = models(seed, False, tmp_path)
    for options in ({"method": "gauss", "rtol": 1e-13}, {"method": "dop853", "rtol": 1e-13}):
        one, other = (m.run(until=1.5, every=0.5, **options) for m in (plain, more))
        assert off(one, other) < 1e-9, options


@pytest.mark.parametrize("seed", seeds([21, 0, 1], 5))
def test_accelerations_are_those_of_the_rows_alone(seed, tmp_path):
    (plain, more), _ = models(seed, seed < 20, tmp_path)
    rows = plain.run(
        until=0.7, every=0.7, method="gauss", rtol=1e-13, record=[*plain.coordinates, *plain.rates]
    )
    q, v = (numpy.array([rows[x][-1] for x in names]) for names in (plain.coordinates, plain.rates))
    a, b = plain.acceleration(q, v), more.acceleration(q, v)
    assert numpy.abs(a - b).max() <= 1e-12 * numpy.abs(a).max() and numpy.abs(a).max() > 0


RAIL = """\
model rail
param k = {k}
coord x, y
kinetic (x'^2 + y'^2)/2
constraint a: x = 0.3*y
constraint b: x = 0.3*y + k*{what}
start {start}
"""
CEASES = [
    # What: 0 at the start with its rate, not later.
    ("y^3", "x' = 0.3, y' = 1"),
    ("t^2*y", "x' = 0.3, y' = 1"),
    ("max(t - 0.5, 0)^2", "x' = 0.3, y' = 1"),
    ("(y - 0.25)^3*step(y - 0.25)", "x' = 0.3, y' = 1"),
]


@pytest.mark.parametrize(("what", "start"), CEASES)
@pytest.mark.parametrize("k", [1.0, 1e-3, 1e-6])
@pytest.mark.parametrize(
    "options",
    [{"method": "gauss"}, {"method": "rk4", "step": 0.01}, {"method": "rattle", "step": 0.01}],
)
def test_rows_that_cease_to_follow_end_the_run(tmp_path, what, start, k, options):
    path = tmp_path / "rail.lag"
    path.write_text(RAIL.format(k=k, what=what, start=start))
    model = pkgen.load(str(path))
    with pytest.raises(pkgen.RunError) as caught:
        model.run(until=2, **options)
    said = str(caught.value)
    assert "b follows from the others where the model starts, not here" in said, said
    assert "last valid time" in said


def test_an_option_that_tells_rows_apart_is_refused(tmp_path):
    path = tmp_path / "rail.lag"
    path.write_text(RAIL.format(k=0, what="1", start="x' = 0.3, y' = 1"))
    model = pkgen.load(str(path))
    assert model.run(until=1)["y"][-1] == pytest.approx(1, abs=1e-12)
    model.params["k"] = 1e-3
    with pytest.raises(
        pkgen.RunError, match="the start, or an event, breaks a constraint: b follows"
    ):
        model.run(until=1)


def test_multipliers_that_are_not_unique_are_refused_or_of_least_norm(tmp_path):
    """A bob on three equal strings carries a third of its weight by each, and all of it by one."""
    text = case("strings")
    path = tmp_path / "strings.lag"
    path.write_text(
        text + "observe f = least_lambda_a\nobserve g = least_lambda_c\nobserve h = lambda_d\n"
    )
    rows = pkgen.load(str(path)).run(until=1, every=1)
    assert rows["f"] == pytest.approx(3, rel=1e-14) and rows["g"] == pytest.approx(3, rel=1e-14)
    for name in ("a", "b"):
        path.write_text(text + f"observe f = lambda_{name}\n")
        with pytest.raises(ModelError) as caught:
            pkgen.load(str(path))
        assert f"'lambda_{name}' is not unique: " in caught.value.text()
        assert f"least_lambda_{name} is that of least norm" in caught.value.text()
    path.write_text(text.replace("constraint c: y = 0", "constraint c: y = 1e-3"))
    with pytest.raises(ModelError) as caught:
        pkgen.load(str(path))
    said = caught.value.text()
    assert "the start breaks the constraint 'c'" in said and "'b' contradicts 'a'" in said


TRUSS = case("truss")


@pytest.mark.parametrize("method", ["gauss", "dop853", "radau", "rk4", "rattle"])
def test_what_cannot_move_stays(method, tmp_path):
    """Its rates are what rounding leaves of nothing, and no row is broken by that."""
    path = tmp_path / "truss.lag"
    path.write_text(TRUSS)
    step = {"step": 0.01} if method in ("rk4", "rattle") else {}
    rows = pkgen.load(str(path)).run(until=5, method=method, **step)
    assert numpy.abs(rows["x"] - rows["x"][0]).max() < 1e-14
    assert numpy.abs(rows["w'"]).max() < 1e-20
