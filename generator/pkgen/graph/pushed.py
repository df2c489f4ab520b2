"""Solves M a = f without computing M, by a reverse sweep over the graph of the Lagrangian.

M is the matrix of second derivatives of the Lagrangian by the rates. The sweep visits the nodes
from the Lagrangian down to the rates, and keeps the second derivatives by the live nodes, which are
arguments of visited nodes and not visited themselves. A rate is eliminated when it is visited: no
other live node depends on it. For a tree of links few nodes are live at a time, so that the work
is linear in the number of links; the sweep is then the articulated-body algorithm. The pivots are
those of M = L D L^T in the order of elimination.
References: R. Gower, M. Mello, A new framework for the computation of Hessians, Optimization
Methods and Software 27 (2012); R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from heapq import heappop, heappush

from ..record import record
from .differentiate import Forward, partials, reachable
from .graph import BIT, ONE, ZERO, Graph, Kind, Node, Op
from .solve import Row, Solution

RATES = BIT[Kind.RATE]
# The largest number of new nodes per rate. A link that moves in space takes 300 to 1,300 nodes;
# systems in which all coordinates are coupled take far more.
NODES = 2000


@record
class _Eliminated:
    """The equation of an eliminated rate: acceleration = (force - sum of coupling * tangent) *
    inverse. The sum is over the nodes that were live when the rate was eliminated. The tangent of a
    node is its derivative in the direction of the accelerations."""

    rate: Node
    inverse: Node
    force: Node
    couplings: Mapping[Node, Node]


class _Form:
    """A sparse symmetric matrix of second derivatives by the live nodes, and the force on each."""

    def __init__(self, g: Graph):
        self.graph = g
        self.rows: dict[Node, dict[Node, Node]] = {}
        self.forces: dict[Node, Node] = {}
        # The diagonal entries that the matrix would have without elimination. The size of a pivot
        # is compared with these.
        self.sizes: dict[Node, Node] = {}

    def add(self, a: Node, b: Node, value: Node) -> None:
        """Adds a value to the entries (a, b) and (b, a); once if a is b."""
        for row, column in {(a, b), (b, a)}:
            entries = self.rows.setdefault(row, {})
            entries[column] = self.graph.add(entries.get(column, ZERO), value)

    def push(self, node: Node, value: Node) -> None:
        self.forces[node] = self.graph.add(self.forces.get(node, ZERO), value)

    def grow(self, node: Node, value: Node) -> None:
        self.sizes[node] = self.graph.add(self.sizes.get(node, ZERO), value)

    def taken(self, node: Node) -> tuple[dict[Node, Node], Node, Node]:
        """Removes a live node from the matrix. Returns its row without the diagonal entry, its
        diagonal entry and its force."""
        row = self.rows.pop(node, {})
        diagonal = row.pop(node, ZERO)
        for other in row:
            del self.rows[other][node]
        live = {k: value for k, value in row.items() if value != ZERO}
        return live, diagonal, self.forces.pop(node, ZERO)

    def replace(self, node: Node, slopes: Mapping[Node, Node]) -> None:
        """Replaces a node in the matrix by its arguments; `slopes` are its derivatives by them."""
        g = self.graph
        row, diagonal, force = self.taken(node)
        size = self.sizes.pop(node, ZERO)
        items = list(slopes.items())
        for i, (a, p) in enumerate(items):
            for other, value in row.items():
                entry = g.multiply(value, p)
                self.add(a, other, g.add(entry, entry) if a == other else entry)
            if force != ZERO:
                self.push(a, g.multiply(force, p))
            self.grow(a, g.multiply(size, g.power(p, 2)))
            if diagonal != ZERO:
                scaled = g.multiply(diagonal, p)
                for b, s in items[i:]:
                    self.add(a, b, g.multiply(scaled, s))

    def eliminate(self, rate: Node, pivot: Node, inverse: Node) -> _Eliminated:
        g = self.graph
        row, _, force = self.taken(rate)
        items = list(row.items())
        for i, (a, entry) in enumerate(items):
            scaled = g.negate(g.multiply(entry, inverse))
            self.push(a, g.multiply(scaled, force))
            for b, other in items[i:]:
                self.add(a, b, g.multiply(scaled, other))
        return _Eliminated(rate, inverse, force, row)


def pushed(g: Graph, lagrangian: Node, rates: Row, force: Row) -> Solution | None:
    """Returns the accelerations and the pivots; None if a function call depends on rates, a pivot
    vanishes, or the sweep makes too many nodes."""
    order = reachable(g, [lagrangian], RATES)
    if not set(rates) <= set(order) or any(g.op[node] is Op.CALL for node in order):
        return None
    form, bars = _Form(g), {lagrangian: ONE}
    for rate, value in zip(rates, force, strict=True):
        form.push(rate, value)
    steps: list[_Eliminated] = []
    most = len(g) + NODES * len(rates)
    pivots: dict[Node, tuple[Node, Node]] = {}
    for node in _from_the_leaves(g, order):
        if len(g) > most:
            return None
        if g.op[node] is not Op.SYMBOL:
            _sweep(form, node, bars)
            continue
        pivot = form.rows.get(node, {}).get(node, ZERO)
        if pivot == ZERO:
            return None
        pivots[node] = pivot, form.sizes.pop(node, ZERO)
        steps.append(form.eliminate(node, pivot, g.power(pivot, -1)))
    return Solution(_backward(g, steps, rates), tuple(pivots[rate] for rate in rates))


def _from_the_leaves(g: Graph, order: list[Node]) -> Iterator[Node]:
    """Yields each node after all nodes that use it. A node with at most one argument comes as soon
    as possible, since it does not increase the number of live nodes. Other nodes come in the order
    of the depth of their rates, outermost first."""
    arguments = {node: {a for a in g.args[node] if g.depends[a] & RATES} for node in order}
    users = Counter(a for node in order for a in arguments[node])
    outermost = _outermost(order, arguments)
    heap = [(False, 0, -node) for node in order if not users[node]]
    while heap:
        node = -heappop(heap)[-1]
        yield node
        for a in arguments[node]:
            users[a] -= 1
            if not users[a]:
                several = len(arguments[a]) > 1
                heappush(heap, (several, -outermost[a] if several else 0, -a))


def _outermost(order: list[Node], arguments: Mapping[Node, set[Node]]) -> dict[Node, int]:
    """Returns for each node the largest depth among the rates in it. The depth of a rate: consider
    the nodes that combine this rate with other rates; the depth is the least number of rates in
    such a node."""
    below: dict[Node, int] = {}  # the rates that a node depends on, one bit each
    out: dict[int, int] = {}
    for node in order:
        below[node] = 0 if arguments[node] else 1 << len(below)
        for a in arguments[node]:
            below[node] |= below[a]
        count = below[node].bit_count()
        for a in arguments[node]:
            if below[a].bit_count() == 1 < count:
                out[below[a]] = min(out.get(below[a], count), count)
    found: dict[Node, int] = {}
    for node in order:
        own = out.get(below[node], 1)
        found[node] = max((found[a] for a in arguments[node]), default=own)
    return found


def _sweep(form: _Form, node: Node, bars: dict[Node, Node]) -> None:
    """Visits one node. The chain rule passes its row and column in the matrix of the form, and its
    adjoint in `bars`, on to its arguments."""
    g = form.graph
    slopes: dict[Node, Node] = {}
    for a, p in zip(g.args[node], partials(g, node), strict=True):
        if g.depends[a] & RATES:
            slopes[a] = g.add(slopes.get(a, ZERO), p)
    form.replace(node, slopes)
    bar = bars.pop(node, ZERO)
    if bar == ZERO:
        return
    for a, p in slopes.items():
        bars[a] = g.add(bars.get(a, ZERO), g.multiply(bar, p))
    if g.op[node] is Op.MULTIPLY and slopes.keys() == set(g.args[node]):
        a, b = g.args[node]
        form.add(a, b, bar if a != b else g.add(bar, bar))
        if a == b:
            form.grow(a, bar)
    elif g.op[node] is Op.POWER:
        (a,), n = g.args[node], g.data[node]
        bend = g.multiply(g.number(n * (n - 1)), g.power(a, n - 2))
        form.add(a, a, g.multiply(bar, bend))
        form.grow(a, g.multiply(bar, bend))


def _backward(g: Graph, steps: list[_Eliminated], rates: Row) -> Row:
    """Returns the accelerations by back-substitution, starting with the rate eliminated last."""
    known: dict[Node, Node] = {}
    moves = Forward(g, RATES, known.__getitem__)
    for step in reversed(steps):
        value = step.force
        for live, coupling in step.couplings.items():
            value = g.subtract(value, g.multiply(coupling, moves(live)))
        known[step.rate] = g.multiply(value, step.inverse)
    return tuple(known[rate] for rate in rates)
