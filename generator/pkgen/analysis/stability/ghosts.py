"""Ghosts are spurious fixed points and 2-cycles of a method's step map: the equations have none
there. A run may converge to an attracting ghost and seem settled. Deflated Newton iteration from
many starts (orbits.py) searches them at several step sizes of the map; it may miss some.

Reference: A. Iserles, A. T. Peplow, A. M. Stuart, SIAM J. Numer. Anal. 28 (1991) 1723.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...record import record
from .ask import Asker
from .orbits import Orbit

# For each number of unknowns: the numbers of starts of Newton's method, of step sizes, and of step
# sizes of a quick map. Models with more than four unknowns would need too many starts.
EFFORT = {1: (24, 24, 8), 2: (16, 24, 8), 3: (4, 12, 4), 4: (4, 12, 4)}
RUN, BESIDE = 4000, 1e-3  # steps of a test run; its initial displacement from the ghost, in boxes
AWAY = 30  # a run has left the ghost if its displacement has grown by this factor


@record
class Ghost:
    """Spurious fixed points (or 2-cycles) of one method, attracting (or repelling) ones, that were
    found at successive step sizes."""

    method: str
    steps: int  # 1: a fixed point, 2: a 2-cycle
    holds: bool  # whether the spurious orbits are attracting or neutral
    orbits: tuple[Orbit, ...]  # in ascending step size
    stays: bool | None  # whether a run near `middle` stays there; None if not `holds`

    @property
    def middle(self) -> Orbit:
        return self.orbits[len(self.orbits) // 2]

    @property
    def kind(self) -> str:
        return "fixed point" if self.steps == 1 else f"{self.steps}-cycle"


def ghosts(asker: Asker, method: str, hs: Sequence[float], quick: bool = False) -> list[Ghost]:
    """Returns the ghosts of an autonomous model with up to four unknowns; none of other models."""
    asker = asker.with_settings(asker.settings)
    found: dict[tuple[int, bool], list[Orbit]] = {}
    unknowns = len(asker.unknowns.of)
    if unknowns not in EFFORT:
        return []
    tries, looks, fewer = EFFORT[unknowns]
    for h in hs[:: max(1, len(hs) // (fewer if quick else looks))]:
        for orbit in asker.orbits(method=method, h=h, first=1, count=2, tries=tries) or ():
            if not orbit.rests:
                found.setdefault((orbit.steps, orbit.holds), []).append(orbit)
    return [
        Ghost(method, steps, holds, tuple(orbits), _stays(asker, method, orbits) if holds else None)
        for (steps, holds), orbits in sorted(found.items())
    ]


def _stays(asker: Asker, method: str, orbits: list[Orbit]) -> bool:
    one = orbits[len(orbits) // 2]
    question = {"method": method, "h": one.h, "state": one.states[0]}
    status, growth, _ = asker.beside(count=RUN, amplitude=BESIDE, **question)
    return status == "PK_DONE" and growth < AWAY
