"""Formats nodes of the expression graph as formulas in the model's names.

Each formula is in the shortest of several forms. Long or repeated subexpressions get names.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from pkgen.equations import Equations, Quantity
from pkgen.graph.differentiate import reachable
from pkgen.graph.graph import Graph, Kind, Node, Op, Symbol
from pkgen.middle.analyze.sympy_bridge import to_sympy
from pkgen.middle.quantities import single_rotations
from pkgen.record import record
from pkgen.tree import AXES

from . import mathml
from .mathml import row
from .shortest import shortest
from .typeset import Typesetter

if TYPE_CHECKING:
    import sympy

WHOLE = 100  # A formula is short if it has at most this many operations.
AGAIN = 5  # Fewest operations of a repeated subexpression that gets a name.
# In short formulas a subexpression gets a name only if that saves this many operations in total.
OFTEN = 20
PART = 40  # A subexpression that occurs once gets a name if it has more operations than this.
NAMED = 24  # A formula that needs more names than this is not shown.
_LETTERS = "ABCDFGKPSUWXYZ"

Chunks = list[str]


@record
class Where:
    """Formulas, and the definitions of the names in them. If the formulas are too long to be shown,
    only their number of `operations` is given."""

    formulas: tuple[Chunks, ...]
    named: tuple[Chunks, ...] = ()
    operations: int = 0


class Shown:
    """The formulas of one model."""

    def __init__(self, e: Equations):
        self.e = e
        self.rotations = rotations = single_rotations(e.model)
        self.lone = rotations[0].name if len(rotations) == 1 else ""
        parameters = [slot.quantity for slot in e.parameters]
        self.names = {
            Kind.PARAMETER: [q.name for q in parameters],
            Kind.COORDINATE: [q.name for q in e.coordinates],
            Kind.RATE: [q.name for q in e.rates],
            Kind.INPUT: [q.name for q in e.inputs],
            Kind.MOMENTUM: [q.name for q in e.momenta_names],
            Kind.TIME: ["t"],
            Kind.STATE: [q.name for q in e.states],
        }
        constants = sorted(parameters, key=_kind_of)
        variables = [
            x for kind, names in self.names.items() if kind != Kind.PARAMETER for x in names
        ]
        order = [q.name for q in constants] + variables
        self.turns = self._entries()
        order += sorted({s.name for entry in self.turns.values() for s in entry.free_symbols})
        order += [f"{q.name}'" for q in e.rates]
        order += [q.name for q in e.constraints.names] if e.constraints else []
        self.order = {name: k for k, name in enumerate(order)}
        self.constants = frozenset(q.name for q in parameters)
        self.typeset = Typesetter(self.order, self.constants, self.name)
        self.taken = {*self.order, *(x.name for x in e.observed_names), "t"}

    def name(self, name: str) -> str:
        return mathml.name(name, self.lone)

    # -- expressions --------------------------------------------------------------------------

    def expressions(
        self, nodes: Sequence[Node], given: Mapping[Node, sympy.Expr] | None = None
    ) -> list[sympy.Expr]:
        import sympy as sp

        def symbol(s: Symbol) -> sympy.Expr:
            return sp.Symbol(self.names[s.kind][s.index])

        def shortened(made: sympy.Expr) -> sympy.Expr:
            return self.turns.get(made, made)

        return to_sympy(self.e.graph, nodes, symbol, shortened if self.turns else None, given)

    def chunks(self, left: str, expr: sympy.Expr, relation: str = "=") -> Chunks:
        """Returns a formula as chunks; a line may break between two chunks."""
        first, *others = self.typeset.terms(expr)
        return [row(left, mathml.binary(relation), first), *others]

    def formula(self, expr: sympy.Expr) -> sympy.Expr:
        return shortest(expr, self.constants, self.typeset, self._by_entries(expr))

    def _by_entries(self, expr: sympy.Expr) -> list[sympy.Expr]:
        """Returns a list with the form of `expr` in which entries of rotation matrices replace
        products of quaternion components; an empty list if there is no such form."""
        import sympy as sp

        made = expr
        for rotation in self.rotations:
            quaternion = list(map(sp.Symbol, rotation.quaternion))
            if made.free_symbols.isdisjoint(quaternion) or not made.is_polynomial(*quaternion):
                continue
            terms = sp.Poly(made, *quaternion).terms()
            if all(sum(powers) in (0, 2) for powers, _ in terms):
                made = sp.Add(*(c * _form(rotation.name, powers) for powers, c in terms))
        return [] if made == expr else [sp.expand(made)]

    def _entries(self) -> dict[sympy.Expr, sympy.Expr]:
        """Maps polynomials in quaternion components to entries of rotation matrices. The negative
        of each polynomial is mapped too, and so is its half if it has a factor of two."""
        import sympy as sp

        found: dict[sympy.Expr, sympy.Expr] = {}
        for rotation in self.rotations:
            known = {q.name for q in self.e.states}
            if not known.issuperset(rotation.quaternion):
                continue
            w, x, y, z = map(sp.Symbol, rotation.quaternion)
            for i, a in enumerate((x, y, z)):
                for j, b in enumerate((x, y, z)):
                    entry = sp.Symbol(f"{rotation.name}.{AXES[i]}{AXES[j]}")
                    if i == j:
                        others = [c**2 for c in (x, y, z) if c != a]
                        value, times = w**2 + a**2 - sp.Add(*others), 1
                    else:
                        (c,) = {x, y, z} - {a, b}
                        sign = 1 if (j - i) % 3 == 2 else -1
                        value, times = a * b + sign * w * c, 2
                    found[value], found[-value] = entry / times, -entry / times
                    if times == 2:
                        found[2 * value], found[-2 * value] = entry, -entry
        return found

    # -- formulas with named subexpressions ----------------------------------------------------

    def where(self, rows: Sequence[tuple[str, Node]]) -> Where:
        """Returns the formulas LEFT = EXPRESSION of `rows`, and the definitions of names for
        subexpressions of the formulas."""

        def made(values: list[sympy.Expr]) -> list[Chunks]:
            return [
                self.chunks(left, self.formula(x))
                for (left, _), x in zip(rows, values, strict=True)
            ]

        return self.made_of([node for _, node in rows], made)

    def made_of(
        self, nodes: Sequence[Node], made: Callable[[list[sympy.Expr]], list[Chunks]]
    ) -> Where:
        """Calls `made` with the expressions of the nodes, in which names replace long or repeated
        subexpressions. Returns the formulas that `made` returns, and the definitions of these
        names."""
        chosen, size = self._chosen(nodes)
        if len(chosen) > NAMED:
            return Where((), operations=size)
        import sympy as sp

        names = [sp.Symbol(n) for n in self._letters(len(chosen))]
        self.taken |= {x.name for x in names}
        given = dict(zip(chosen, names, strict=True))
        formulas = made(self.expressions(nodes, given))
        named = []
        for node, name in given.items():
            others = {k: v for k, v in given.items() if k != node}
            (value,) = self.expressions([node], others)
            named.append(self.chunks(mathml.name(name.name), self.formula(value)))
        return Where(tuple(formulas), tuple(named))

    def _chosen(self, nodes: Sequence[Node]) -> tuple[list[Node], int]:
        """Returns the nodes that get names, in order of dependence, and the number of operations of
        all nodes."""
        g = self.e.graph
        order = reachable(g, nodes)
        entries, odd = self._nodes_of_entries(order), self._odd(order)
        uses = Counter(a for n in order if n not in entries for a in g.args[n])
        uses.update(nodes)
        written, size = {}, {}
        chosen = []
        for n in order:
            atom = n in entries or not g.args[n]
            written[n] = 0 if atom else 1 + sum(written[a] for a in g.args[n])
        whole = sum(written[n] for n in nodes)
        short = whole <= 3 * WHOLE and all(written[n] <= WHOLE for n in nodes)
        for n in order:
            atom = n in entries or not g.args[n]
            size[n] = 0 if atom else 1 + sum(size[a] for a in g.args[n])
            again = uses[n] > 1 and size[n] >= AGAIN and not _is_multiple(g, n)
            again = again and n not in odd
            if short:
                again = again and (uses[n] - 1) * size[n] >= OFTEN
            long = not short and size[n] > PART and n not in nodes
            if not atom and (again or long):
                chosen.append(n)
                size[n] = 0
        return chosen, whole

    def _nodes_of_entries(self, order: Iterable[Node]) -> frozenset[Node]:
        if not self.turns:
            return frozenset()
        order = list(order)
        made = self.expressions(order)
        names = {s for entry in self.turns.values() for s in entry.free_symbols}
        return frozenset(
            n for n, x in zip(order, made, strict=True) if x.as_coeff_Mul()[1] in names
        )

    def _odd(self, order: Iterable[Node]) -> set[Node]:
        """Returns the nodes that change sign with a quaternion; the sign of a quaternion is
        arbitrary."""
        g, numbers, found = self.e.graph, self.e.quaternions, set()
        for n in order:
            odd = [a in found for a in g.args[n]]
            if g.op[n] is Op.SYMBOL:
                symbol = g.data[n]
                odd = [symbol.kind is Kind.STATE and symbol.index < numbers]
            is_odd = sum(odd) % 2 == 1 if g.op[n] is Op.MULTIPLY else any(odd)
            if g.op[n] is Op.POWER:
                is_odd = is_odd and g.data[n] % 2 == 1
            if is_odd and g.op[n] is not Op.CALL:
                found.add(n)
        return found

    def _letters(self, count: int) -> list[str]:
        free = [x for x in _LETTERS if x not in self.taken]
        if count <= len(free):
            return free[:count]
        letter = next(
            x for x in "uscwz" if not any(n.rstrip("'0123456789") == x for n in self.taken)
        )
        return [f"{letter}{k}" for k in range(1, count + 1)]


def _form(rotation: str, powers: tuple[int, ...]) -> sympy.Expr:
    """Returns a product of two quaternion components as an expression in the entries of the
    rotation matrix."""
    import sympy as sp

    entry = {a + b: sp.Symbol(f"{rotation}.{a}{b}") for a in AXES for b in AXES}
    trace = entry["xx"] + entry["yy"] + entry["zz"]
    names = "".join(name * power for name, power in zip("wxyz", powers, strict=True))
    match names:
        case "":
            return sp.Integer(1)
        case "ww":
            return (1 + trace) / 4
        case "wx":
            return (entry["zy"] - entry["yz"]) / 4
        case "wy":
            return (entry["xz"] - entry["zx"]) / 4
        case "wz":
            return (entry["yx"] - entry["xy"]) / 4
    a, b = names
    return (1 + 2 * entry[a + a] - trace) / 4 if a == b else (entry[a + b] + entry[b + a]) / 4


def _is_multiple(g: Graph, node: Node) -> bool:
    """Whether the node is a number times another node; such a product needs no name."""
    return g.op[node] is Op.MULTIPLY and any(g.op[a] is Op.NUMBER for a in g.args[node])


def _kind_of(quantity: Quantity) -> int:
    """Returns a parameter's rank in a product: masses first, then g, then all others."""
    letters = quantity.name.rstrip("0123456789_")
    return 0 if letters == "m" or quantity.unit == "kg" else 1 if letters == "g" else 2
