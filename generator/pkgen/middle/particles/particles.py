"""Finds the particles of a model: masses m and positions r whose sum of m/2 |r'|^2 is its kinetic
energy.

Candidates come from the text of the energy (particles/text.py), or from positions that have names
in the model (particles/places.py). Each candidate is then proved. If L also has terms linear in the
rates, due to a rotating frame or a magnetic field, the sum has to give the terms of second degree.
Candidates that give all terms are preferred.
"""

from __future__ import annotations

from fractions import Fraction

from ...equations import Matrix, Particles
from ...graph.differentiate import Forward, gradient
from ...graph.exact import Exact
from ...graph.graph import BIT, VARIABLE, ZERO, Graph, Kind, Node, Symbol
from ..expand.expand import Expander
from ..motion import Energies
from . import places as particles_places
from .bodies import Body, NoParticles, listed
from .masses import Given
from .text import read

HELP = (
    "name the place of each particle, by let or observe, as x = l*sin(theta) and "
    "y = -l*cos(theta), so that the kinetic energy is the sum of their m/2*(x'^2 + y'^2); of a "
    "rigid body, record p_ANGLE"
)
LINEAR = (
    "L has other terms linear in the rates, as of a turning frame, in which r' is then measured, "
    "or of a magnetic field"
)
WITHOUT = (
    "the kinetic energy has other terms without rates, as of a turning frame, in which r' is then "
    "measured"
)


TURNING = "of a rotation, R*p_R is its angular momentum in space"


def particles_of(x: Expander, energies: Energies, given: Given) -> Particles:
    """Returns the particles of a model. If none are found, the result is empty and has the
    reason."""
    energy = next(iter((*x.model.kinetic, *x.model.lagrangian)), None)
    span = energy.span if energy else x.model.span
    if x.model.rotations:
        return Particles((), (), (), (), why=TURNING, span=span)
    found: list[Particles] = []
    refusals: list[NoParticles] = []
    # Polar coordinates are tried last: the origin from which they are measured may be another
    # particle, which is not known.
    for proposals in (
        lambda: [read(x, polar=False)],
        lambda: particles_places.proposals(x, energies, given),
        lambda: [read(x, polar=True)],
    ):
        try:
            for bodies in filter(None, proposals()):
                found.append(_proved(x, energies, bodies))
                if not found[-1].beyond:
                    return found[-1]
        except NoParticles as refusal:
            refusals.append(refusal)
    if found:
        return found[0]
    return Particles((), (), (), (), why=str(refusals[0]), span=span)


def _proved(x: Expander, energies: Energies, bodies: list[Body]) -> Particles:
    g = x.graph
    names = tuple(body.name for body in bodies)
    if any(g.depends[body.mass] & VARIABLE for body in bodies):
        raise NoParticles("a mass that varies is of no particle")
    again = Forward(g, VARIABLE, lambda node: _w(g, node) or x.derivative(node))
    places: Matrix = tuple(body.place for body in bodies)
    rates: Matrix = tuple(tuple(map(x.derivative, place)) for place in places)
    accelerations: Matrix = tuple(tuple(map(again, rate)) for rate in rates)
    half = g.number(Fraction(1, 2))
    total = g.sum(
        g.multiply(g.multiply(half, body.mass), g.power(component, 2))
        for body, rate in zip(bodies, rates, strict=True)
        for component in rate
    )
    beyond = _beyond(x, energies, total)
    if beyond is None:
        raise NoParticles(f"that T is the sum of m/2 r'^2 over {listed(names)} is not proved")
    masses = tuple(body.mass for body in bodies)
    return Particles(masses, places, rates, accelerations, names, beyond)


def _beyond(x: Expander, energies: Energies, total: Node) -> str | None:
    """Compares the energy with `total`, the sum of m/2 |r'|^2 over particles. Returns a text about
    the further terms of the energy, or "" if there are none. Returns None if `total` is not proved
    to be the part of the energy that has degree 2 in the rates."""
    g, kinetic = x.graph, energies.kinetic
    if kinetic is not None and _is_zero(g, g.subtract(total, kinetic)):
        return ""
    # The directional derivative w.d/dv, for any w, shows the degree of `rest` in the rates v. If
    # w.d/dv of `rest` is zero, the degree is 0. If only (w.d/dv)^2 of `rest` is zero, the degree is
    # 1.
    rest = g.subtract(total, energies.lagrangian if kinetic is None else kinetic)
    once = _along(x, rest)
    if not _is_zero(g, _along(x, once)):
        return None
    if not _is_zero(g, once):
        return LINEAR
    return "" if kinetic is None else WITHOUT


def _along(x: Expander, node: Node) -> Node:
    """Returns the directional derivative w.d/dv of a node by the rates v. The symbols of the
    accelerations serve as the components of the arbitrary vector w."""
    g = x.graph
    slopes = gradient(g, node, BIT[Kind.RATE]) if g.depends[node] & BIT[Kind.RATE] else {}
    return g.sum(g.multiply(_w(g, v), slope) for v, slope in slopes.items())


def _is_zero(g: Graph, node: Node) -> bool:
    return node == ZERO or Exact(g.copy()).is_zero(node)


def _w(g: Graph, node: Node) -> Node | None:
    """Returns the acceleration of a rate; None of another symbol."""
    kind, index = g.data[node]
    return g.symbol(Symbol(Kind.ACCELERATION, index)) if kind is Kind.RATE else None
