"""The values that a C function computes before its terms: totals, rates of states, `let`s.

These values are stored in the model's memory, where terms read them. `prepare` computes totals that
contain only parameters.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ....middle.families.equations import FamilyEquations
from ....middle.families.indexed_ir import Slot
from ....middle.families.slots import Slots
from .blocks import Block
from .kernels import Terms
from .places import Places
from .plan import Plan

# A value to compute before terms: ("sum", number of the total), ("rate", name of the state),
# ("let", number of the pass over members), ("acceleration", "") for all accelerations and
# multipliers, ("momenta", "") for all momenta, or ("carried", "") for all carried values. The
# model's kernels compute carried values before they call the function.
Key = tuple[str, str]
STATE = "(p, t, q, v, u)"
FIRST = ("acceleration", "momenta")  # Computed before all others: they compute totals anew.


class Before:
    """For each C function of a model, the lines that compute values before its terms."""

    def __init__(
        self,
        e: FamilyEquations,
        places: Places,
        plan: Plan,
        slots: Slots,
        outputs: dict[str, Block],
    ):
        self.e, self.places, self.plan, self.slots = e, places, plan, slots
        self.name = e.model.name
        self.states = {g.name for g in e.states}
        self.carried = {g.name for g in e.carried_groups}
        self.passes = {item.name: k for k, found in enumerate(e.along) for item in found}
        self.of = {name: self._needed(blocks) for name, blocks in self._functions(outputs)}

    def _functions(self, outputs: dict[str, Block]) -> Iterator[tuple[str, list[Block]]]:
        plan = self.plan
        for kernel in plan.kernels:
            yield kernel.name, [*kernel.blocks]
        chain = plan.chain and plan.chain.elimination
        yield "elimination", [b for rows in chain.mass for b in rows.vector.blocks] if chain else []
        for kernel, block in outputs.items():
            yield kernel, [block, *_of(terms for terms, _ in plan.written.get(kernel, ()))]
        yield "singularity", _of(plan.singularities)
        yield "switching", _of(plan.switches)
        yield from ((what, _of(found)) for what, found in plan.totals.items())

    # -- dependencies --------------------------------------------------------------------------

    def _below(self, blocks: Iterable[Block]) -> list[Key]:
        nodes = [node for block in blocks for node in block.nodes]
        keys = (self.key(slot) for slot in self.slots.below(*nodes))
        return list(dict.fromkeys(key for key in keys if key is not None))

    def key(self, slot: Slot) -> Key | None:
        if slot.kind == "sum":
            return "sum", slot.name
        if slot.kind == "a" and slot.name in self.states:
            return "rate", slot.name
        if slot.name in self.carried:
            return "carried", ""
        if slot.kind in ("a", "acc", "lambda"):
            return "acceleration", ""
        if slot.kind == "p":
            return "momenta", ""
        return ("let", str(self.passes[slot.name])) if slot.kind == "let" else None

    def _blocks(self, key: Key) -> list[Block]:
        kind, name = key
        if kind in (*FIRST, "carried"):
            return []
        if kind == "sum":
            return _of(self.plan.totals[f"sum_{name}"])
        return _of(self.plan.along[int(name)] if kind == "let" else self.plan.rates[name].terms)

    def _needed(self, blocks: Iterable[Block]) -> list[Key]:
        """Returns the values that must be computed before the given blocks, in the order of
        computation."""
        done: dict[Key, None] = {}

        def need(key: Key) -> None:
            if key in done or (key[0] == "sum" and int(key[1]) in self.e.fixed):
                return
            for inner in self._below(self._blocks(key)):
                if inner != key:  # A `let` may use its own lower members.
                    need(inner)
            done[key] = None

        for key in self._below(blocks):
            need(key)
        return sorted(done, key=lambda key: key[0] not in FIRST)

    def reads(self, kind: str, function: str | None = None) -> bool:
        """Returns whether the function, or any (None), reads values of this kind."""
        functions = self.of if function is None else [function]
        return any(key[0] == kind for name in functions for key in self.of.get(name, []))

    # -- as C text -----------------------------------------------------------------------------

    def lines(self, *functions: str, first: bool | None = None) -> str:
        """Returns the C lines that compute the values that the given functions read. `first`
        selects: True for the kinds FIRST, False for the others, None for all."""
        keys = dict.fromkeys(key for function in functions for key in self.of.get(function, []))
        found = [key for key in keys if first in (None, key[0] in FIRST) and key[0] != "carried"]
        return "".join(f"    {self._line(*key)}\n" for key in found)

    def _line(self, kind: str, k: str) -> str:
        if kind == "sum":
            return f"{self.name}_sums(p)[{k}] = {self.name}_total_sum_{k}{STATE};"
        if kind == "acceleration":
            return f"{self.name}_accelerate{STATE};"
        if kind == "momenta":
            return f"{self.name}_momenta{STATE[:-1]}, {self.name}_momentum(p));"
        if kind == "let":
            return f"{self.name}_along_{k}{STATE};"
        return f"{self.name}_rate_{self.places.ids[k]}{STATE};"

    @property
    def fixed(self) -> list[str]:
        """Returns the numbers of the totals that `prepare` computes."""
        keys = (key[4:] for key in self.plan.totals if key.startswith("sum_"))
        return [key for key in keys if int(key) in self.e.fixed]


def _of(found: Iterable[Terms]) -> list[Block]:
    return [terms.block for terms in found]
