"""Linkages of rods in maximal coordinates with tied ends, against angles with the same ties."""

from __future__ import annotations

import math
import random
import re

import pytest

from conftest import rows, seeds, written

ADAPTIVE = ["gauss", "dop853", "dopri5", "radau"]
FIXED = ["rk4", "gauss4", "radau9", "lobatto4", "rattle6", "rkmk8"]
DIGITS = re.compile(r"loses (\d+) of 16 digits")


class Linkage:
    """A tree of hanging rods. `loops` massless links tie ends of rods to points: both forms have
    their rows."""

    def __init__(self, seed: int, most: int, span: float, loops: int):
        draw = random.Random(seed)
        self.n = draw.randint(2, most)
        self.parent = [draw.randrange(-1, k) if k else -1 for k in range(self.n)]
        self.mass = [10 ** draw.uniform(-span, span) for _ in range(self.n)]
        self.length = [10 ** draw.uniform(-span / 4, span / 4) for _ in range(self.n)]
        self.angle = [draw.uniform(-1.2, 1.2) for _ in range(self.n)]
        free = range(1, self.n)  # the first one swings
        self.closed = sorted(draw.sample(free, min(loops, self.n - 1)))

    def tip(self, k: int, at: list[float], part: float = 1.0) -> tuple[float, float]:
        x, y = self.tip(self.parent[k], at) if self.parent[k] >= 0 else (0.0, 0.0)
        reach = part * self.length[k]
        return x + reach * math.sin(at[k]), y - reach * math.cos(at[k])

    def parameters(self) -> str:
        masses = (f"param m{k} = {x!r}\n" for k, x in enumerate(self.mass))
        return "".join((*masses, *(f"param l{k} = {x!r}\n" for k, x in enumerate(self.length))))

    def end(self, k: int, x: str, y: str) -> tuple[str, str]:
        return f"({x} + l{k}/2*sin(a{k}))", f"({y} - l{k}/2*cos(a{k}))"

    def text(self, maximal: bool) -> str:
        text, held = "model linkage\nparam g = 9.81\n" + self.parameters(), ""
        ends = {-1: ("0", "0")}
        for k, parent in enumerate(self.parent):
            middle = self.end(k, *ends[parent])
            text += f"coord a{k}" + f", x{k}, y{k}" * maximal + "\n"
            text += f"start a{k} = {self.angle[k]!r}\n"
            if maximal:
                x, y = self.tip(k, self.angle, 0.5)
                text += f"start x{k} = {x!r}, y{k} = {y!r}\n"
                held += f"constraint jx{k}: x{k} = {middle[0]}\n"
                held += f"constraint jy{k}: y{k} = {middle[1]}\n"
            else:
                text += f"let x{k} = {middle[0]}\nlet y{k} = {middle[1]}\n"
            ends[k] = self.end(k, f"x{k}", f"y{k}")
            text += f"kinetic m{k}/2*(x{k}'^2 + y{k}'^2) + m{k}*l{k}^2/24*a{k}'^2\n"
            text += f"potential m{k}*g*y{k}\n"
        for k in self.closed:
            x, y = self.tip(k, self.angle)
            far, up = self.length[k], self.length[k] / 3
            end, there = ends[k]
            held += f"constraint c{k}: ({end} - {x + far!r})^2 + ({there} - {y + up!r})^2 = "
            held += f"{far**2 + up**2!r}\n"
        return text + held


def _compare(pkgen, tmp_path, seed: int, method: str, most: int, span: float, loops: int) -> None:
    """To 100 of the tolerance, or to what the run says that rounding leaves. Where rows all but
    depend on each other, a fixed implicit step may have no solution: the run says so and ends."""
    linkage = Linkage(seed, most, span, loops)
    until = 0.3 * math.sqrt(min(linkage.length) / 9.81)
    fixed = ["--step", until / 256] if method in FIXED else ["--rtol", "1e-9"]
    at = ["--until", until, "--every", until]
    (tmp_path / "maximal").mkdir()
    full = written(tmp_path / "maximal", linkage.text(True))
    free = written(tmp_path, linkage.text(False))
    done = pkgen("run", full, *at, "--method", method, *fixed)
    lost = max(map(int, DIGITS.findall(done.stderr)), default=0)
    if method in FIXED and lost >= 6 and "by Newton's method there is a solution" in done.stderr:
        assert done.returncode == 4, done.stderr
        return
    assert done.returncode == 0, (seed, done.stderr)
    names, *_, last = done.stdout.strip().splitlines()
    found = dict(zip(names.split(","), map(float, last.split(",")), strict=True))
    right = rows(pkgen, free, *at, "--rtol", "1e-12")[-1]
    for k in range(linkage.n):
        error = abs(found[f"a{k}"] - right[f"a{k}"])
        assert error <= 100 * max(1e-9, 10.0 ** (lost - 16)), (seed, method, k, error, lost)


@pytest.mark.parametrize("seed", seeds([1, 2, 5], 37))
def test_linkages_in_places_move_as_in_angles(pkgen, tmp_path, seed):
    draw = random.Random(seed)
    method = draw.choice(ADAPTIVE + FIXED)
    most, span = (4, 2) if seed < 10 else (12, 4)
    _compare(pkgen, tmp_path, seed, method, most, span, draw.randint(0, 3))
