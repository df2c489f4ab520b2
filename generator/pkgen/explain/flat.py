"""The contents of `explain` for a model whose families are unrolled: named expressions.

Small expressions are SymPy text, slightly simplified; for large ones, only the number of operations
is shown. `Rows` are names with their graph nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from ..back.c.program import operations_text
from ..back.facts import found
from ..compiler import Compilation
from ..equations import Equations, Quantity
from ..graph.graph import BIT, ZERO, Kind, Node
from ..indices import multiplied
from ..middle.analyze import sympy_bridge
from ..middle.derive.effective import NAME, NotReduced, written
from ..middle.structure import Structure
from .contents import Contents

Rows = list[tuple[str, Node]]
SHOWN_OPERATIONS = 300  # An expression with more operations is not shown.


def contents(compilation: Compilation) -> Contents:
    e, structure, program = compilation.equations, compilation.structure, compilation.program

    def text(node: Node) -> str:
        return sympy_bridge.text(e, node, SHOWN_OPERATIONS)

    def equal(rows: Iterable[tuple[str, Node]]) -> list[str]:
        return [f"{name} = {text(node)}" for name, node in rows]

    def named(rows: Iterable[tuple[str, Node]]) -> dict[str, str]:
        return {name: text(node) for name, node in rows}

    model = e.model
    families = any(c.range for c in (*model.coordinates, *model.states))
    kernels = [f"{k.name:<14} {operations_text(k.operations)}" for k in program.kernels]
    return Contents(
        e=e,
        text=text,
        freedom=", ".join(freedom(e)),
        declared=declared(e),
        parameters=e.parameters,
        equations=[
            ("Lagrangian", equal(lagrangian_rows(e))),
            ("Effective potential", _effective(compilation)),
            (_motion_title(e, structure), equal(motion_rows(e)) if e.coordinates else ()),
            (
                "Constraints   0 =, J their derivatives by the rates; and lambda =",
                _constraints(e, text),
            ),
            (rates_title(e), equal(rate_rows(e))),
            ("Canonical form   q' = dH/dp, p' = -dH/dq + Q", equal(canonical_rows(e))),
        ],
        outputs=[
            (q.name, q.unit, node, "")
            for q, node in (
                *zip(e.observed_names, e.observed, strict=True),
                *zip(e.conserved_names, e.conserved, strict=True),
            )
        ],
        families=[("families", f"unrolled: {e.unrolled}")] if families else [],
        costs=("Kernels", kernels),
        record={
            "coordinates": [vars(q) for q in e.coordinates],
            "parameters": [vars(p.quantity) for p in e.parameters],
            "lagrangian": text(e.lagrangian),
            "mass": [[*map(text, row)] for row in e.mass],
            "force": [*map(text, e.force)],
            "states": [
                {**vars(q), "rate": text(node)}
                for q, node in zip(e.states, e.state_rates, strict=True)
            ],
            "canonical": named(canonical_rows(e)),
            "conserved": [name for name, _ in found(e, structure)],
            "constraints": named(constraint_rows(e)),
            "operations": {k.name: dict(k.operations) for k in program.kernels},
        },
    )


def _effective(compilation: Compilation) -> list[str]:
    """Returns V_eff if some of the coordinates are cyclic, or have given way to their momenta."""
    e, proved = compilation.equations, compilation.structure.cyclic
    cyclic = [i for i, is_cyclic in enumerate(proved) if is_cyclic and i not in e.turning]
    if not (cyclic or compilation.report.starts) or len(cyclic) == len(e.coordinates):
        return []
    try:
        names, node = written(e, cyclic)
    except NotReduced as why:
        return [f"{NAME} is not known: {why}"]
    return [f"{NAME} = {sympy_bridge.text(names, node, SHOWN_OPERATIONS)}"]


def _motion_title(e: Equations, structure: Structure) -> str:
    nodes = [*e.force, *sum(e.mass, ())]
    of_states = any(e.graph.depends[node] & BIT[Kind.STATE] for node in nodes)
    time = ", x" * of_states + ("" if structure.autonomous else ", t")
    mass = "M" if structure.mass_constant else "M(q" if structure.quadratic else "M(q, q'"
    mass += "" if structure.mass_constant else f"{time})"
    force = "f(q" if structure.separable else "f(q, q'"
    bound = "" if e.constraints is None else " + J^T lambda"
    return f"Equations of motion   {mass} q'' = {force}{time}){bound}"


def _constraints(e: Equations, text: Callable[[Node], str]) -> list[str]:
    rows = list(constraint_rows(e))
    width = max((len(name) for name, _ in rows), default=0)
    lines = [f"{name:<{width}}  {text(node)}" for name, node in rows]
    return lines + [f"{name:<{width}}  follows: redundant" for name in redundant_names(e)]


def declared(e: Equations) -> list[tuple[str, tuple[Quantity, ...]]]:
    """Returns coordinates, angular velocities of bodies, attitudes and states, by kind."""
    return [
        ("Coordinates", e.seen),
        ("Body rates", e.rates[len(e.seen) :]),
        ("Attitudes", e.states[: e.quaternions]),
        ("States", e.states[e.quaternions :]),
    ]


def lagrangian_rows(e: Equations) -> Rows:
    if not e.coordinates:
        return []
    both = e.kinetic is not None and e.potential is not None
    return [("L", e.lagrangian), *([("T", e.kinetic), ("V", e.potential)] if both else [])]


def free_force(e: Equations) -> tuple[Node, ...]:
    """Returns the generalized forces without constraint forces."""
    return e.force if e.constraints is None else e.constraints.free_force


def motion_rows(e: Equations) -> Rows:
    """Returns rows for the equations M q'' = f: the nonzero entries in the lower triangle of the
    mass matrix M, then the entries of f."""
    names = e.moving
    rows = [
        (f"M[{names[i]}, {names[j]}]", row[j])
        for i, row in enumerate(e.mass)
        for j in range(i + 1)
        if row[j] != ZERO
    ]
    return rows + [(f"f[{x}]", node) for x, node in zip(names, free_force(e), strict=True)]


def rate_rows(e: Equations) -> Rows:
    return [(f"{q.name}'", node) for q, node in zip(e.states, e.state_rates, strict=True)]


def canonical_rows(e: Equations) -> Rows:
    """Returns H(q, p) and its gradients; nothing if the canonical form was not requested."""
    h = e.hamiltonian
    if h is None:
        return []
    gradients = zip((*e.coordinates, *e.momenta_names), (*h.by_q, *h.by_p), strict=True)
    return [("H", h.energy), *((f"dH/d({q.name})", node) for q, node in gradients)]


def rates_title(e: Equations) -> str:
    """Returns the heading of the first-order equations, such as "Rates of the attitudes and
    states"."""
    what = ["attitudes"] if e.quaternions else []
    what += ["states"] if len(e.states) > e.quaternions or not what else []
    return f"Rates of the {' and '.join(what)}"


