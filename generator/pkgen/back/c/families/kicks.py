"""C functions by which splitting methods kick and drift members (see members_steps.h)."""

from __future__ import annotations

from collections.abc import Iterator

from ....middle.families.indexed_ir import Group
from ..tree import Function, If, Loop, Node, Scope
from .readers import X, declared
from .rows import Rows, unused


def kick(rows: Rows) -> str:
    """Returns NAME_kick, which makes v += kappa a, q += delta v for the rows of a chunk."""
    body: list[Node] = ["ptrdiff_t k;", *rows.added_to("from", "from + n"), ""]
    first = f"from{rows.minus} + known"
    count = f"n + {rows.halo} - known" if rows.halo else "n - known"
    body += rows.fills(first, count, "e + known", rows.width)
    for number, g in enumerate(rows.of.families):
        values, (low, high) = rows.rows(g, rows.width), rows.clip(g)
        place = rows.place(g, "from")
        q, v = f"q[{place} + k]", f"v[{place} + k]"
        quotient = rows.of.finish == "QUOTIENT"
        a = f"({values[0]}) / ({values[1]})" if quotient else values[0]
        fused = rows.lane_loop(low, high, [f"{v} += kappa * ({a});", f"{q} += delta * {v};"])
        if not (rows.has_ends and quotient):
            body += fused
            body += _kicked_ends(rows, number, g) if rows.has_ends else ()
            continue
        a = "r[k] / r[PK_BLOCK + k]"
        slow = [f"pk_real r[{rows.of.outputs} * PK_BLOCK];", ""]
        slow += rows.buffered(number, values, low, high, "PK_BLOCK")
        slow += rows.lane_loop(low, high, [f"{v} += kappa * ({a});", f"{q} += delta * {v};"])
        body += [If("!n_added", [Scope(fused)]), If("n_added", [Scope(slow)])]
    args = "ptrdiff_t known, pk_real *e, pk_real kappa, pk_real delta, pk_real *q, pk_real *v"
    head = f"static void {rows.name}_kick({X}, ptrdiff_t from, ptrdiff_t n, {args})"
    body = [*declared(rows.model, body), *unused(("x", "known", "e"), body)]
    return Function(head, body).text + "\n"


def _kicked_ends(rows: Rows, number: int, g: Group) -> Iterator[Node]:
    """Yields the lines that kick single rows by what is added to their accelerations."""
    at = rows.place(g, "added[k].i")
    kicks = [
        "const pk_real kick = kappa * added[k].value;",
        "",
        f"v[{at}] += kick;",
        f"q[{at}] += delta * kick;",
    ]
    own = If(f"added[k].family == {number}", [Scope(kicks)])
    yield Loop("k = 0; k < n_added; k++", [own])


def drift(rows: Rows) -> str:
    """Returns NAME_drift, which makes q += delta v. Sets `kicks` of the rows: a struct pk_kicks."""
    body: list[Node] = ["ptrdiff_t k;", "", "(void)x;"]
    for g in rows.of.families:
        place, (low, high) = rows.place(g, "from"), rows.clip(g)
        body += rows.lane_loop(low, high, [f"q[{place} + k] += delta * v[{place} + k];"])
    args = "ptrdiff_t n, pk_real delta, pk_real *q, const pk_real *v"
    head = f"static void {rows.name}_drift({X}, ptrdiff_t from, {args})"
    text = Function(head, declared(rows.model, body)).text
    first, last = rows.range
    numbers = rows.chunk, rows.halo, rows.width, rows.values
    kicks = f"{rows.name}_kick, {rows.name}_drift, {first}, {last} + 1"
    rows.kicks = f"{{{kicks}, {', '.join(map(str, numbers))}}}"
    return text + "\n"
