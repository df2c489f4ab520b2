"""Chains of `let`s with constraints beside them, or inertia across free and periodic ends, kept as
loops: every kernel against the unrolled code of the same model, at random states."""

import ctypes
import random
from pathlib import Path

import numpy as np
import pytest
from c_harness import CONSTRAINT, MASS, failed
from carried_models import tied_links
from loop_harness import Looped, Written

from conftest import case, seeds
from pkgen.source import ModelError

KERNELS = {"force": 1, "momenta": 1, "gradient": 1, "canonical": 2}
SCALARS = ("energy", "lagrangian", "kinetic", "potential")
SIZES = (3, 6)


class Both:
    """At one size, and at a random state."""

    def __init__(self, text: str, loops: Looped, size: int, folder: Path, dice: random.Random):
        self.at, self.text = loops.at(size), f"{text}N = {size}"
        self.flat = Written(text, size, folder)
        e = self.flat.program.equations
        self.n, self.rows = self.at.n, 0
        q, v, u = ([dice.uniform(-1, 1) for _ in range(k)] for k in (self.n, self.n, len(e.inputs)))
        self.state = (dice.uniform(0.5, 2), q, v, u)
        self.J = np.zeros((0, self.n))
        if "lambda" in text:
            self.rows, self.holonomic = len(e.constraints.residual), e.constraints.holonomic
            self.J = self.written("constraint_jacobian")[0].reshape(self.rows, self.n)
        self.M = self.written("inertia" if self.rows else "mass")[0].reshape(self.n, self.n)
        self.error = 1e-14 * np.linalg.cond(self.K())

    def K(self) -> np.ndarray:
        scale = np.diag(1 / np.sqrt(np.abs(np.diag(self.M))))
        J = self.J @ scale
        J = J / (np.linalg.norm(J, axis=1)[:, None] + (self.rows == 0))
        zero = np.zeros((self.rows, self.rows))
        return np.block([[scale @ self.M @ scale, J.T], [J, zero]])

    def written(self, kernel: str) -> list[np.ndarray]:
        return [np.array(x) for x in self.flat.call(kernel, *self.state)[1]]

    def loops(self, kernel: str, *counts: int, result: object = None) -> list[np.ndarray]:
        status, found = self.at.call(kernel, *self.state, counts, result)
        assert result is not ctypes.c_int or status == 0, self.text
        return [np.array(x) for x in found]

    def same(self, found: np.ndarray, expected: np.ndarray, error: float = 1e-12) -> None:
        scale = max(1.0, np.abs(expected).max(initial=0))
        off = np.abs(found - expected).max(initial=0) / scale
        assert off <= max(error, 1e-12), f"{off}\n{self.text}"


@pytest.mark.parametrize("seed", seeds([2, 0, 1], 9))
def test_chains_that_are_tied_equal_the_unrolled_code(seed: int, tmp_path: Path) -> None:
    dice = random.Random(seed)
    text = tied_links(dice)
    loops = Looped(text, tmp_path / "loops")
    assert loops.equations.extended
    compared = 0
    for size in SIZES[: 1 + (seed != 2)]:
        try:
            both = Both(text, loops, size, tmp_path / f"n{size}", dice)
        except ModelError:  # rows of so few members say nothing
            continue
        if both.error > 1e-8:
            continue
        compared += 1
        n, rows = both.n, both.rows
        expected = both.written("acceleration")[0]
        both.same(both.loops("acceleration", n, result=ctypes.c_int)[0], expected, both.error)
        for kernel, count in KERNELS.items():
            written = both.written(kernel)
            if rows and kernel in ("force", "canonical"):  # with the forces of constraints
                written[-1] -= both.J.T @ both.written("multipliers")[0]
            for one, other in zip(written, both.loops(kernel, *(n,) * count), strict=True):
                both.same(other, one, both.error)
        for kernel in SCALARS:
            value, _ = both.at.call(kernel, *both.state, (), ctypes.c_double)
            assert value == pytest.approx(both.flat.call(kernel, *both.state)[0], rel=1e-12), text
        observed = both.written("observe")[0]
        both.same(both.loops("observe", len(observed))[0], observed, both.error)
        if rows:
            _constraints(both)
            _projects(both, dice)
    assert compared, text


