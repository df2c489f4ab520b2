"""Proposes particles at positions that have names in the model. The kinetic energy may have any
form.

A position r is a vector that a `let` defines, or consists of two or three coordinates, definitions
or outputs with matching names (bodies.py). The masses m follow from M = sum of m J^T J with
J = dr/dq (masses.py). particles.py proves the result.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...equations import Row
from ...graph.differentiate import gradient
from ...graph.graph import BIT, ZERO, Graph, Kind, Node
from ...indices import indexed
from ...record import record
from ...source import ModelError
from ..expand.expand import Expander
from ..expand.names import Value
from ..motion import Energies
from .bodies import Body, Key, NoParticles, keys, lengths, listed, places
from .masses import Entries, Given, Masses, masses_of

RATES, COORDINATES = BIT[Kind.RATE], BIT[Kind.COORDINATE]
# The largest numbers of positions and of coordinates. With more of them, the computation would take
# longer than a few seconds.
PLACES, COUNT = 100, 150
# The largest number of positions with the same J^T J that are tried for one particle.
ALIKE = 4


@record
class _Place:
    name: str
    at: Row  # The three components of the position r.
    square: Entries  # The matrix J^T J with J = dr/dq.


def proposals(x: Expander, energies: Energies, given: Given) -> list[list[Body]]:
    """Returns a list of proposals, each of which is a list of all particles of the model. The
    proposals have the same masses, but place these at different positions with equal J^T J. Raises
    NoParticles if no particles are found."""
    found = _named(x)
    if not found:
        raise NoParticles(
            "it names no place in a plane or in space, and a motion on a line turns about nothing"
        )
    if len(found) > PLACES or x.count > COUNT:
        raise NoParticles(
            f"its text is no sum of m/2*r'^2, and it has too many places ({len(found)}, of at most "
            f"{PLACES}) or coordinates ({x.count}, of {COUNT}) to look for one"
        )
    mass = _mass(x.graph, energies.lagrangian)
    if any(x.graph.depends[node] & RATES for node in mass.values()):
        raise NoParticles("its L is not of the second degree in the rates")
    for some in (found, [_flat(x.graph, place) for place in found]):
        made = masses_of(x.graph, mass, [place.square for place in some], given)
        if made is not None:
            return list(_bodies(some, made))
    names = tuple(place.name for place in found)
    raise NoParticles(
        f"its kinetic energy is no sum of m/2 r'^2 over places that it names, of {listed(names)}"
    )


def _named(x: Expander) -> list[_Place]:
    """Returns the positions with names, in the order of declaration. They depend on coordinates and
    not on rates."""
    single, vectors = {}, {}
    for name, index, value in _values(x):
        if isinstance(value, tuple):
            vectors[indexed(name, index)] = value
        else:
            single[indexed(name, index)] = value, tuple(keys(name, index))
    items: list[tuple[str, tuple[Key, ...]]] = [(n, known) for n, (_, known) in single.items()]
    order = list(single)
    groups = sorted(places(items), key=lambda group: min(map(order.index, group.values())))
    found = []
    for group in groups:
        at = tuple(single[group[axis]][0] if axis in group else ZERO for axis in range(3))
        found.append(_place(x.graph, f"({', '.join(group.values())})", at))
    found += [_place(x.graph, name, at) for name, at in vectors.items()]
    return [place for place in found if place.square]


def _values(x: Expander) -> Iterator[tuple[str, int | None, Value]]:
    """Yields (name, index, value) for all coordinates, definitions and outputs that are lengths and
    do not depend on rates."""
    known = lengths(x.model)
    for item in x.model.coordinates:
        family = x.coordinates[item.name]
        for index in family.members if item.name in known else ():
            yield item.name, index, x.coordinate(item.name, index, item.span)
    for item in (*x.model.definitions, *x.model.observed):
        if item.name not in known:
            continue
        try:
            with x.statement(item.span):
                members = [
                    (index, x.value(item.value, loop))
                    for index, loop in x.unrolled(item.index, item.range)
                ]
        except ModelError:  # the output contains energies or momenta, which are not derived yet
            continue
        for index, value in members:
            nodes = value if isinstance(value, tuple) else (value,)
            if not any(x.graph.depends[node] & RATES for node in nodes):
                yield item.name, index, value


def _place(g: Graph, name: str, at: Row) -> _Place:
    square: Entries = {}
    for component in at:
        moves = g.depends[component] & COORDINATES
        slopes = gradient(g, component, COORDINATES) if moves else {}
        row = sorted((g.data[q].index, slope) for q, slope in slopes.items() if slope != ZERO)
        for k, (i, a) in enumerate(row):
            for j, b in row[k:]:
                square[i, j] = g.add(square.get((i, j), ZERO), g.multiply(a, b))
    return _Place(name, at, {at: node for at, node in square.items() if node != ZERO})


def _flat(g: Graph, place: _Place) -> _Place:
    """Returns the position with 0 as third component. That the name of the third component matches
    the names of the other two may be a coincidence."""
    names = place.name.split(", ")
    if len(names) < 3:
        return place
    return _place(g, f"{', '.join(names[:2])})", (*place.at[:2], ZERO))


def _mass(g: Graph, lagrangian: Node) -> Entries:
    found: Entries = {}
    for v, momentum in gradient(g, lagrangian, RATES).items():
        for w, entry in gradient(g, momentum, RATES).items():
            i, j = g.data[v].index, g.data[w].index
            if i <= j and entry != ZERO:
                found[i, j] = entry
    return found


def _bodies(found: list[_Place], made: Masses) -> Iterator[list[Body]]:
    """Yields lists of particles: first with each mass at the first of its possible positions, then
    with each mass at the second, and so on."""
    most = max(len(alike) for alike, _ in made)
    for k in range(min(most, ALIKE)):
        chosen = [(found[alike[min(k, len(alike) - 1)]], mass) for alike, mass in made]
        yield [Body(mass, place.at, place.name) for place, mass in chosen]
