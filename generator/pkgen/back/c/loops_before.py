"""The values that a C function computes before its rows: totals, rates of states, `let`s.

These values are stored in the model's memory, where rows read them. A total that only outputs
contain is stored in a local array. `prepare` computes totals that contain only parameters.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ...middle.loops.indexed_ir import Slot
from ...middle.loops.loops import LoopEquations
from ...middle.loops.slots import Slots
from .loops import Block, Places
from .loops_plan import Plan, within

# A value to compute before rows: ("sum", number of the total), ("rate", name of the state), ("let",
# number of the pass over members), or ("acceleration", "") for all accelerations.
Key = tuple[str, str]
STATE = "(p, t, q, v, u)"


class Before:
    """For each C function of a model, the lines that compute values before its rows."""

    def __init__(
        self,
        e: LoopEquations,
        places: Places,
        plan: Plan,
        slots: Slots,
        outputs: dict[str, Block],
    ):
        self.e, self.places, self.plan, self.slots = e, places, plan, slots
        self.name = e.model.name
        self.states = {g.name for g in e.states}
        self.passes = {item.name: k for k, found in enumerate(e.along) for item in found}
        watched = (*plan.singularities, *plan.switches)
        inside = [*plan.blocks, *(b for x in watched for b in x.blocks)]
        self.kept = {k for kind, k in self._below(inside) if kind == "sum"}
        self.kept |= {str(k) for k in e.fixed}
        self.of = {name: self._needed(blocks) for name, blocks in self._functions(outputs)}

    def _functions(self, outputs: dict[str, Block]) -> Iterator[tuple[str, list[Block]]]:
        plan, ids = self.plan, self.places.ids
        scalars = [ids[g.name] for g in self.e.scalars]

        def totals(*names: str) -> list[Block]:
            found = (plan.totals[f"{what}_{g}"] for what in names for g in scalars)
            return [block for x in found for block in x.blocks]

        def sets(found: Iterable) -> list[Block]:
            return [block for x in found for block in x.blocks]

        for kernel, whats in within(self.e).items():
            if kernel in plan.rows:
                pairs = [pair.block for pair in plan.pairs.get(kernel, ())]
                yield kernel, sets(plan.rows[kernel]) + totals(*whats.values()) + pairs
        mass = [x for key, x in plan.totals.items() if key.startswith("mass_")]
        rows = [*plan.rows.get("mass", ()), *plan.band]
        if plan.chain and plan.chain.elimination:
            rows += [x.set for x in plan.chain.elimination.mass]
        yield "mass", sets(rows) + sets(mass)
        yield "acceleration", sets(plan.rows.get("acceleration", ())) + totals("force")
        for kernel, block in outputs.items():
            observed = plan.observed.values() if kernel == "observe" else ()
            yield kernel, [block, *sets(observed)]
        yield "singularity", sets(plan.singularities)
        yield "switching", sets(plan.switches)
        for kernel in plan.slopes:
            corner = [plan.totals[key] for *_, key in kernel.corner]
            yield f"slopes_{kernel.name}", sets([*kernel.rows, *corner])
        for what in ("energy", "lagrangian", "kinetic", "potential"):
            if what in plan.totals:
                yield what, plan.totals[what].blocks

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
        if slot.kind == "acc":
            return "acceleration", ""
        return ("let", str(self.passes[slot.name])) if slot.kind == "let" else None

    def _blocks(self, key: Key) -> list[Block]:
        kind, name = key
        if kind == "acceleration":
            return []
        if kind == "sum":
            return self.plan.totals[f"sum_{name}"].blocks
        if kind == "let":
            return self.plan.along[int(name)].blocks
        return self.plan.rates[name].blocks

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
        return sorted(done, key=lambda key: key[0] != "acceleration")

    # -- as C text -----------------------------------------------------------------------------

    def place(self, k: str) -> str:
        """Returns the C variable in which a total is stored."""
        return f"{self.name}_sums(p)[{k}]" if k in self.kept else f"sum[{k}]"

    def lines(self, function: str) -> Iterator[str]:
        found = self.of.get(function, [])
        if any(kind == "sum" and k not in self.kept for kind, k in found):
            yield f"pk_real sum[{len(self.e.sums)}];"
        for kind, k in found:
            if kind == "sum":
                yield f"{self.place(k)} = {self.name}_total_sum_{k}{STATE};"
            elif kind == "acceleration":
                yield f"{self.name}_accelerate{STATE};"
            elif kind == "let":
                yield f"{self.name}_along_{k}{STATE};"
            else:
                yield f"{self.name}_rate_{self.places.ids[k]}{STATE};"

    @property
    def fixed(self) -> list[str]:
        """Returns the numbers of the totals that `prepare` computes."""
        return [
            key[4:]
            for key in self.plan.totals
            if key[:4] == "sum_" and int(key[4:]) in self.e.fixed
        ]
