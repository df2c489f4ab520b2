"""What the templates see for lane kernels: W states side by side, each an element of an array.

The acceleration is made in two parts: the angles that need no other sine or cosine, then the rest.
In lanes each part is a loop of its own: half the instructions between one turn's first and its
last, so that a processor works on several turns at once. Checks of parameters alone are the same
in all lanes: they stand after the loops.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ...record import record
from . import tables
from .program import CHECK, LOAD, LOCAL, TRIG, Kernel, Program, Statement

_LANES = "const pk_real *t, const pk_real *q, const pk_real *v, const pk_real *u, pk_real *a"


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


def context(program: Program) -> dict[str, Any]:
    model = program.equations.model.name
    kernel = program.kernel("acceleration")
    angles, algebra, pairs = _parts(kernel) if kernel else (LanePart.of([]), LanePart.of([]), ())
    return {
        "lane_arguments": f"const struct {model}_params *p, {_LANES}",
        "member_arguments": f"const pk_real *P, {_LANES}",
        "angles": _seen(program, angles),
        "algebra": _seen(program, algebra),
        "pairs": list(pairs),
        "uniform": [s.text for s in algebra.statements if is_uniform(s)],
        "places": _places,
        "forms": list(program.lanes),
    }


def is_uniform(statement: Statement) -> bool:
    """A check of parameters alone."""
    return statement.kind == CHECK and _read([statement]) <= {"p"}


def _parts(kernel: Kernel) -> tuple[LanePart, LanePart, tuple[str, ...]]:
    """Leading angles; the rest; the names of the former's sines and cosines."""
    made = {x for s in kernel.statements if s.kind in (LOCAL, TRIG) for x in s.defines}
    leading = [s for s in kernel.statements if s.kind == TRIG and not made & _read([s])]
    loads = [s for s in kernel.statements if s.kind == LOAD]
    rest = [s for s in kernel.statements if s not in leading]
    pairs = tuple(name for s in leading for name in s.defines)
    return LanePart.of([*loads, *leading] if leading else []), LanePart.of(rest), pairs


def _seen(program: Program, part: LanePart) -> dict[str, Any]:
    statements = part.statements
    return {
        "groups": tables.groups(statements),
        "in_pass": int(any(s.kind in (CHECK, TRIG) for s in statements)),
        "uses": list(part.uses),
        "unused": list(part.unused),
        "fields": _used_fields(program, part),
    }


def _read(statements: Iterable[Statement]) -> set[str]:
    return {name for s in statements for value in s.values for name in value.names}


def _places(array: str, count: int) -> str:
    """q[0 * W + l], q[1 * W + l], ..."""
    return ", ".join(f"{array}[{i} * W + l]" for i in range(count))


def _used_fields(program: Program, part: LanePart) -> list[tuple[str, int]]:
    """The members of struct NAME_params that it reads: C text and place."""
    places = {name: k for k, name in enumerate(program.parameter_names)}
    places |= {f"c_[{k}]": len(places) + k for k in range(program.hoisted)}
    n, end = len(program.equations.coordinates), len(program.parameter_names)
    end += max(program.hoisted, 1) + (n * n + n if program.factored else 0)
    places |= {f"side_[{k}]": end + k for k in range(len(program.equations.switches))}
    used = {read for s in part.statements for read in s.reads}
    return [(name, k) for name, k in places.items() if f"p->{name}" in used]
