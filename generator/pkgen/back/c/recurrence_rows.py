"""Matrix rows of recurrences: X'' - sum Phi_z z'' = 0 for recurrence values X.

The sum is over the variables z that define X; Phi_z is the derivative of X by z. If M a = f of a
chain is not eliminated index by index, the accelerations X'' are unknowns of the band matrix, like
those of coordinates. Each X has a row of C, beside the constraint rows J:

K = [M + C^T W C C^T J^T; C 0 0; J 0 0]

Here X'' is only the part that is linear in the coordinates' accelerations; the rest is in the
forces. C^T W C does not change the solution x, since C x = 0. It makes each leading block of K
regular, even if coordinates have inertia through X only: M is positive on C x = 0, so M + C^T W C
is positive (P. Finsler, 1937). W has about the size of the inertia.
"""

from __future__ import annotations

from dataclasses import replace

from ...middle.loops.indexed_ir import Bound, Carried, Group, Row
from ...middle.loops.jacobians_recurrences import made
from ...middle.loops.loops import LoopEquations
from ...middle.loops.slots import Slots
from .loops import Places


def made_of(e: LoopEquations, places: Places, slots: Slots) -> tuple[Bound, ...]:
    """Returns the row of C for each recurrence value, in the order of computation."""
    return tuple(_row(e, item, places, slots) for item in e.carried)


def _row(e: LoopEquations, item: Carried, places: Places, slots: Slots) -> Bound:
    own, nothing = item.group, Row()
    group = Group(replace(own.declared, name=places.made[own.name]), own.lo, own.hi)
    sizes = nothing, nothing
    return Bound("", group, nothing, nothing, nothing, sizes, made(e, slots, item))
