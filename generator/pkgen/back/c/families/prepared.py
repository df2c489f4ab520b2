"""Plans the kernels of a model with families, and lowers all its blocks before there is text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ....graph.affine import variable
from ....graph.graph import Node
from ....middle.families.equations import Assigned, FamilyEquations, Summed
from ...targets import ADD, RETURN, STORE, Target
from .before import Before
from .blocks import FIXED, INNER, Block
from .kernels import Builder, block_of
from .lowering import Lowering
from .numbers import Numbers
from .parameters import Assignment, Summing
from .places import M, Places
from .plan import emitted, planned
from .readers import Readers
from .steps import has_steps, lag_of
from .switches import sides
from .vectors import VectorText

# The arrays to which the kernels of outputs write; the others write to `out`.
SAMPLING = {"sampling": ("times", "held")}


class Prepared:
    """The kernels of a model, lowered."""

    def __init__(self, e: FamilyEquations, wanted: frozenset[str] | None, libm: bool):
        kernels = emitted(e, wanted)
        # With recurrence values the acceleration calls whole_force instead of the kernel `force`.
        unasked = {"force"} - wanted if e.carried and wanted is not None else frozenset()
        self.kernels = kernels - unasked
        self.with_multipliers = wanted is None or "multipliers" in wanted
        self.places = Places(e)
        self.fields = tuple(zip(self.places.tables.values(), e.model.tables, strict=True))
        builder = Builder(e, self.places)
        self.plan = planned(e, builder, kernels)
        self.slots = builder.slots
        self.block = block_of(self.plan.all_terms, self.slots)
        self.fused = "advance" in kernels and has_steps(e, self.plan, self.slots)
        self.lag, self.kicks = 0, ""
        if self.fused:
            vector = self.plan.vectors["acceleration"]
            if vector.is_merged:
                outputs, finish = self.plan.accelerated
                vector = builder.vector("kick", outputs, e.coordinates, finish, merge=False)
                self.plan.vectors["kick"] = vector
            self.lag = lag_of(e, vector, self.slots, self.block)
            vector.kicks = True
            self.kicks = vector.name
        # No nodes are added to the graph after this.
        self.e = e = replace(e, slots=tuple(self.slots.all))
        self.given = {at: [_value(node) for node in nodes] for at, nodes in e.given.items()}
        self.defaults = [self._assigned(x, parameter=True) for x in e.defaults]
        self.starts = [self._assigned(x) for x in e.starts]
        self.bounds = [
            Block([Target(STORE, key, (x,)) for key, x in vars(b).items() if x is not None], FIXED)
            for b in e.bounds
        ]
        self.outputs = {
            "observe": Block(list(self._observed()), INNER),
            "conserve": Block.of(STORE, "out[{}]", e.conserved, INNER),
            "event": Block.of(STORE, "out[{}]", e.events, INNER),
            **self._samples(e),
            **dict(zip((x.kernel for x in e.model.resetting), self._resets(e), strict=True)),
        }
        blocks = [
            *self.plan.blocks,
            *(block for values in self.given.values() for block in values),
            *(block for x in (*self.defaults, *self.starts) for block in x.blocks),
            *self.bounds,
            *self.outputs.values(),
        ]
        self.before = Before(e, self.places, self.plan, self.slots, self.outputs)
        watched = {id(terms.block) for terms in self.plan.switches}
        held = [x for b in blocks if b.where != FIXED and id(b) not in watched for x in b.nodes]
        decided = sides(e, self.slots, held)
        self.e = e = replace(e, slots=tuple(self.slots.all))
        self.readers = Readers(self.places, self.given)
        self.lowering = Lowering(e, self.places, libm, blocks, decided, self.readers)
        matrices = bool(self.plan.matrices or self.plan.made)
        self.numbers = Numbers(e, self.places, self.readers, matrices)
        self.vectors: dict[str, VectorText] = {}

    def _observed(self) -> Iterator[Target]:
        """Yields the stores of outputs that are a single number."""
        for first, item in zip(self.places.observed, self.e.outputs, strict=False):
            if item.lo is None:
                yield Target(STORE, f"out[{self.places.index(first)}]", (item.node,))

    def _samples(self, e: FamilyEquations) -> dict[str, Block]:
        """Returns the kernels of sample blocks: see SAMPLING."""
        if not e.sampled:
            return {}
        n, blocks = len(e.inputs), e.model.samples
        times = [Target(STORE, f"times[{k}]", (x,)) for k, x in enumerate(e.sample_times)]
        held = [Target(STORE, f"held[{k}]", (x,)) for k, x in enumerate(e.held_start)]
        found = {"sampling": Block([*times, *held], INNER)}
        for k, block in enumerate(blocks):
            row = e.sampled[k * n : (k + 1) * n]
            found[block.kernel] = Block.of(STORE, "out[{}]", row, INNER)
        return found

    def _resets(self, e: FamilyEquations) -> Iterator[Block]:
        """Yields the kernels of events that give values: all of q, then of v, then of u."""
        index, place = self.places.index, self.places.given
        for given in e.resets:
            single = [(index(place(x)), x.node) for x in given if x.lo == x.hi]
            yield Block([Target(STORE, f"out[{at}]", (node,)) for at, node in single], INNER)

    def _assigned(self, item: Assigned, parameter: bool = False) -> Assignment:
        index = self.places.index
        single = item.lo is None or item.lo == item.hi
        at = item.lo if single else M
        if parameter:
            where = self.places.member(item.name, at)
        else:
            where = f"{'v' if item.order else 'q'}[{index(self.places.flat(item.name, at))}]"
        block = Block.of(STORE, where, [item.node], FIXED)
        over = ("", "") if single else (index(item.lo), index(item.hi))
        before, each = ([*map(self._summing, found)] for found in (item.before, item.each))
        return Assignment(*over, before, each, block)

    def _summing(self, item: Summed) -> Summing:
        place, index = f"once[{item.place}]", self.places.index
        ranges = [(index(variable(name)), index(lo), index(hi)) for name, lo, hi in item.ranges]
        block = Block([Target(ADD, place, (item.node,))], FIXED)
        return Summing(place, ranges, block, [*map(self._summing, item.inside)])

    @property
    def _same_as_force(self) -> bool:
        """Returns whether the accelerations are the forces, since all masses are 1."""
        found = [self.plan.vectors.get(k) for k in ("force", "acceleration")]
        if None in found or "force" not in self.kernels:
            return False
        goals = [[(id(x.terms), x.value, x.sign, x.output, x.to) for x in v.goals] for v in found]
        return goals[0] == goals[1] and found[1].finish == "STORE"


def _value(node: Node) -> Block:
    return Block.of(RETURN, "", [node], INNER)
