"""Follows the solutions of a problem along its parameter, by pseudo-arclength: each correction is
orthogonal to the tangent of the branch, so that folds are passed like any other point.

Test functions that change their sign along a step say that a bifurcation lies there:

    a fold                the derivative of the parameter along the branch
    a branch point        det A of small motions, or of an orbit det(M - 1), without trivial factors
    a period doubling     det(M + 1)
    Hopf, torus           the growth of the oscillation that begins to grow

References: H. B. Keller, in: P. H. Rabinowitz (ed.), Applications of Bifurcation Theory (1977) 359;
E. Doedel, H. B. Keller, J. P. Kernevez, Int. J. Bifurcation and Chaos 1 (1991) 493 and 745.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy

from .problem import Node, Path, Problem, Seed

MOST_POINTS, MOST_BRANCHES = 1000, 24
EASY_ITERATIONS = 4  # after at most so many, steps become longer
FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 1e-2, 5e-2, 1e-6  # lengths of steps
CLOSED = "it is closed"
LEAST_COSINE = 0.9  # least cosine of the turn in a step
MOST_CORRECTION = 0.5  # largest correction of a step, in units of its length
# A point is on a branch if its distance from a chord is below SAME + BENT * chord^2.
SAME, BENT = 1e-4, 0.3
MOST_DOUBLINGS = 3


def _between(problem: Problem, a: Node, b: Node, f: Callable[[Node], float]) -> Node | None:
    """Returns the point of the branch between two nodes of one grid at which f changes its sign."""
    from scipy.optimize import brentq

    row = (b.x - a.x)[problem.of]
    length = numpy.linalg.norm(row)
    row = row / length

    def node(part: float) -> Node:
        x = a.x + part * (b.x - a.x)
        found = problem.correct(x, row, row @ x[problem.of])
        made = found and problem.node(found[0], problem.tangent(found[0], a.t))
        if made is None:
            raise ArithmeticError
        return made

    try:
        part = brentq(lambda s: f(node(s)), 0, 1, xtol=1e-12, rtol=1e-14, maxiter=80)
        return node(part)
    except (ArithmeticError, RuntimeError, ValueError):
        return None


def _events(problem: Problem, a: Node, b: Node) -> list[Node]:
    """Returns the special points between two nodes, in order."""
    found: list[Node] = []

    def look(kind: str, f: Callable[[Node], float]) -> bool:
        if f(a) * f(b) < 0 and (at := _between(problem, a, b, f)) is not None:
            at.kind = kind if kind != "fold" or problem.is_simple(at) else "branch point"
            found.append(at)
            return True
        return False

    real = 0
    one = 1.0 if problem.is_map else 0.0
    if look("fold", lambda n: n.rate):
        real += 1
    else:
        real += look("branch point", lambda n: problem.determinant(n.values, one))
    if problem.is_map:
        real += look("period doubling", lambda n: problem.determinant(n.values, -1.0))
    more = abs(problem.count_unstable(b.values) - problem.count_unstable(a.values))
    if more >= 2 and not (real and more == real):
        oscillates(problem, a, b, look)
    return sorted(found, key=lambda n: numpy.linalg.norm((n.x - a.x)[problem.of]))


def oscillates(problem: Problem, a: Node, b: Node, look: Callable) -> None:
    """Looks for an oscillation that begins to grow: Hopf's bifurcation, or of orbits a torus. Where
    each mode has one that decays as fast, two frequencies meet (M. G. Krein, 1950)."""
    back = [1 / n.values if problem.is_map else -n.values for n in (a, b)]
    before, after = map(problem.count_unstable, back)
    growing = [problem.count_unstable(n.values) for n in (a, b)]
    if (after - before) * (growing[1] - growing[0]) > 0:
        look("Krein collision", lambda n: problem.count_unstable(n.values) - sum(growing) / 2)
        return

    def nearest(n: Node) -> float:
        g = problem.growth(n.values[abs(n.values.imag) > 1e-9 * abs(n.values)])
        return float(g[abs(g).argmin()]) if g.size else math.nan

    kind = "torus" if problem.is_map else "hopf"
    if not (nearest(a) * nearest(b) < 0 and look(kind, nearest)):
        look(kind, lambda n: problem.count_unstable(n.values) - sum(growing) / 2)


def _followed_one_way(problem: Problem, begun: Node, first: numpy.ndarray, ends, *origin: Node):
    """Follows a branch from a node in direction `first`. Returns its nodes, its special points and
    why it ended. It is closed if it returns to `begun` or `origin`."""
    known = [begun, *origin]
    a = problem.node(begun.x, problem.tangent(begun.x, first))
    nodes, specials, length = [begun], [], FIRST_STEP * problem.unit
    lo, hi = ends
    while len(nodes) < MOST_POINTS:
        if length < SHORTEST_STEP * problem.unit:
            return nodes, specials, "Newton's method finds no further point"
        guess = a.x + length * a.t
        row = a.t[problem.of]
        found = problem.correct(guess, row, row @ guess[problem.of])
        t = None if found is None else problem.tangent(found[0], a.t)
        far = found is not None and _size((found[0] - guess)[problem.of]) > MOST_CORRECTION * length
        if t is None or far or t[problem.of] @ row < LEAST_COSINE:
            length /= 2
            continue
        b = problem.node(found[0], t)
        if b is None:
            length /= 2
            continue
        if why := problem.ends(a, b):
            return nodes, specials, why
        out = next((end for end in ends if not lo <= b.value <= hi and _apart(a, b, end)), None)
        if out is not None:
            b = _between(problem, a, b, lambda n, out=out: n.value - out) or b
        elif not lo <= b.value <= hi:
            return nodes, specials, "the range ends"
        events = _events(problem, a, b)
        specials += events
        nodes += [*events, b]
        if out is not None:
            return nodes, specials, "the range ends"
        most = 2 * length / problem.unit
        if len(nodes) > 12 and any(_size(problem.apart(node, b)) < most for node in known):
            return nodes, specials, CLOSED
        try:
            x, t = problem.settle(b.x, b.t)
        except ArithmeticError:
            return nodes, specials, "the grid does not resolve the orbit"
        a = problem.node(x, t) if x is not b.x else b
        easy = found[1] <= EASY_ITERATIONS and t[problem.of] @ row > 0.98
        length = min(LONGEST_STEP * problem.unit, length * (1.5 if easy else 1.0))
    return nodes, specials, f"after {MOST_POINTS} points"


def _apart(a: Node, b: Node, end: float) -> bool:
    return (a.value - end) * (b.value - end) < 0


def _size(x: numpy.ndarray) -> float:
    return float(numpy.linalg.norm(x))


def _is_on(path: Path, node: Node) -> bool:
    """Returns whether a point lies on a branch, or on the chord of two of its points."""
    for a, b in pairwise(path.nodes):
        to, along = (path.problem.apart(a, n) for n in (node, b))
        square = along @ along
        part = min(1.0, max(0.0, to @ along / square)) if square else 0.0
        if numpy.linalg.norm(to - part * along) < SAME + BENT * square:
            return True
    return False


def _both_ways(problem: Problem, seed: Node, ways: Sequence[numpy.ndarray | Node], ends, origin):
    """Returns the branch that goes on from a point in two directions, each a tangent, or a point
    beside a branch point."""
    halves = []
    for way in ways:
        beside = isinstance(way, Node)
        begun, first = (way, way.t) if beside else (seed, way)
        if halves and halves[0][2] == CLOSED:
            halves.append(([begun], [], CLOSED))
            break
        problem.at(begun)
        halves.append(_followed_one_way(problem, begun, first, ends, *([origin] if origin else [])))
    (back, before, first), (on, after, last) = halves
    middle = [*back[:0:-1], seed, *on[1:]] if origin is None else [*back[::-1], seed, *on]
    return Path(middle, [first, last], origin, problem, [*before[::-1], *after])


def _switched(problem: Problem, node: Node, ends: tuple[float, float]) -> Path | None:
    """Returns the other branch through a branch point, and gives this its name."""
    problem.at(node)
    other, ways = problem.aside(node), []
    if other is None:
        return None
    for sign in (-1, 1):
        made = problem.beside(node.x, sign * other)
        if made is None:
            return None
        ways.append(made)
    left, right = (way.value - node.value for way in ways)
    node.kind = "pitchfork" if left * right > 0 else "branch point"
    return _both_ways(problem, node, ways, ends, node)


def followed(seeds: Sequence[Seed], ends: tuple[float, float]) -> list[Path]:
    """Returns the branches through the seeds, and those that begin at their branch points and
    period doublings. The parameter is within `ends`."""
    paths: list[Path] = []
    looked = 0
    for seed in seeds:
        problem, node = seed.problem, seed.problem.at(seed.node)
        if any(_is_on(path, node) for path in paths if path.problem is problem):
            continue
        if seed.outward:
            paths.append(_outward(problem, node, ends, seed.origin))
        else:
            paths.append(_both_ways(problem, node, (-node.t, node.t), ends, None))
        while looked < len(paths) < MOST_BRANCHES:
            _begin(paths, paths[looked], ends)
            looked += 1
    return paths


def _outward(problem: Problem, node: Node, ends: tuple[float, float], origin: Node | None) -> Path:
    nodes, specials, last = _followed_one_way(problem, node, node.t, ends)
    first = [origin] if origin else []
    return Path([*first, *nodes], ["it begins here", last], origin, problem, specials)


def _begin(paths: list[Path], path: Path, ends: tuple[float, float]) -> None:
    """Adds the branches that begin at the special points of a branch."""
    for node in path.specials:
        others = [p for p in paths if p is not path and p.problem is path.problem]
        if node.kind == "branch point" and any(_is_on(p, node) for p in others):
            node.kind = ""  # it is on the other branch, too
        elif node.kind == "branch point":
            new = _switched(path.problem, node, ends)
            if new and not any(_is_on(p, new.nodes[-1]) for p in others):
                paths.append(new)
        elif node.kind == "period doubling" and path.problem.doublings < MOST_DOUBLINGS:
            begun = path.problem.at(node) and path.problem.doubled(node)
            if begun:
                paths.append(_outward(*begun, ends, node))