def freedom(e: Equations) -> list[str]:
    """Returns counts such as "2 rates", "1 constraint", "1 degree of freedom"."""
    n, states, bound = len(e.coordinates), len(e.states) - e.quaternions, ()
    if (c := e.constraints) is not None:
        rows = len(c.names)
        bound = (n, "rates"), (c.holonomic, "constraint*"), (rows - c.holonomic, "rolling")
        bound += ((len(c.redundant_rows), "redundant row*"),)
        n -= rows
    free = (n, "degree* of freedom"), (len(e.attitudes), "rotation*"), (states, "state*")
    shown = (row for row in (*bound, *free) if row[0] or (row is free[0] and not states))
    return [f"{count} {what.replace('*', 's' * (count != 1))}" for count, what in shown]


def constraint_rows(equations: Equations) -> Iterator[tuple[str, Node]]:
    """Yields the constraint functions, the rates of the holonomic ones, and the multipliers."""
    c = equations.constraints
    if c is None:
        return
    names = [multiplied(q.name) for q in c.names]
    yield from zip(names, (*c.positions, *c.residual[c.holonomic :]), strict=True)
    yield from zip((f"{name}'" for name in names[: c.holonomic]), c.residual, strict=False)
    yield from zip((q.name for q in c.names), c.multipliers, strict=True)


def redundant_names(equations: Equations) -> list[str]:
    c = equations.constraints
    names = c.redundant.names if c is not None and c.redundant else ()
    return [multiplied(q.name) for q in names]
