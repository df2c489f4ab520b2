"""Motions with contacts, from event to event by SciPy; their mechanics are contact_mechanics.py."""

from __future__ import annotations

import bisect

import numpy as np
from contact_mechanics import CLOSE, DOUBTFUL, SHORT, Doubt, Mechanics
from scipy.integrate import DOP853, solve_ivp
from scipy.optimize import brentq


class Motion(Mechanics):
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
