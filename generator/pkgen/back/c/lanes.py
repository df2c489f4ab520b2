"""The loops of kernels that compute W states at once, each state in one SIMD lane.

The acceleration has two loops over lanes. The first computes the sines and cosines of angles that
depend on no computed value, such as another sine; the second computes the rest. Two short loop
bodies let a processor overlap several iterations. Checks of parameters alone are the same in all
lanes and follow the loops.
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
    """The statements of one loop over lanes; the arguments of the function are divided into those
    that the statements use, and `unused` ones."""

    statements: tuple[Statement, ...]
    uses: tuple[str, ...]
    unused: tuple[str, ...]

    @staticmethod
    def of(statements: Iterable[Statement]) -> LanePart:
        """Returns the part with these statements, without loads of values that no other statement
        of the part reads."""
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
    """Returns whether the statement is a check of parameters alone."""
    return statement.kind == CHECK and _read([statement]) <= {"p"}


def lane_parts(kernel: Kernel) -> tuple[LanePart, LanePart, tuple[str, ...]]:
    """Returns the first loop (sines and cosines), the second loop, and the names of the variables
    that the first loop computes for the second."""
    made = {x for s in kernel.statements if s.kind in (LOCAL, TRIG) for x in s.defines}
    leading = [s for s in kernel.statements if s.kind == TRIG and not made & _read([s])]
    loads = [s for s in kernel.statements if s.kind == LOAD]
    rest = [s for s in kernel.statements if s not in leading]
    pairs = tuple(name for s in leading for name in s.defines)
    return LanePart.of([*loads, *leading] if leading else []), LanePart.of(rest), pairs


def _read(statements: Iterable[Statement]) -> set[str]:
    return {name for s in statements for value in s.values for name in value.names}


def used_fields(program: Program, part: LanePart) -> list[tuple[str, int]]:
    """Returns the members of struct NAME_params that a part reads: C text, and the index of the
    number in the struct."""
    places = {name: k for k, name in enumerate(program.parameter_names)}
    places |= {x.c_name: len(places) + k for k, x in enumerate(program.constants)}
    n, end = len(program.equations.coordinates), len(program.parameter_names)
    end += len(program.constants) + (n * n + n if program.factored else 0)
    places |= {f"side_[{k}]": end + k for k in range(len(program.equations.switches))}
    used = {read for s in part.statements for read in s.reads}
    return [(name, k) for name, k in places.items() if f"p->{name}" in used]
