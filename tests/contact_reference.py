"""Motions with contacts, from event to event by SciPy: impacts, multipliers and friction are found
by trying all states of the few contacts, as textbooks define them."""

from __future__ import annotations

import bisect
import itertools
import re
from dataclasses import dataclass, field

import numpy as np
import sympy as sp
from scipy.integrate import DOP853, solve_ivp
from scipy.optimize import brentq

CLOSE = 1e-9  # what is 0
DOUBTFUL = 1e-6  # what may be 0
SHORT = 2e-3  # flights that accumulate


class Doubt(Exception):
    """What follows is not determined, or not to the accuracy of the comparison."""


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


class Motion:
    """The functions of a system, and its motion."""

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

    # the motion

    def rhs(self, t: float, s: np.ndarray) -> np.ndarray:
        p = self.at(t, s)
        a, _, _ = self.solve(p, [*self.shut, *self.fixed, *self.stuck], self.slides)
        return np.concatenate([p["moves"], a])

    def watched(self, t: float, s: np.ndarray) -> dict[tuple, float]:
        """Functions that are positive as long as nothing happens."""
        p = self.at(t, s)
        found = {}
        if self.shut or self.stuck:
            _, lam, _ = self.solve(p, [*self.shut, *self.fixed, *self.stuck], self.slides)
        for k in self.gaps:
            if k in self.shut:
                found["opens", k] = lam[k]
            else:
                found["hits", k] = p["phi"][k]
        for row in self.stuck:
            found["slips", row] = self.bound(p, row, lam) - abs(lam[row])
        for row, side in self.slides.items():
            found["sticks", row] = side * p["rate"][row]
        for k, value in enumerate(p["switch"]):
            found["switch", k] = (1 if self.held[k] else -1) * value
        for k, value in enumerate(p["event"]):
            found["event", k] = self.sides[k] * value
        return found

    def straight(self, t: float, s: np.ndarray) -> np.ndarray:
        """Puts a state onto the rows that hold."""
        holonomic, all_rows = [*self.shut, *self.fixed], [*self.shut, *self.fixed, *self.stuck]
        s = s.copy()
        for _ in range(2):
            p = self.at(t, s)
            J = p["J"]
            if holonomic and self.nq == self.n:
                W = np.linalg.solve(p["M"], J[holonomic].T)
                s[: self.nq] -= W @ np.linalg.lstsq(J[holonomic] @ W, p["phi"][holonomic], 1e-9)[0]
        p = self.at(t, s)
        if all_rows:
            J = p["J"][all_rows]
            W = np.linalg.solve(p["M"], J.T)
            s[self.nq :] -= W @ np.linalg.lstsq(J @ W, p["rate"][all_rows], 1e-9)[0]
        return s

    def begin(self, t: float, s: np.ndarray, touching: set[int], forced: dict[int, int]):
        s = self.strike(t, s, touching)
        p = self.at(t, s)
        self.held = [
            old if abs(x) < 1e-9 else int(x > 0)
            for old, x in zip(self.held, p["switch"], strict=True)
        ]
        if any(
            abs(x) > DOUBTFUL and (x > 0) != (y > 0)
            for x, y in zip(p["event"], self.sides, strict=False)
        ):
            raise Doubt("an impact jumps across an event")
        self.settle(t, s, touching, forced)
        return self.straight(t, s)

    def run(self, start: list[float], until: float, times: np.ndarray, most: int = 400):
        """Returns the states at `times` as far as they are determined, the time up to which they
        are, why no further, and what happened. A state at the time of an event is left out."""
        t, s = 0.0, np.array(start)
        self.cells = [value for value, _ in self.s.cells.values()]
        self.held: list[int] = [0] * len(self.s.switches)
        self.lost = [0.0] * len(self.gaps)
        self.live = set(range(len(self.s.latches) if self.s.on else 0))
        self.sides = [1] * len(self.s.events)
        self.shut, self.stuck, self.slides = [], [], {}
        rows, log, last = [], [], {}
        samples = 0
        try:
            p = self.at(t, s)
            self.held = [int(x > 0) for x in p["switch"]]
            if self.s.period:
                self.cells, samples = self.sample(t, s), 1
            p = self.at(t, s)
            if any(p["phi"][k] < -1e-12 for k in self.gaps):
                raise Doubt("violated at the start")
            near = {k for k in self.gaps if p["phi"][k] < DOUBTFUL}
            if any(p["phi"][k] > CLOSE for k in near):
                raise Doubt("near at the start")
            self.sides = [1 if x > 0 else -1 for x in p["event"]]
            s = self.begin(t, s, near, {})
            while t < until and len(log) < most:
                end = min(until, samples * self.s.period) if self.s.period else until
                t, s, what, got = self.fly(t, s, end, times)
                rows += got
                if self.s.period and abs(t - samples * self.s.period) < 1e-12:
                    if what:
                        raise Doubt("an event at a sample")
                    self.cells, samples = self.sample(t, s), samples + 1
                    s = self.begin(t, s, {*self.shut}, {})
                    continue
                if what is None:
                    break
                log.append((t, *what))
                kind, k = what
                if log[:-1] and t - log[-2][0] < DOUBTFUL:
                    raise Doubt("two events are near each other")
                p = self.at(t, s)
                touching, forced = {*self.shut}, {}
                if kind == "hits":
                    if t - last.get(k, -1.0) < SHORT:
                        raise Doubt("impacts accumulate")
                    last[k] = t
                    touching.add(k)
                elif kind == "opens":
                    forced[k] = 0
                elif kind == "slips":
                    _, lam, _ = self.solve(p, [*self.shut, *self.fixed, *self.stuck], self.slides)
                    if self.deficient:
                        raise Doubt("which of several slips first")
                    forced[k] = -1 if lam[k] > 0 else 1
                elif kind == "sticks":
                    forced[k] = 0  # it is 0 now, and may stick or go on
                elif kind == "switch":
                    self.held[k] = 1 - self.held[k]
                elif kind == "event":
                    fires = self.sides[k] > 0 or not self.s.events[k].falling
                    self.sides[k] = -self.sides[k]
                    if fires:
                        event = self.s.events[k]
                        self.live = {*self.live, event.on} - {event.off, None}
                        s = self.reset(t, s, k) if event.then else s
                        p = self.at(t, s)
                        touching = {i for i in touching if abs(p["phi"][i]) < CLOSE}
                near = [i for i in self.gaps if i not in touching and p["phi"][i] < DOUBTFUL]
                if any(i not in self.shut for i in near):
                    raise Doubt("a gap is near")
                s = self.begin(t, s, touching, forced)
                self.leave(t, s)
        except Doubt as doubt:
            return rows, t, str(doubt), log
        return rows, t, "", log

    def leave(self, t: float, s: np.ndarray) -> None:
        """Finds to which side the function of an event leaves 0."""
        h = 1e-3 if any(e.off is not None for e in self.s.events) else 1e-6
        middle = self.rhs(t, s + h / 2 * self.rhs(t, s))
        value, ahead = self.at(t, s)["event"], self.at(t + h, s + h * middle)["event"]
        for k, x in enumerate(value):
            if abs(x) < DOUBTFUL:
                if abs(ahead[k] - x) < 1e-9:
                    raise Doubt("an event stays at 0")
                self.sides[k] = 1 if ahead[k] > x else -1

    def sample(self, t: float, s: np.ndarray) -> list[float]:
        return list(self.sampled(t, *s, *self.held, *self.cells))

    def reset(self, t: float, s: np.ndarray, k: int) -> np.ndarray:
        value = np.array(self.after[k](t, *s, *self.held, *self.cells), float)
        self.cells = [*value[len(s) :]]
        s = value[: len(s)]
        p = self.at(t, s)
        if any(abs(x) < DOUBTFUL for x in (*p["switch"], *np.delete(p["event"], k))):
            raise Doubt("a value after an event is at the next event")
        self.held = [int(x > 0) for x in p["switch"]]
        for i, x in enumerate(p["event"]):
            if abs(x) > DOUBTFUL:
                if i != k and (x > 0) != (self.sides[i] > 0):
                    raise Doubt("an event jumps across another")
                self.sides[i] = 1 if x > 0 else -1
        if any(p["phi"][i] < -CLOSE for i in self.gaps):
            raise Doubt("a value after an event violates a gap")
        if any(abs(p["phi"][i]) > CLOSE for i in self.fixed):
            raise Doubt("a value after an event breaks a constraint")
        return s

    def fly(self, t: float, s: np.ndarray, end: float, times: np.ndarray):
        """Integrates up to the next thing that happens."""
        begin, got = t, []
        solver = DOP853(
            self.rhs, t, s, end, first_step=min(1e-6, (end - t) / 2), max_step=0.03,
            rtol=1e-12, atol=1e-14,
        )  # fmt: skip
        armed: set[tuple] = set()
        before = self.watched(t, s)
        armed |= {k for k, x in before.items() if x > 1e-8}
        while solver.status == "running":
            solver.step()
            if solver.status == "failed":
                raise Doubt("SciPy fails")
            if abs(solver.y).max() > 100:
                raise Doubt("it runs away")
            flow = solver.dense_output()
            a = solver.t_old
            for b in np.linspace(solver.t_old, solver.t, 5)[1:]:
                now = self.watched(b, flow(b))
                hits = []
                for key, x in now.items():
                    if key not in armed:
                        if x > 1e-8:
                            armed.add(key)
                        elif x < -1e-8:
                            raise Doubt(f"{key} begins wrong")
                    elif x <= 0:

                        def of(u, key=key, flow=flow):
                            return self.watched(u, flow(u))[key]

                        at = brentq(of, a, b, xtol=1e-15, rtol=1e-15) if of(a) > 0 else a
                        hits.append((at, key))
                    elif key[0] == "hits" and x < 1e-3:
                        self.graze(key, flow, a, b)
                if hits:
                    at, key = min(hits)
                    if any(u - at < DOUBTFUL for u, k in hits if k != key):
                        raise Doubt("two things at once")
                    got += self.rows(flow, times, solver.t_old, at, begin)
                    return at, flow(at), key, got
                a = b
            got += self.rows(flow, times, solver.t_old, solver.t, begin)
        return solver.t, solver.y, None, got

    def graze(self, key: tuple, flow, a: float, b: float) -> None:
        def slope(u):
            return self.at(u, flow(u))["rate"][key[1]]

        if slope(a) < 0 < slope(b):
            u = brentq(slope, a, b, xtol=1e-13)
            if self.watched(u, flow(u))[key] < DOUBTFUL:
                raise Doubt("a contact is grazed")

    def rows(self, flow, times: np.ndarray, a: float, b: float, begin: float) -> list[tuple]:
        first, last = bisect.bisect_right(times, a), bisect.bisect_right(times, b)
        return [
            (i, flow(times[i]))
            for i in range(first, last)
            if times[i] - begin > 1e-7 and (b - times[i] > 1e-7 or b >= times[-1] - 1e-12)
        ]


def softened(motion: Motion, eps: float, start: list[float], times: np.ndarray) -> np.ndarray:
    """Returns the states of a smooth motion that has the one with contacts without restitution as
    its limit: walls are dampers of the force -gap'/eps, and friction is along -tanh(slip/eps)."""
    motion.cells, motion.held = [], []

    def rhs(t: float, s: np.ndarray) -> np.ndarray:
        p = motion.at(t, s)
        J, rate, h = p["J"], p["rate"], p["h"].copy()
        push = [max(0.0, -rate[k]) / eps * (p["phi"][k] < 0) for k in motion.gaps]
        for k, x in enumerate(push):
            h += x * J[k]
        for row in motion.slips:
            k = motion.rub.get(row)
            dry = k is None
            most = p["bounds"][motion.dry[row], 0] if dry else motion.s.contacts[k].mu * push[k]
            h -= most * np.tanh(rate[row] / eps) * J[row]
        return np.concatenate([p["moves"], np.linalg.solve(p["M"], h)])

    way = dict(method="Radau", rtol=1e-7, atol=1e-9, max_step=0.02)
    return solve_ivp(rhs, (0, times[-1]), start, t_eval=times, **way).y.T
