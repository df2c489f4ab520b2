"""Proves facts about a system of equations, such as a constant mass matrix. A fact that is False is
not proved; it may still hold.

Most proofs show that a symbol does not occur in an expression, either as written or in its normal
form, in which symbols may cancel: L of a bead on a hoop that turns with Omega t does not depend on
t. An expression that is too large has no normal form.
"""

from __future__ import annotations

from collections.abc import Iterable

from ...equations import Equations
from ...functions.row import COORDINATES
from ...graph.calls import expandable, jumps, smooth
from ...graph.differentiate import reachable, symbols_in
from ...graph.graph import BIT, VARIABLE, ZERO, Graph, Kind, Node
from ...graph.normal import WORK, Normal
from ...graph.residues import Varying
from ..points.squares import Positive, definite_by_squares
from ..structure import Structure
from .affine import CONSTANT, VARYING, affine, of_rates
from .coupling import atoms, blocks_of, influences, mass_band, mass_blocks, ties
from .proofs import claims_of

RATES = BIT[Kind.RATE]
STATES = BIT[Kind.STATE]
TIME_OR_INPUT = BIT[Kind.TIME] | BIT[Kind.INPUT]


def analyze(equations: Equations, symmetric: bool = False, with_claims: bool = False) -> Structure:
    """Returns all facts about the equations. Slow proofs are optional: with `symmetric`, constants
    of the motion by Noether's theorem; with `with_claims`, the proof of each `conserve`
    statement."""
    seen = _Seen(equations.graph)
    n = len(equations.coordinates)
    triangle = [equations.mass[i][j] for i in range(n) for j in range(i + 1)]
    constant = not seen.occurs(triangle, VARIABLE)
    bound = equations.constraints
    applied = equations.applied if bound is None else bound.free_applied
    unforced = all(node == ZERO for node in applied)
    of_motion = [equations.lagrangian, *applied]
    # If first-order variables occur in L or forces, the energy may vary. Quaternions are the
    # first-order variables with the lowest indices; they are positions and do not count.
    untouched = not seen.occurs(of_motion, STATES, equations.quaternions)
    steady = not seen.occurs(of_motion, TIME_OR_INPUT)
    kept = [] if bound is None else [*bound.positions, *bound.residual, *equations.applied]
    autonomous = steady and not seen.occurs([*equations.state_rates, *kept], TIME_OR_INPUT)
    moving = [*equations.force, *equations.state_rates]
    jumping = _jumping(equations)
    smooth = _smooth(equations) and not equations.impulsive
    coupled = mass_blocks(equations)
    influence = influences(equations, coupled)
    solvable = symmetric and n and untouched and not (jumping or equations.impulsive)
    whole = not equations.model.struck
    solvable = solvable and whole and not equations.attitudes and bound is None
    found = None
    if solvable:
        from .symmetries import symmetries  # a slow import

        found = symmetries(equations, coupled, influence)
    separable = constant and not seen.occurs(moving, RATES | STATES)
    of_v = of_rates(equations) if constant and not separable else 0
    return Structure(
        mass_constant=constant,
        mass_diagonal=mass_band(equations) == 0,
        quadratic=not seen.occurs(triangle, RATES),
        separable=separable,
        linear_drag=of_v == CONSTANT,
        affine_rates=of_v in (CONSTANT, VARYING),
        fast=separable and equations.fast is not None,
        autonomous=autonomous,
        conservative=whole
        and not jumping
        and (
            (_of_first_degree(equations) and autonomous)
            or (n > 0 and unforced and steady and untouched and (bound is None or bound.workless))
        ),
        variational=whole
        and n > 0
        and unforced
        and untouched
        and not equations.attitudes
        and bound is None,
        smooth=smooth,
        switched=not smooth
        and bool(equations.switches)
        and all(x.held for x in equations.switches),
        cyclic=_cyclic(equations, seen, jumping),
        affine=constant and autonomous and affine(equations, seen.normal),
        series=has_series(equations),
        definite=_definite(equations),
        # where M may be singular; see points/singularities.py
        singular=tuple(x.quantity.name for x in equations.singularities if x.use == COORDINATES),
        mass_blocks=coupled,
        mass_band=mass_band(equations),
        influences=influence,
        blocks=blocks_of(influence, coupled),
        claims=claims_of(equations, coupled, bool(jumping)) if with_claims else (),
        symmetries=found,
    )


