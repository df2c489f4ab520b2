"""The mechanics of contacts for tests: impacts, multipliers and friction are found by trying all
states of the few contacts, as textbooks define them. contact_reference.py has motions."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass, field

import numpy as np
import sympy as sp

CLOSE = 1e-9  # what is 0
DOUBTFUL = 1e-6  # what may be 0
SHORT = 2e-3  # flights that accumulate


class Doubt(Exception):
    """The next motion is not determined, or not to the accuracy of the comparison."""


@dataclass
class Contact:
    gap: str
    restitution: float = 0
    mu: float | None = None
    slip: str = ""
    poisson: bool = False


@dataclass
class Friction:
    slip: str
    force: str
    static: str = ""


@dataclass
class Event:
    """A function of which a sign change, or only one downwards, gives new values, and turns one of
    the latches on or off."""

    value: str
    falling: bool
    then: dict[str, str]
    on: int | None = None
    off: int | None = None


@dataclass
class System:
    coordinates: list[str]
    kinetic: str = "0"
    potential: str = "0"
    forces: dict[str, str] = field(default_factory=dict)
    contacts: list[Contact] = field(default_factory=list)
    frictions: list[Friction] = field(default_factory=list)
    constraints: list[str] = field(default_factory=list)
    latches: list[str] = field(default_factory=list)  # constraints that hold at times
    on: bool = False  # whether they hold at the start
    switches: list[str] = field(default_factory=list)  # held0, ... are 1 where these are positive
    events: list[Event] = field(default_factory=list)
    cells: dict[str, tuple[float, str]] = field(default_factory=dict)  # start, value at a sample
    period: float = 0.0  # of samples
    # of quasi-coordinates: names of v, rates of the coordinates, M and forces
    rates: list[str] = field(default_factory=list)
    moves: list[str] = field(default_factory=list)
    mass: list[list[str]] = field(default_factory=list)
    loads: list[str] = field(default_factory=list)


def python(text: str) -> str:
    return re.sub(r"(\w)'", r"\1_d", text).replace("^", "**")


class Mechanics:
    """The functions of a system, and what its contacts and frictions do in a state."""

    def __init__(self, system: System):
        self.s = s = system
        rates = s.rates or [f"{q}'" for q in s.coordinates]
        q, v = (
            [sp.Symbol(python(n), real=True) for n in names] for names in (s.coordinates, rates)
        )
        t = sp.Symbol("t", real=True)
        held = [sp.Symbol(f"held{k}", real=True) for k in range(len(s.switches))]
        cells = [sp.Symbol(c, real=True) for c in s.cells]
        names = {str(x): x for x in [t, *q, *v, *held, *cells]}

        def of(text: str) -> sp.Expr:
            return sp.sympify(python(str(text)), locals=names)

        moves = [of(x) for x in s.moves] or v

        def rate(expr: sp.Expr) -> sp.Expr:
            return sp.diff(expr, t) + sum(
                sp.diff(expr, x) * m for x, m in zip(q, moves, strict=True)
            )

        if s.mass:
            M = sp.Matrix([[of(x) for x in row] for row in s.mass])
            h = [of(x) for x in s.loads]
        else:
            T, V = of(s.kinetic), of(s.potential)
            p = [sp.diff(T, x) for x in v]
            M = sp.Matrix([[sp.diff(a, x) for x in v] for a in p])
            h = [
                of(s.forces.get(n, "0")) + sp.diff(T - V, x) - rate(a)
                for n, x, a in zip(s.coordinates, q, p, strict=True)
            ]
        self.n = len(v)
        gaps = [of(c.gap) for c in s.contacts]
        phi = [*gaps, *(of(c) for c in [*s.constraints, *s.latches])]
        rubs = [k for k, c in enumerate(s.contacts) if c.mu is not None]
        slips = [of(s.contacts[k].slip) for k in rubs] + [of(f.slip) for f in s.frictions]
        rows = [rate(x) for x in phi] + slips
        self.gaps, self.always = range(len(gaps)), range(len(gaps), len(phi) - len(s.latches))
        self.live: set[int] = set()  # latches that are on
        self.slips = range(len(phi), len(rows))
        self.rub = {len(phi) + i: k for i, k in enumerate(rubs)}
        self.tangent = {k: row for row, k in self.rub.items()}
        self.dry = {len(phi) + len(rubs) + i: i for i in range(len(s.frictions))}
        bounds = [x for f in s.frictions for x in (of(f.force), of(f.static or f.force))]
        energy = of(s.kinetic) + of(s.potential)
        self.parts, exprs = {}, []

        def part(name: str, values: list, shape: tuple) -> None:
            self.parts[name] = slice(len(exprs), len(exprs) + len(values)), shape
            exprs.extend(values)

        m = len(rows)
        part("M", [*M], (self.n, self.n))
        part("h", h, (self.n,))
        part("moves", [*moves], (len(q),))
        part("phi", phi, (len(phi),))
        part("rate", rows, (m,))
        part("J", [sp.diff(r, x) for r in rows for x in v], (m, self.n))
        part("gamma", [rate(r) for r in rows], (m,))
        part("bounds", bounds, (len(bounds) // 2, 2))
        part("switch", [of(x) for x in s.switches], (len(s.switches),))
        part("event", [of(e.value) for e in s.events], (len(s.events),))
        part("energy", [energy], ())
        self.function = sp.lambdify([t, *q, *v, *held, *cells], exprs, modules="math", cse=True)
        state = [*q, *v, *cells]
        self.after = [
            sp.lambdify(
                [t, *q, *v, *held, *cells],
                [of(e.then.get(n, str(x))) for n, x in self._named(s, rates, state)],
                modules="math",
            )
            for e in s.events
        ]
        self.sampled = sp.lambdify(
            [t, *q, *v, *held, *cells], [of(x) for _, x in s.cells.values()], modules="math"
        )
        self.nq, self.lost = len(q), [0.0] * len(gaps)

    @staticmethod
    def _named(s: System, rates: list[str], state: list) -> list[tuple]:
        return [*zip([*s.coordinates, *rates, *s.cells], state, strict=True)]

    @property
    def fixed(self) -> list[int]:
        return [*self.always, *(self.always.stop + k for k in sorted(self.live))]

    def at(self, t: float, s: np.ndarray) -> dict[str, np.ndarray]:
        flat = self.function(t, *s.tolist(), *self.held, *self.cells)
        p = {k: np.array(flat[w], float).reshape(shape) for k, (w, shape) in self.parts.items()}
        for k, e in enumerate(self.s.events):  # what turns a latch on does not happen while it is
            if e.on in self.live:
                p["event"][k] = self.sides[k]
        return p

    # accelerations and multipliers

    def solve(self, p: dict, equal: list[int], slides: dict[int, int]) -> tuple:
        """Returns accelerations and multipliers where rows `equal` hold and others slide."""
        J, h = p["J"], p["h"].copy()
        along = {r: J[r].copy() for r in equal}
        for row, side in slides.items():
            if row in self.dry:
                h -= side * p["bounds"][self.dry[row], 0] * J[row]
            elif (k := self.rub[row]) in along:
                along[k] -= side * self.s.contacts[k].mu * J[row]
        free = np.linalg.solve(p["M"], h)
        if not equal:
            return free, {}, False
        E = J[equal]
        W = np.linalg.solve(p["M"], np.array([along[r] for r in equal]).T)
        S, b = E @ W, -(E @ free + p["gamma"][equal])
        scale = np.sqrt(np.abs(np.einsum("ij,ji->i", E, np.linalg.solve(p["M"], E.T))))
        D = S / np.outer(scale, scale)
        if len(equal) > 1 and np.linalg.cond(D) > 1e9:
            y = np.linalg.lstsq(D, b / scale, rcond=1e-9)[0]
            if not np.allclose(D @ y, b / scale, atol=1e-9 * (1 + abs(b).max())):
                return None, {}, True
            lam, deficient = y / scale, True
        else:
            lam, deficient = np.linalg.solve(D, b / scale) / scale, False
        return free + W @ lam, dict(zip(equal, lam, strict=True)), deficient

    def settle(self, t: float, s: np.ndarray, touching: set[int], forced: dict[int, int]) -> None:
        """Finds which contacts stay closed and which slips stick; `forced` ones let go."""
        p = self.at(t, s)
        rate = p["rate"]
        closed, fixed_slips, free_slips = [], {}, []
        for k in sorted(touching):
            if abs(rate[k]) < CLOSE:
                closed.append(k)
            elif rate[k] < DOUBTFUL:
                raise Doubt("a contact hardly opens")
        for row in self.slips:
            if row in self.rub and self.rub[row] not in closed:
                continue
            if forced.get(row):
                fixed_slips[row] = forced[row]
            elif abs(rate[row]) < CLOSE or row in forced:
                free_slips.append(row)
            elif abs(rate[row]) < DOUBTFUL:
                raise Doubt("a slip is small")
            else:
                fixed_slips[row] = 1 if rate[row] > 0 else -1
        found = []
        ways = [(0,) if k in forced else (1, 0) for k in closed]
        sides = [(0, 1, -1)] * len(free_slips)
        for on in itertools.product(*ways):
            shut = [k for k, x in zip(closed, on, strict=True) if x]
            for which in itertools.product(*sides):
                pairs = dict(zip(free_slips, which, strict=True))
                live = {
                    r: x
                    for r, x in (fixed_slips | pairs).items()
                    if r in self.dry or self.rub[r] in shut
                }
                if any(r not in live and x for r, x in pairs.items()):
                    continue  # an open contact is tried once
                stuck = [r for r, x in live.items() if x == 0]
                slides = {r: x for r, x in live.items() if x}
                a, lam, deficient = self.solve(p, [*shut, *self.fixed, *stuck], slides)
                if a is None:
                    continue
                acc = p["J"] @ a + p["gamma"]
                slack = [lam[k] for k in shut]
                slack += [acc[k] for k in closed if k not in shut and k not in forced]
                for r in stuck:
                    slack.append(self.bound(p, r, lam) - abs(lam[r]))
                slack += [x * acc[r] for r, x in slides.items() if r in pairs]
                if all(x > -1e-9 for x in slack):
                    least = min(slack, default=1.0)
                    found.append((least, len(stuck), shut, slides, stuck, a, deficient))
        if not found:
            raise Doubt("no state of the contacts is consistent")
        found.sort(key=lambda x: -x[1])
        best = found[0]
        others = [x for x in found if abs(x[5] - best[5]).max() > 1e-7]
        if any(not {*x[4]} < {*best[4]} for x in others):
            raise Doubt("several states are consistent")
        if others and not self.s.frictions:
            raise Doubt("several states are consistent, without static friction")
        if best[0] < 1e-7:
            raise Doubt("a state is at its bound")
        _, _, self.shut, self.slides, self.stuck, _, self.deficient = best

    def bound(self, p: dict, row: int, lam: dict) -> float:
        if row in self.dry:
            return p["bounds"][self.dry[row], 1]
        k = self.rub[row]
        return self.s.contacts[k].mu * lam.get(k, 0.0)

    # impulses

    def linear(self, p: dict, b: np.ndarray, normals: list[int], ahead: dict[int, float]) -> tuple:
        """Returns impulses of the rows, such that 0 <= impulse and 0 <= rate b + A impulse of the
        normals, one of them 0; bounds of friction are those of the impulses `ahead` beside."""
        J = p["J"]
        A = J @ np.linalg.solve(p["M"], J.T)
        tangents = {k: self.tangent[k] for k in normals if k in self.tangent}
        found = []
        for on in itertools.product((1, 0), repeat=len(normals)):
            shut = [k for k, x in zip(normals, on, strict=True) if x]
            rubbing = [k for k in normals if k in tangents and (k in shut or ahead)]
            for which in itertools.product((0, 1, -1), repeat=len(rubbing)):
                side = dict(zip(rubbing, which, strict=True))
                stuck = [tangents[k] for k in rubbing if side[k] == 0]
                equal = [*shut, *self.fixed, *stuck]
                along = A.copy()  # the columns: impulses of the rows
                c = b.copy()
                for k, x in side.items():
                    if x:
                        mu = self.s.contacts[k].mu
                        along[:, k] -= x * mu * A[:, tangents[k]]
                        c -= x * mu * ahead.get(k, 0.0) * A[:, tangents[k]]
                D = along[np.ix_(equal, equal)]
                deficient = len(equal) > 0 and np.linalg.cond(D) > 1e9
                y = np.linalg.lstsq(D, -c[equal], rcond=1e-9)[0]
                rates = c + along[:, equal] @ y
                if len(equal) and abs(rates[equal]).max() > 1e-9 * (1 + abs(b).max()):
                    continue
                x = dict(zip(equal, y, strict=True))
                slack = [x[k] for k in shut] + [rates[k] for k in normals if k not in shut]
                for k in rubbing:
                    most = self.s.contacts[k].mu * (x.get(k, 0.0) + ahead.get(k, 0.0))
                    if side[k] == 0:
                        slack.append(most - abs(x[tangents[k]]))
                    else:
                        slack.append(side[k] * rates[tangents[k]])
                        x[tangents[k]] = -side[k] * most
                if all(z > -1e-10 for z in slack):
                    found.append((x, rates, deficient))
        if not found:
            raise Doubt("no impulse is consistent")
        first, rates, deficient = found[0]
        if any(abs(x[1] - rates).max() > 1e-8 for x in found):
            raise Doubt("several impulses are consistent")
        back = [k for k in normals if self.s.contacts[k].poisson and self.s.contacts[k].restitution]
        apart = any(abs(x[0].get(k, 0) - first.get(k, 0)) > 1e-8 for x in found for k in back)
        if back and (deficient or apart):
            raise Doubt("impulses that come back are not determined")
        return first

    def strike(self, t: float, s: np.ndarray, touching: set[int]) -> np.ndarray:
        p = self.at(t, s)
        normals, rate = sorted(touching), p["rate"]
        if any(CLOSE < abs(rate[k]) < DOUBTFUL for k in normals):
            raise Doubt("an impact grazes")
        if all(rate[k] > -CLOSE for k in normals) and all(abs(rate[k]) < CLOSE for k in self.fixed):
            return s
        if any(rate[k] > CLOSE for k in normals):
            raise Doubt("a contact opens while another closes")
        e = np.array([c.restitution for c in self.s.contacts])
        J = p["J"]
        A = J @ np.linalg.solve(p["M"], J.T)
        wanted = rate.copy()
        for k in normals:  # Newton's; a tangent's rate is not changed
            wanted[k] += e[k] * rate[k] * (not self.s.contacts[k].poisson)
        x = self.linear(p, wanted, normals, {})
        back = {k: e[k] * x.get(k, 0.0) for k in normals if self.s.contacts[k].poisson}
        if any(back.values()):
            b = wanted.copy()
            for impulses in (x, back):
                for k, y in impulses.items():
                    b = b + A[:, k] * y
            more = self.linear(p, b, normals, back)
            x = {k: x.get(k, 0.0) + back.get(k, 0.0) + more.get(k, 0.0) for k in {*x, *back, *more}}
        after = rate.copy()
        for k, y in x.items():
            after = after + A[:, k] * y
        for k, y in x.items():
            self.works(k, y * (rate[k] + after[k]) / 2)
        s = s.copy()
        s[self.nq :] += np.linalg.solve(p["M"], sum(J[k] * y for k, y in x.items()))
        return s

    def works(self, row: int, work: float) -> None:
        k = self.rub.get(row, row)
        if k in self.gaps:
            self.lost[k] -= work