def _constraints(both: Both) -> None:
    rows = both.rows
    both.same(both.loops("multipliers", rows)[0], both.written("multipliers")[0], both.error)
    both.same(both.loops("constraint_rates", rows)[0], both.written("constraint_jacobian")[1])
    if both.holonomic:
        both.same(both.loops("constraint", both.holonomic)[0], both.written("constraint")[0])
    both.same(both.loops("diagonal", both.n)[0], np.diag(both.M))
    x = np.abs(both.state[1])
    arrays = [(ctypes.c_double * max(1, len(y)))(*y) for y in (*both.state[1:], list(x))]
    out = (ctypes.c_double * rows)()
    params = ctypes.byref(both.at.params)
    both.at.of.function("spread")(params, ctypes.c_double(both.state[0]), *arrays, out)
    exact = np.abs(both.J) @ x
    assert (np.array(out) >= exact * (1 - 1e-12)).all(), both.text
    assert (np.array(out) <= 9 * both.n * np.abs(both.J).max()).all(), both.text


def _projects(both: Both, dice: random.Random) -> None:
    """M d - J^T mu = f, J d = r, of all rows and of those of positions; the rows' pivots."""
    for holonomic in (0, 1):
        rows = both.holonomic if holonomic else both.rows
        J, r = both.J[:rows], np.zeros(both.rows)
        if not rows:
            continue
        r[:rows] = [dice.uniform(-1, 1) for _ in range(rows)]
        f = [dice.uniform(-1, 1) for _ in range(both.n)]
        t, q, v, u = both.state
        arrays = [(ctypes.c_double * max(1, len(x)))(*x) for x in (q, v, u)]
        pivots, norms, mu = ((ctypes.c_double * both.rows)() for _ in range(3))
        p, d = ctypes.byref(both.at.params), (ctypes.c_double * both.n)()
        factor = both.at.of.function("bound_factor", ctypes.c_int)
        assert factor(p, ctypes.c_double(t), *arrays, holonomic, pivots, norms) == 0
        S = J @ np.linalg.solve(both.M, J.T)
        found, most = np.array(pivots)[:rows], np.array(norms)[:rows]
        assert (found > 0).all() and (found <= most * (1 + 1e-9)).all()
        solve = both.at.of.function("bound_solve")
        for force in (None, f):
            given = None if force is None else (ctypes.c_double * both.n)(*force)
            solve(p, given, (ctypes.c_double * both.rows)(*r), d, mu)
            free = np.linalg.solve(both.M, force or np.zeros(both.n))
            expected = np.linalg.solve(S, r[:rows] - J @ free)
            both.same(np.array(mu)[:rows], expected, both.error * np.linalg.cond(S))
            moved = free + np.linalg.solve(both.M, J.T @ expected)
            both.same(np.array(d), moved, both.error * np.linalg.cond(S))


WITHOUT = case("without")


def test_a_link_without_mass_is_named(tmp_path: Path) -> None:
    at = Looped(WITHOUT.replace("constraint more", "constraint more: X = w #"), tmp_path).at(8)
    q = [0.1, 0.3, -0.4, 0.2, 0.9, 0.5, -0.2, 0.4, *(0.3 + 0.1 * i for i in range(8)), 0.1]
    for place, expected in ((None, 0), (3, 0), (7, failed(MASS, 7))):
        for k in range(8):
            at.params.m[k] = 0 if k == place else 1
        assert at.prepare() == 0
        status, _ = at.call("acceleration", 0, q, [0.1] * 17, (1.0,), (17,), ctypes.c_int)
        assert status == expected


def test_rows_that_depend_on_each_other_are_named(tmp_path: Path) -> None:
    """And one that a scalar coordinate alone moves, through what it carries, is none of these."""
    at = Looped(WITHOUT, tmp_path / "both").at(8)
    q = [0.1 * k for k in range(8)] + [0.3] * 8 + [0.1]
    status, _ = at.call("acceleration", 0, q, [0.1] * 17, (1.0,), (17,), ctypes.c_int)
    assert status == failed(CONSTRAINT, 9)
    text = WITHOUT.replace("constraint more: y[N] + r[1]/2 = 1.5*w\n", "")
    both = Both(text, Looped(text, tmp_path / "one"), 8, tmp_path / "n8", random.Random(3))
    q = [np.pi / 2] * 8 + [0.3, 0.4, 0.5, 0, 0.7, 0.8, 0.9, 1] + [0.1]
    both.state = (0.0, q, [0.1] * 17, [1.0])
    expected = both.written("acceleration")[0]
    both.same(both.loops("acceleration", 17, result=ctypes.c_int)[0], expected, 1e-11)