def _of_first_degree(equations: Equations) -> bool:
    """Whether all states come from an L of first degree in the rates (derive/first_degree.py). The
    energy is then H."""
    model = equations.model
    return bool(model.lagrangian) and not model.coordinates and not model.rates


class _Seen:
    """Finds the symbols that expressions depend on, with a bounded amount of work."""

    def __init__(self, g: Graph):
        self.graph = g
        self.normal = Normal(g, work=2 * WORK)
        self.varying = Varying(g)

    def occurs(self, nodes: Iterable[Node], mask: int, first: int = 0) -> bool:
        """Returns whether any of the nodes depends on a symbol of the kinds in `mask` whose index
        is at least `first`. If the result is False, this is proved; if True, the nodes may still
        not depend on it."""
        g = self.graph
        nodes = [node for node in nodes if g.depends[node] & mask]
        if first:
            found = [atom for node in nodes for atom in atoms(self.normal, node)]
            return any(symbol.index >= first for symbol in symbols_in(g, found, mask))
        return any(self.varying(node, mask) for node in nodes) or any(
            g.depends[atom] & mask for node in nodes for atom in atoms(self.normal, node)
        )


def _jumping(equations: Equations) -> frozenset[int]:
    """Returns the indices of coordinates and states that occur in the argument of a step or sign in
    the Lagrangian. States are numbered after the coordinates.

    Where L jumps, the force is infinite; it is left out of the equations, since the derivative of a
    step is taken as 0. Neither the energy nor the momentum is then constant.
    """
    g = equations.graph
    inside = [node for node in reachable(g, [equations.lagrangian], VARIABLE) if jumps(g, node)]
    first = {Kind.COORDINATE: 0, Kind.RATE: 0, Kind.STATE: len(equations.coordinates)}
    return frozenset(
        first[s.kind] + s.index for s in symbols_in(g, inside, VARIABLE) if s.kind in first
    )


def cyclic_of(equations: Equations) -> list[int]:
    """Returns the coordinates that are proved cyclic, without those of rotations."""
    kinds = _cyclic(equations, _Seen(equations.graph), _jumping(equations))
    return [i for i, cyclic in enumerate(kinds) if cyclic and i not in equations.turning]


def _cyclic(equations: Equations, seen: _Seen, jumping: frozenset[int]) -> tuple[bool, ...]:
    """Returns for each coordinate whether it is proved cyclic: L does not depend on it, and no
    applied force acts along it."""
    g = equations.graph
    n = len(equations.coordinates)
    free = {i for i in range(n) if equations.applied[i] == ZERO and i not in jumping}
    free -= ties(equations).keys()  # constraint forces may act on these coordinates
    open_ = {i for i in free if equations.gradient[i] != ZERO}
    acting = {i for i in open_ if seen.varying.is_nonzero(equations.gradient[i])}
    # For the body rates w of a rotation, `gradient` is X L + p x w (attitudes.py). That X L is zero
    # is not enough: the whole sum has to be proved zero.
    acting |= {i for i in open_ & equations.turning if seen.normal(equations.gradient[i]) != {}}
    if open_ - acting:
        found = atoms(seen.normal, equations.lagrangian)
        acting |= {s.index for s in symbols_in(g, found, BIT[Kind.COORDINATE])} & open_
    kept = () if equations.model.resetting or equations.model.noises else free - acting
    return tuple(i in kept for i in range(n))


def _smooth(equations: Equations) -> bool:
    """Returns whether the equations of motion contain no function with a kink or a jump."""
    g = equations.graph
    outputs = [*equations.pdot, *equations.force, *equations.state_rates]
    outputs += [entry for row in equations.mass for entry in row]
    return smooth(g, reachable(g, outputs, VARIABLE))


def has_series(e: Equations) -> bool:
    """Returns whether pkgen writes the kernel `jet` of the equations."""
    if e.constraints or e.inputs or e.model.meets or e.model.noises or e.impulsive:
        return False
    g, in_pieces = e.graph, bool(e.switches) and all(x.held for x in e.switches)
    return expandable(g, reachable(g, [*sum(e.mass, ()), *e.force], VARIABLE), in_pieces)


def _definite(e: Equations) -> bool:
    """Returns whether M is proved positive definite at all states, for all parameters within their
    bounds: by its pivots (D in M = L D L^T), or by writing T as a sum of squares."""
    if definite_by_squares(e.graph, e.parameters, e.written, len(e.coordinates)):
        return True
    positive = Positive(e.graph.copy(), e.parameters)
    return e.pivots is not None and all(positive(pivot) for pivot, _ in e.pivots)
