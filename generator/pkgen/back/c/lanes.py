"""What lane kernels are made of: W states side by side, each an element of an array.

The acceleration is made in two parts: the angles that need no other sine or cosine, then the rest.
In lanes each part is a loop of its own: half the instructions between one turn's first and its
last, so that a processor works on several turns at once. Checks of parameters alone are the same
in all lanes: they stand after the loops.
"""

from __future__ import annotations

from collections.abc import Iterable

from ...record import record
from ..targets import CHECK, LOAD, LOCAL, TRIG
from .program import Kernel, Program, Statement

LANE_ARGUMENTS = (
    "const pk_real *t, const pk_real *q, const pk_real *v, const pk_real *u, pk_real *a"
)


@record
class LanePart:
    """Statements that are run together, the arguments that they read, and those they do not."""

    statements: tuple[Statement, ...]
    uses: tuple[str, ...]
    unused: tuple[str, ...]

    @staticmethod
    def of(statements: Iterable[Statement]) -> LanePart:
        """With those loads alone that the others read."""
        body = list(statements)
        words = _read(s for s in body if s.kind != LOAD)
        body = [s for s in body if s.kind != LOAD or s.target in words]
        words = _read(body)
        arguments = ("p", "t", "q", "v", "u")
        return LanePart(
            tuple(body),
            tuple(a for a in arguments if a in words),
            tuple(a for a in arguments if a not in words),
        )


def is_uniform(statement: Statement) -> bool:
    """A check of parameters alone."""
    return statement.kind == CHECK and _read([statement]) <= {"p"}


def lane_parts(kernel: Kernel) -> tuple[LanePart, LanePart, tuple[str, ...]]:
    """Leading angles; the rest; the names of the former's sines and cosines."""
    made = {x for s in kernel.statements if s.kind in (LOCAL, TRIG) for x in s.defines}
    leading = [s for s in kernel.statements if s.kind == TRIG and not made & _read([s])]
    loads = [s for s in kernel.statements if s.kind == LOAD]
    rest = [s for s in kernel.statements if s not in leading]
    pairs = tuple(name for s in leading for name in s.defines)
    return LanePart.of([*loads, *leading] if leading else []), LanePart.of(rest), pairs


def _read(statements: Iterable[Statement]) -> set[str]:
    return {name for s in statements for value in s.values for name in value.names}


def used_fields(program: Program, part: LanePart) -> list[tuple[str, int]]:
    """The members of struct NAME_params that it reads: C text and place."""
    places = {name: k for k, name in enumerate(program.parameter_names)}
    places |= {x.c_name: len(places) + k for k, x in enumerate(program.constants)}
    n, end = len(program.equations.coordinates), len(program.parameter_names)
    end += len(program.constants) + (n * n + n if program.factored else 0)
    places |= {f"side_[{k}]": end + k for k in range(len(program.equations.switches))}
    used = {read for s in part.statements for read in s.reads}
    return [(name, k) for name, k in places.items() if f"p->{name}" in used]
