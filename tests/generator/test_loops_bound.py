"""Constraints of families kept as loops: every kernel against the unrolled code of the same model.

At random states, which fulfil no constraint: accelerations and multipliers are functions of any
state. An input stands in each row, so that nothing is asked of the start."""

import ctypes
import random
from pathlib import Path

import numpy as np
import pytest
from loop_harness import Looped, Written

from conftest import seeds
from pkgen.graph.graph import TooLarge
from pkgen.source import ModelError

SIZES, LONGER = (1, 2, 3, 7), (10,)  # of 20 gcc takes minutes, written out
ENDS = (
    "fixed {f}[0] = {g}, {f}[N+1] = {h}\n",
    "free {f}[0]\nfixed {f}[N+1] = {g}\n",
    "free {f}[0], {f}[N+1]\n",
    "periodic {f}\n",
)
INERTIA = (
    "",
    "",
    " + sum((2 + cos(x[i]))*(x[i]' - x[i-1]')^2/9, i = 1..N)",
    " + sum(x[i]'*X'/(7*N), i = 1..N) + sum(y[i]'*y[i-1]'/9, i = 1..N)",
)
# Rows of each member that do not depend on each other, whatever the ends are.
FAMILIES = (
    "constraint rod[i = 1..N]: (x[i] - x[i-1])^2 + (y[i] - y[i-1] + k)^2 = l[i]^2 + w",
    "constraint rod[i = 1..N]: (x[i+1] - x[i-1])^2 + (2*y[i] - y[i-1] - i)^2 = l[i]^2 + w",
    "constraint link[i = 1..N]: x[i] + 0.2*sin(x[i+1]) - y[i-2+1]*x[i] = w*sin(t)",
    "constraint tie[i = 1..N]: x[i] + x[i]*y[i] + X*x[i]/(5 + i) = w*t",
    "constraint grip[i = 1..N]: x[i]*(x[i] - w*i)*sin(y[i]) + X*(1 + i/N) = w",
    "rolling blade[i = 1..N]: x[i]'*cos(y[i]) + (y[i]' - 0.3*x[i-1]')*sin(y[i]) = w/i",
    "rolling drift[i = 1..N]: x[i]' + 0.1*y[i+1]'*y[i-1] + 0.2*X' = w*X",
)
SINGLES = (
    "constraint wall: z[1]*X + X^2 = w + t",
    "constraint last[N]: z[N] + sin(z[N]*X) = w",
    "constraint mean: sum(z[i]*(1 + z[i]/9), i = 1..N) = w*t + X",
    "rolling slip: X'*(2 + sin(X)) + sum(z[i]*z[i]', i = 1..N) = w",
)


def model(dice: random.Random) -> str:
    """Families x, y in the rows of each member, z in single rows, a scalar X beside."""
    text = "model tied\nsize N = 5\nparam k = 0.7\nparam l[i = 1..N+1] = 1 + 0.3*sin(i)\n"
    text += "input w\ncoord x[1..N], y[1..N], z[1..N], X\n"
    rows = dice.choice(FAMILIES)
    for family in "xyz":  # a rod between a member and itself says nothing
        ends = ENDS[::3] if " rod[" in rows and family != "z" else ENDS
        given = [dice.choice(("0", "0.3", "sin(t)", "w", "t^2/2")) for _ in range(2)]
        text += dice.choice(ends).format(f=family, g=given[0], h=given[1])
    text += "kinetic sum((1 + 0.2*i/N)*x[i]'^2/2 + y[i]'^2 + z[i]'^2/3, i = 1..N) + X'^2"
    text += dice.choice(INERTIA) + "\n"
    text += "potential sum(k*(x[i] - x[i-1])^2 + cos(y[i+1] - y[i]) + z[i]^4, i = 1..N) - X*x[1]\n"
    if dice.random() < 0.5:
        text += "force x[i = 1..N] = -0.1*x[i]' + w\n"
    name = rows.split()[1].split("[")[0]
    text += rows + "\n"
    if dice.random() < 0.6:
        text += dice.choice(SINGLES) + "\n"
    return text + f"observe pull = lambda_{name}[1] + X\n"


class Tied:
    """Both at one size and one state."""

    def __init__(self, text: str, loops: Looped, size: int, folder: Path, dice: random.Random):
        self.size, self.at, self.text = size, loops.at(size), f"{text}N = {size}"
        self.flat = Written(text, size, folder)
        e = self.flat.program.equations
        n, self.n, self.c = len(e.coordinates), self.at.n, len(e.constraints.residual)
        assert n == self.n
        number = lambda: dice.uniform(-1, 1)  # noqa: E731
        q, v, u = ([number() for _ in range(k)] for k in (n, n, len(e.inputs)))
        if "grip" in text:  # a row that X alone makes regular
            q[dice.randrange(size)] = 0
            u[0] = 0
        self.state = (dice.uniform(0.5, 2), q, v, u)
        self.holonomic = e.constraints.holonomic
        self.J, self.rates = (
            np.array(x) for x in self.flat.call("constraint_jacobian", *self.state)[1]
        )
        self.J = self.J.reshape(self.c, n)

    def loops(self, kernel: str, count: int, result: object = None) -> np.ndarray:
        status, (found,) = self.at.call(kernel, *self.state, (count,), result)
        assert not status
        return np.array(found)

    def same(self, found: np.ndarray, expected: np.ndarray, tolerance: float = 1e-12) -> None:
        scale = max(1.0, np.abs(expected).max(initial=0))
        assert np.abs(found - expected).max(initial=0) <= tolerance * scale, self.text


