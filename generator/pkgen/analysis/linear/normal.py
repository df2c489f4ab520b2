"""`--diagnose modes`: the modes at the equilibrium about which a motion oscillates, and the energy
of each, if all forces come from L and L has no terms of first degree in the rates there:

    Q = U^T M (q - q*),  P = U^T (p - p*),  U^T M U = 1,
    h = h* + sum of (P^2 + omega^2 Q^2)/2 + nonlinear terms

The equilibrium is chosen as follows. If the run starts at rest at an equilibrium, it is this one.
Otherwise it is a minimum of the potential below the energy of the motion: the nearest one for which
the potential on the straight line from the start stays below this energy; else the nearest one.
Without any, it is the nearest unstable equilibrium. For other models it is the nearest equilibrium
or steady motion; stable ones come first.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy
from numpy import linalg

from ...run.simulate import Outcome, Runnable
from ...system.exits import USAGE
from .equilibria import TRIES, Search, of_system
from .system import System

FEW = 8  # with more coordinates equilibria are sought from the start alone
PART = 1e-6  # step of differences, as a fraction of the distance from the equilibrium to the start
SAME = 1e-12  # differences below this part of the largest are round-off
KINK = 1e-3  # a relative jump of derivatives
WAY = 64  # points on the line to the start at which the potential is compared
SHOWN = 64  # modes with shapes and energies
START, IN_SIGHT, BELOW, UNSTABLE, KINKED, NO_MODES, NOTHING = range(7)  # ranks, the best first


class Refused(Exception):
    """There are no modes; the text is the reason."""


class NoEnergies(Exception):
    """The modes have no energies of their own."""


class Normal:
    """The normal modes of a system without rotations, constraints and first-order variables."""

    def __init__(self, system: System):
        self.system, self.n = system, system.n
        self.q0, self.v0 = numpy.split(system.start, 2)
        self.turns = numpy.zeros(self.n, bool)

    def _at(self, q: numpy.ndarray, name: str) -> numpy.ndarray:
        rows = numpy.atleast_2d(q)
        return self.system.kernel(name, 0.0, numpy.concatenate([rows, 0 * rows], 1))

    def _rests(self, q: numpy.ndarray, share: float) -> bool:
        """Whether the system can rest at q: the force there is below the fraction `share` of its
        change up to the start, as the derivative at q has it. Far away, where forces decay, the
        ratio is about 1."""
        force, moved = self._at(numpy.array([q, q + PART * (self.q0 - q)]), "force")
        if not (numpy.isfinite(force).all() and numpy.isfinite(moved).all()):
            return False
        most = abs(force).max()
        return bool(most <= share / PART * abs(moved - force).max() or most == 0)

    def pencil(self, q: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Returns M and K of M u'' + K u = 0 at q. Raises LinAlgError, and NoEnergies if forces
        depend on the rates."""
        (M,) = self._at(q, "mass").reshape(1, self.n, self.n)
        p_q, f_q, f_v = self._at(q, "momentum jacobian").reshape(3, self.n, self.n)
        if not all(numpy.isfinite(x).all() for x in (M, p_q, f_q, f_v)):
            raise linalg.LinAlgError
        k, m = abs(f_q).max(), abs(M).max()
        if abs(p_q - f_v).max() > SAME * math.sqrt(k * m) or abs(f_q - f_q.T).max() > SAME * k:
            raise NoEnergies
        return M, -(f_q + f_q.T) / 2

    def normal(self, q: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
        """Returns M, the squares of the frequencies, ascending, and the shapes, a row each, whose
        largest entry is positive."""
        M, K = self.pencil(q)
        factor = linalg.cholesky(M)
        if (factor.diagonal() ** 2 <= SAME * M.diagonal()).any():
            raise linalg.LinAlgError
        root = linalg.inv(factor)
        squares, U = linalg.eigh(root @ K @ root.T)
        shapes = (root.T @ U).T
        largest = abs(shapes).max(1, keepdims=True)
        leads = (abs(shapes) * (1 + 1e-9) >= largest).argmax(1)
        shapes *= numpy.sign(shapes[range(self.n), leads])[:, None]
        squares[abs(squares) <= SAME * abs(squares).max()] = 0
        return M, squares, shapes

    def _is_kinked(self, q: numpy.ndarray) -> bool:
        """Whether the force or its derivatives jump at q, along the line to the start."""
        by = PART * (self.q0 - q) * numpy.array([[1.0], [-1.0], [0.5], [-0.5]])
        force = self._at(q + by, "force")
        wide, close = abs(force[0] - force[1]).max(), abs(force[2] - force[3]).max()
        a, b = self._at(q + by[:2], "momentum jacobian")
        jump = abs(a - b).max() > KINK * max(abs(a).max(), abs(b).max())
        return bool(jump or close > 0.75 * wide > 0)

    def _rank(self, q: numpy.ndarray) -> int:
        size, far = linalg.norm(self.q0), linalg.norm(q - self.q0)
        away = far / abs(self.q0).max() if size else math.inf if far else 0.0
        if away > 0.1 and not self._rests(q, 1e-3):
            return NOTHING
        try:
            _, squares, _ = self.normal(q)
        except (linalg.LinAlgError, NoEnergies):
            return NO_MODES
        if self._is_kinked(q):
            return KINKED
        if away <= 1e-6 and not self.v0.any():
            return START
        if not squares.any():  # far away, exponentially decaying forces underflow to 0
            return NOTHING
        (h,) = self.system.kernel("energy", 0.0, self.system.start)[0]
        line = self.q0 + (q - self.q0) * numpy.linspace(0, 1, WAY + 1)[1:, None]
        heights = self._at(line, "energy")[:, 0]
        slack = 1e-9 * max(abs(h), abs(heights[-1]))
        if squares[0] < 0 or heights[-1] > h + slack:
            return UNSTABLE
        return IN_SIGHT if (heights[:-1] <= h + slack).all() else BELOW

    def chosen(self) -> numpy.ndarray:
        """Returns the equilibrium. Raises Refused or NoEnergies."""
        search = Search(self.system, (), cyclic=False)
        search.run(TRIES if self.n <= FEW else 0)
        self.turns = search.turns
        found = [numpy.zeros(self.n)] if self._rests(numpy.zeros(self.n), SAME) else []
        turn = 2 * math.pi
        ranked = []
        for q in (*found, *search.known):
            q = q + self.turns * turn * numpy.round((self.q0 - q) / turn)
            ranked.append((self._rank(q), float(linalg.norm(q - self.q0)), tuple(q)))
        rank, _, q = min(ranked, default=(NOTHING, 0.0, ()))
        if rank == KINKED:
            raise Refused(
                "where nothing pulls the equations have a kink (abs, min, max, step): there are no "
                "modes, for no motion is small beside it"
            )
        if rank == NOTHING:
            raise NoEnergies
        return numpy.array(q)

    def record(self, rows: numpy.ndarray) -> dict[str, Any]:
        """Returns the modes, and their energies at the rows (t, q, v)."""
        q = self.chosen()
        M, squares, shapes = self.normal(q)
        turn, n = 2 * math.pi, self.n
        (h,) = self._at(q, "energy")[0]
        there = rows[:, 1:]
        x = there[:, :n] - q
        x -= self.turns * turn * numpy.round(x / turn)
        # M q' = p - p(rest); p(rest) is not 0 if L contains a total time derivative.
        p = self.system.kernel("momenta", 0.0, there) - self._at(there[:, :n], "momenta")
        E = ((p @ shapes.T) ** 2 + squares * (x @ M @ shapes.T) ** 2) / 2
        energy = self.system.kernel("energy", 0.0, there)[:, 0]
        total = E.sum(1)
        table = numpy.column_stack([rows[:, 0], total, energy - h - total, E[:, :SHOWN]])
        return {
            "equilibrium": q.tolist(),
            "energy": float(h),
            "squares": squares.tolist(),
            "frequencies": [math.sqrt(x) if x >= 0 else None for x in squares],
            "shapes": [{"shape": shape} for shape in shapes[:SHOWN].tolist()],
            "modes": n,
            "left_out": max(0, n - SHOWN),
            "rows": table.tolist(),
        }


def _steady(system: System, run: Runnable) -> dict[str, Any]:
    """Returns the modes of a model whose modes have no energies."""
    found = of_system(system, run.compilation, TRIES)
    if not found.equilibria:
        raise Refused("no equilibrium was found about which it could oscillate")
    at = found.nearest(system.q(system.begun), system.v(system.begun), stable=True)
    return {
        "equilibrium": list(at.q[: system.m]),
        "energy": at.energy,
        "squares": [m.frequency**2 or -(max(m.growth, 0.0) ** 2) for m in at.modes],
        "frequencies": [None if m.growth > 0 else m.frequency for m in at.modes],
        "growths": [m.growth for m in at.modes],
        "shapes": [{"shape": list(m.re)} for m in at.modes],
        "modes": len(at.modes),
        "left_out": 0,
        "rows": [],
    }


def complete(run: Runnable, told: Outcome) -> Outcome:
    """Returns the outcome of a run with its modes in the report, or why there are none."""
    found = told.report["diagnostics"]["modes"]
    rows = numpy.array(found.pop("states"), float)
    system = System(run.library, replace(run.settings, every=None))
    try:
        if (
            not run.compilation.equations.dense
            and not system.kernel("momentum jacobian", 0.0, system.start).size
        ):
            raise Refused("the system has no kernel jacobian: its families are kept as loops")
        if not system.is_steady():
            raise Refused("normal modes are of a system without explicit time, and without inputs")
        natural = run.compilation.structure.variational and system.n == system.m
        with numpy.errstate(all="ignore"):
            try:
                if not natural or system.bound:
                    raise NoEnergies
                found |= Normal(system).record(rows)
            except (NoEnergies, linalg.LinAlgError):
                found |= _steady(system, run)
    except Refused as refused:
        found |= {"status": "PK_REFUSED", "reason": str(refused)}
        code = told.code if "all" in run.settings.diagnose else told.code or USAGE
        return replace(told, code=code, messages=f"{told.messages}run: diagnose modes: {refused}\n")
    return told
