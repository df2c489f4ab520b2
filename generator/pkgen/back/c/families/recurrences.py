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

from ....middle.families.equations import FamilyEquations
from ....middle.families.indexed_ir import Addend
from ....middle.families.jacobians_recurrences import made
from .kernels import Builder, Kernel


def made_of(e: FamilyEquations, make: Builder) -> tuple[Kernel, ...]:
    """Returns the row of C for each recurrence value, in the order of computation. Its cells have
    the name ("made", name of the value)."""
    found = []
    for item in e.carried:
        name = item.group.name
        entries = [
            Addend(x.over, x.node, ((("made", name), x.to[0][1]), x.to[1]))
            for x in made(e, make.slots, item)
        ]
        found.append(make.kernel(f"made_{make.places.ids[name]}", [entries], short=False))
    return tuple(found)