@pytest.mark.parametrize("seed", seeds(range(3), 7, [21, 22]))
def test_rows_of_loops_are_those_of_members_written_out(seed: int, tmp_path: Path) -> None:
    dice = random.Random(seed)
    text = model(dice)
    loops = Looped(text, tmp_path / "loops")
    compared = 0
    for size in (*SIZES, *LONGER * (seed > 1)):
        try:
            found = Tied(text, loops, size, tmp_path / f"n{size}", dice)
        except (
            ModelError,
            TooLarge,
        ):  # a row of one member may say nothing, M be too large
            continue
        n, c, flat = found.n, found.c, found.flat
        cond = np.linalg.cond(found.J)
        if cond > 1e5:  # rows that all but depend on each other have no digits to compare
            continue
        compared += 1
        a = np.array(flat.call("acceleration", *found.state)[1][0])
        found.same(found.loops("acceleration", n, ctypes.c_int), a, 1e-14 * cond**2)
        mu = np.array(flat.call("multipliers", *found.state)[1][0])
        found.same(found.loops("multipliers", c), mu, 1e-14 * cond**2)
        found.same(found.loops("constraint_rates", c), found.rates)
        if found.holonomic:
            phi = flat.call("constraint", *found.state)[1][0]
            found.same(found.loops("constraint", found.holonomic), np.array(phi))
        sizes = [np.array(x) for x in flat.call("residual_scale", *found.state)[1]]
        for mine, kernel in zip(sizes, ("position_size", "rate_size"), strict=True):
            rows = found.holonomic if kernel == "position_size" else c
            at_loops = found.loops(kernel, rows)
            # At an end what cancels is not there if written out; members of parameters vary here.
            inside = slice(3, size - 3)
            assert (at_loops > mine[:rows] / 2).all(), found.text
            assert (at_loops[inside] <= 2 * mine[:rows][inside]).all(), found.text
        observed = np.array(flat.call("observe", *found.state)[1][0])
        found.same(found.loops("observe", 1), observed, 1e-14 * cond**2)
        M = np.array(flat.call("inertia", *found.state)[1][0]).reshape(n, n)
        found.same(found.loops("diagonal", n), np.diag(M))
        _projects(found, M, dice)
    assert compared >= 3, text


def _projects(found: Tied, M: np.ndarray, dice: random.Random) -> None:
    """M d = J^T mu, J d = r, of all rows and of those of positions."""
    for holonomic in (0, 1):
        rows = found.holonomic if holonomic else found.c
        J, at = found.J[:rows], found.at
        r = np.zeros(found.c)
        r[:rows] = [dice.uniform(-1, 1) for _ in range(rows)]
        t, q, v, u = found.state
        arrays = [(ctypes.c_double * max(1, len(x)))(*x) for x in (q, v, u)]
        p = ctypes.byref(at.params)
        assert (
            at.of.function("bound_factor", ctypes.c_int)(
                p, ctypes.c_double(t), *arrays, holonomic, None, None
            )
            == 0
        ), found.text
        d, mu = (ctypes.c_double * found.n)(), (ctypes.c_double * found.c)()
        at.of.function("bound_solve")(p, None, (ctypes.c_double * found.c)(*r), d, mu)
        if not rows:
            continue
        cond = np.linalg.cond(J)
        expected = np.linalg.solve(J @ np.linalg.solve(M, J.T), r[:rows])
        found.same(np.array(mu)[:rows], expected, 1e-14 * cond**2)
        found.same(np.array(d), np.linalg.solve(M, J.T @ expected), 1e-14 * cond**2)
    x = np.array([dice.uniform(0, 1) for _ in range(found.n)])
    t, q, v, u = found.state
    arrays = [(ctypes.c_double * max(1, len(y)))(*y) for y in (q, v, u, list(x))]
    out = (ctypes.c_double * found.c)()
    found.at.of.function("spread")(ctypes.byref(found.at.params), ctypes.c_double(t), *arrays, out)
    exact = np.abs(found.J) @ x
    assert (np.array(out) >= exact * (1 - 1e-12)).all(), found.text
    # A member beyond a free end or in a short ring is another member: sizes of slopes are added.
    if found.size > 3 and "free" not in found.text:
        found.same(np.array(out), exact)
