"""Proved facts about equations of motion: the output of `analyze`."""

from __future__ import annotations

from ..graph.graph import Graph, Node
from ..record import record

Indices = tuple[tuple[int, ...], ...]


@record
class Claim:
    """The outcome of a `conserve` statement: proved, refuted or open, with the reason in words."""

    name: str
    outcome: str  # PROVED, REFUTED or OPEN of middle/analyze/proofs.py
    says: str


@record
class Invariant:
    """A constant of the motion: a sum of terms. A term is a coefficient (a node with parameters
    only) times a product of names: "t", coordinates, momenta and "energy"."""

    name: str  # "energy", "p_phi", or the formula of the invariant
    reason: str  # the symmetry, in words
    generator: str  # generator of the symmetry: "x d/dy - y d/dx"
    terms: tuple[tuple[Node, tuple[str, ...]], ...]
    node: Node
    when: str = ""  # sizes for which it is proved, if families are loops


@record
class Symmetries:
    """A basis of the invariants by Noether's theorem; nodes are of `graph`."""

    graph: Graph
    parameters: tuple[str, ...]  # names of the parameters in coefficients
    searched: str  # in words, the generators searched; "" if the model was too large
    invariants: tuple[Invariant, ...]


@record
class Structure:
    """Proved facts about a system and its coordinates; False means not proved, an empty tuple that
    nothing is known. See enum pk_fact. `influences` may have too many entries, but a missing entry
    is proved to have no influence."""

    mass_constant: bool
    mass_diagonal: bool
    quadratic: bool
    separable: bool
    autonomous: bool
    conservative: bool
    variational: bool
    smooth: bool
    affine: bool = False  # the acceleration is affine in q and v, with constant coefficients
    switched: bool = False  # smooth except at switches, where a run stops a step
    linear_drag: bool = False  # separable except for forces C v with constant C
    affine_rates: bool = False  # separable except for forces C v with any C(q, t)
    fast: bool = False  # separable, with terms of V that the model names fast
    series: bool = False  # the kernel `jet` of Taylor coefficients can be written
    claims: tuple[Claim, ...] = ()
    symmetries: Symmetries | None = None  # None: not requested
    cyclic: tuple[bool, ...] = ()  # whether p_i is constant
    definite: bool | None = None  # M is positive definite wherever it is finite; None: not asked
    singular: tuple[str, ...] = ()  # expressions at whose zeros M may be singular
    mass_blocks: Indices = ()  # blocks of coordinates coupled by M, the finest partition
    mass_band: int = 0  # largest |i - j| of a nonzero entry of M
    influences: Indices = ()  # for each i, all j for which a_i depends on q_j or v_j
    blocks: Indices = ()  # a partition of coordinates; blocks do not influence each other

    @property
    def smooth_in_pieces(self) -> bool:
        return self.smooth or self.switched
