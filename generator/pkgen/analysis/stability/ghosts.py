"""Ghosts: fixed points and 2-cycles of a method's step map that the equations do not have. One that
attracts is where a run ends that looks settled. Sought at steps over the map by deflated Newton
from many starts (orbits.py); that all are found cannot be promised.

Reference: A. Iserles, A. T. Peplow, A. M. Stuart, SIAM J. Numer. Anal. 28 (1991) 1723.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...record import record
from .ask import Asker
from .orbits import Orbit, closed

TRIES = {1: 24, 2: 16}  # starts, by the number of unknowns
MOST_UNKNOWNS = 4  # beyond, a search from few starts finds next to nothing
LOOKS, FEWER_LOOKS = 24, 8  # steps h at which they are sought
RUN, BESIDE = 4000, 1e-3  # steps that are run on from beside one, of what the motion covers
AWAY = 30  # times as far it has left


@record
class Ghost:
    """Those of one method and kind that were found at one step after the other."""

    method: str
    steps: int  # 1: a fixed point, 2: a 2-cycle
    holds: bool  # attracts, or is neutral: what is small stays so
    orbits: tuple[Orbit, ...]  # h ascending
    stays: bool | None  # a run from beside the middle one stays there; None: it does not hold

    @property
    def middle(self) -> Orbit:
        return self.orbits[len(self.orbits) // 2]

    @property
    def kind(self) -> str:
        return "fixed point" if self.steps == 1 else f"{self.steps}-cycle"


def ghosts(asker: Asker, method: str, hs: Sequence[float], quick: bool = False) -> list[Ghost]:
    """Of an autonomous model; none of one with more than MOST_UNKNOWNS."""
    found: dict[tuple[int, bool], list[Orbit]] = {}
    unknowns = asker.ask("orbits", method=method, h=hs[0], count=1)["unknowns"]
    if unknowns > MOST_UNKNOWNS:
        return []
    tries = TRIES.get(unknowns, 8)
    for h in hs[:: max(1, len(hs) // (FEWER_LOOKS if quick else LOOKS))]:
        for orbit in closed(asker, method=method, h=h, first=1, count=2, tries=tries):
            if not orbit.rests:
                found.setdefault((orbit.steps, orbit.holds), []).append(orbit)
    return [
        Ghost(method, steps, holds, tuple(orbits), _stays(asker, method, orbits) if holds else None)
        for (steps, holds), orbits in sorted(found.items())
    ]


def _stays(asker: Asker, method: str, orbits: list[Orbit]) -> bool:
    one = orbits[len(orbits) // 2]
    question = {"method": method, "h": one.h, "state": one.states[0]}
    two = asker.ask("beside", count=RUN, amplitude=BESIDE, **question)
    return two["status"] == "PK_DONE" and (two["growth"] or 0.0) < AWAY
