"""Limits of joints stop a run where they are passed, and at once where it starts beyond them."""

from __future__ import annotations

import math
import random

import pytest

from conftest import case, written
from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.derive.derive import derive
from pkgen.source import Source

LIFT = case("lift")


def test_they_are_the_events_that_one_would_write():
    model = check_text(Source("lift.lag", LIFT))[0]
    shown = [(e.name, e.direction, e.stop, e.limit) for e in model.events]
    names = ("drop_1_lower", "drop_1_upper", "drop_2_lower", "drop_2_upper")
    assert [x[0] for x in shown] == [*names, "hinge_lower", "hinge_upper"]
    assert all(x[1:] == ((1 if "upper" in x[0] else -1), True, True) for x in shown)
    e = derive(model)
    draw = random.Random(3)
    drop1, drop2, a = (draw.uniform(-1, 1) for _ in range(3))
    symbols = {Symbol(Kind.COORDINATE, k): x for k, x in enumerate((drop1, drop2, a))}
    symbols |= {Symbol(Kind.PARAMETER, 0): 9.81, Symbol(Kind.PARAMETER, 1): 0.4}
    wanted = [drop1 + 0.4, drop1 - 0.5, drop2 + 0.4, drop2 - 1, a + math.pi / 2, a - math.pi]
    assert evaluate(e.graph, e.events, symbols) == pytest.approx(wanted, rel=1e-14)


def test_members_that_start_beyond_one_end_alone(pkgen, tmp_path):
    model = written(tmp_path, LIFT)
    ran = pkgen("run", model, "--scene", "many")
    rows = [line.split(",") for line in ran.stdout.splitlines()[1:]]
    assert ran.returncode == 0, ran.stderr
    assert [float(r[1]) for r in rows if r[0] == "1"][-1] == 0  # begins at -1, beyond -0.4
    assert [float(r[1]) for r in rows if r[0] == "2"][-1] == pytest.approx(math.sqrt(1 / 9.81))


SHUTTLE = case("shuttle")


def on_a_limit(draw: random.Random) -> tuple[tuple[float, ...], float | None]:
    """z, z', F, c, low, high of a start on a limit, but for rounding, far from the other one; and
    when it is passed, by hand: what leads outwards is positive here, and of F and c one is 0."""
    v, F = (draw.choice((0, draw.uniform(-2, -0.1), draw.uniform(0.1, 1))) for _ in range(2))
    c = draw.choice((0, -0.5, 0.5)) if v == F == 0 else 0
    at = 0 if next((x for x in (v, F, c) if x), 0) > 0 else -2 * v / F if v < 0 < F else None
    wall, side = draw.uniform(-2, 2), draw.choice((-1, 1))
    ends = (wall, 1e9) if side < 0 else (-1e9, wall)
    start = math.nextafter(wall, wall + draw.choice((-1, 0, 1)))
    return (start, side * v, side * F, side * c, *ends), at


@pytest.mark.parametrize("method", ["--method=gauss", "--method=rk4 --step=7"])
def test_random_starts_on_a_limit(pkgen, tmp_path, method):
    draw = random.Random(method)
    starts = [on_a_limit(draw) for _ in range(60)]
    (tmp_path / "shuttle.lag").write_text(SHUTTLE)
    rows = [",".join(map(repr, row)) for row, _ in starts]
    (tmp_path / "starts.csv").write_text("\n".join(("z,z',F,c,low,high", *rows)) + "\n")
    given = (tmp_path / "shuttle.lag", "--ensemble", tmp_path / "starts.csv", *method.split())
    ran = pkgen("run", *given, "--until", "70", "--record", "z")
    assert ran.returncode == 0, ran.stderr
    ends = {int(r[0]): float(r[1]) for r in map(lambda x: x.split(","), ran.stdout.split()[1:])}
    for k, (row, at) in enumerate(starts, 1):
        # where c alone leads out it is at rest but for rounding for a while: t^3 = 6 eps/c
        near = 1e-4 if row[3] else 0 if at == 0 else 1e-9
        assert abs(ends[k] - (70 if at is None else at)) <= near, (row, at, ends[k])
    assert {0, None} < {at for _, at in starts}
