"""Turns LoopEquations into a LoopProgram: the template variables of a model with loops, as text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from ...equations import Facts
from ...graph.affine import variable
from ...graph.graph import Node
from ...middle.loops.indices import size_values
from ...middle.loops.loops import Assigned, Limit, LoopEquations, Summed
from ..facts import facts, invariants
from ..kernels import KERNELS
from ..targets import ADD, RETURN, STORE, Target
from . import loop_parameters, loops_tables, tables
from .describe import labelled
from .helpers import helpers
from .loops import BLOCK, CHUNK, FIXED, INNER, WIDEST_BOND, Block, Lowering, M, Places
from .loops_before import Before
from .loops_bound import bound_context, shape_of
from .loops_chain import chain_context
from .loops_plan import (
    TOTALS,
    VECTORS,
    divides,
    emitted,
    entries,
    planned,
    watches_momenta,
    within,
)
from .loops_sets import Assignment, Builder, Summing
from .loops_singular import described
from .loops_slopes import slopes_context
from .loops_steps import stepper
from .loops_switches import described as switches
from .loops_switches import sides
from .program import LoopProgram, operations_text
from .render import frame, pasted


def lower_loops(
    e: LoopEquations,
    libm: bool = False,
    wanted: frozenset[str] | None = None,
    plain: bool = False,
) -> LoopProgram:
    """Returns the C of a model with loops, with the kernels `wanted` (None: all). Raises Unrolled
    if an equation cannot be written as a loop."""
    text = _Context(e, wanted, libm).text()
    return LoopProgram(e.model.name, text | {"plain": plain})


class _Context:
    def __init__(self, e: LoopEquations, wanted: frozenset[str] | None, libm: bool):
        kernels = emitted(e, wanted)
        # With recurrence values the acceleration calls whole_force instead of the kernel `force`.
        unasked = {"force"} - wanted if e.carried and wanted is not None else frozenset()
        self.kernels = kernels - unasked
        self.with_multipliers = wanted is None or "multipliers" in wanted
        self.places = Places(e)
        builder = Builder(e, self.places)
        self.plan = planned(e, builder, kernels)
        self.slots = builder.interior.slots
        # No nodes are added to the graph after this.
        self.e = e = replace(e, slots=tuple(self.slots.all))
        self.given = {at: [_value(node, INNER) for node in nodes] for at, nodes in e.given.items()}
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
        }
        blocks = [
            *self.plan.blocks,
            *(block for values in self.given.values() for block in values),
            *(block for x in (*self.defaults, *self.starts) for block in x.blocks),
            *self.bounds,
            *self.outputs.values(),
            *(block for found in self.plan.singularities for block in found.blocks),
        ]
        self.before = Before(e, self.places, self.plan, self.slots, self.outputs)
        blocks += [block for found in self.plan.switches for block in found.blocks]
        held = [node for block in blocks if block.where != FIXED for node in block.nodes]
        decided = sides(e, self.slots, held)
        self.e = e = replace(e, slots=tuple(self.slots.all))
        self.lowering = Lowering(e, self.places, libm, blocks, self.before.kept, decided)

    def _observed(self) -> Iterator[Target]:
        """Yields the stores of outputs that are a single number."""
        for first, item in zip(self.places.observed, self.e.outputs, strict=False):
            if item.lo is None:
                yield Target(STORE, f"out[{self.places.index(first)}]", (item.node,))

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

    def text(self) -> dict[str, Any]:
        e, w, plan, index = self.e, self.lowering, self.plan, self.places.index
        model, group, ids = e.model, self.places.group, self.places.ids
        diagonal = divides(e)
        alone = diagonal and not e.force.pairs
        fused = alone and "advance" in self.kernels
        acceleration = "direct" if alone else "divide" if diagonal else "solve"
        acceleration = "carried" if e.carried and not e.extended else acceleration
        constant = e.facts.mass_constant and not e.carried  # recurrences use its memory
        inside = {
            kernel: {"name": kernel, "outputs": list(outputs), "whats": list(outputs.values())}
            for kernel, outputs in within(e).items()
            if kernel in plan.rows
        }
        kernels = [
            {"name": kernel, "outputs": list(outputs), "inside": inside[kernel]["outputs"]}
            for kernel, outputs in VECTORS.items()
            if kernel in self.kernels
        ]
        main = plan.band or plan.rows["force" if "force" in plan.rows else "acceleration"]
        chain = chain_context(plan.chain)
        homed = {ids[g.name] for g in e.families}
        parameters = [loops_tables.parameter(e, self.places, k) for k in range(len(e.parameters))]
        system = self._system_kernels()
        # In struct pk_system these kernels are replaced by others: with constraints by kernels that
        # add J^T lambda, for solved equations by one in which p = v and p' = a.
        own = {"force", "canonical"} if e.bound else {"canonical"} if e.solved else set()
        answered = plan.slopes_of is not None and plan.slopes_of.answered
        accelerates = any(slot.kind == "acc" for slot in e.slots)
        in_block = any(g.is_family for g in e.parameters)
        return {
            **frame(model, _told(e), set(system) - own, parameters, loops_tables.names(e)),
            "n": e.count.value(size_values(model)),
            "kernels": list(system.values()),
            "sincos_header": pasted("sincos.h") if any(b.trig for b in w.blocks) else "",
            "ldl_header": pasted("ldl.h"),
            "reductions": (),
            "events": tables.events(e),
            "cyclic": (),
            "forms": (),
            "n_hoisted": w.hoisted_count,
            "parameter_functions": loop_parameters.functions(
                model.name,
                [
                    loop_parameters.code(
                        g, self.places, self.bounds[k], self.defaults[k], k, e.summed
                    )
                    for k, g in enumerate(e.parameters)
                ],
                self.starts,
                w.hoisted_count,
                w.prepare,
                factored=constant and not diagonal,
                bound=bool(e.bound),
                block=in_block
                or not diagonal
                or answered
                or accelerates
                or bool(self._regions() or e.switches),
                fixed=self.before.fixed,
                summed=e.summed,
            ),
            "sizes": [
                {"c_name": self.places.sizes[s.name], "name": s.name, "value": s.value}
                | {"says": s.description}
                for s in model.sizes
            ],
            "count": index(e.count),
            "first_order": index(e.first_order),
            "n_first_order": e.first_order.value(size_values(model)),
            "unseen": [group(g) for g in e.unseen],
            "rotations": list(loops_tables.rotations(e, self.places)),
            "groups": [group(g) for g in e.coordinates],
            "families": [group(g) for g in e.families],
            "banded": [group(g) for g in e.banded],
            "tied": bool(e.bound or e.extended),
            "work": f"{model.name}_matrix(p)" if e.extended else "p->work_",
            "scalars": [group(g) for g in e.scalars],
            "limits": [self._limit(limit) for limit in e.limits],
            "readers": list(self._readers()),
            "row_sets": plan.rows,
            "band_sets": plan.band,
            "entries": {ids[g.name]: [x for x, _ in entries(e, g, ids)] for g in e.banded},
            "band": self._band() if plan.band else None,
            "carried": chain,
            "inner": "whole_" if chain else "",
            "inner_vectors": list(inside.values()),
            **bound_context(e, plan, self.places),
            **slopes_context(e, plan, self.places),
            "solved": e.solved,
            "totals": plan.totals,
            "pairs": plan.pairs,
            "vectors": kernels,
            "with_mass": {"mass", "inertia"} & self.kernels,
            "with_inertia": e.bound or ("inertia" in self.kernels and not e.carried),
            "with_canonical": "canonical" in self.kernels,
            "with_multipliers": self.with_multipliers,
            "scalar_kernels": [k for k in TOTALS if k in plan.totals],
            "says": {name: KERNELS[name].says for name in (*VECTORS, *TOTALS, *self.outputs)},
            "outputs": {k: x.statements for k, x in self.outputs.items() if self._there(k)},
            **loops_tables.outputs_of_members(e, self.places, plan),
            "singularities": list(described(e, self.places)),
            "singular": {
                "sets": plan.singularities,
                "pivots": ("mass" if diagonal else "pivots") if e.pivots else "",
            },
            "before": self.before,
            "accelerates": accelerates,
            "rated": [(self.places.ids[name], x) for name, x in plan.rates.items()],
            "along": plan.along,
            "regions": self._regions(),
            "switches": list(switches(e, self.places)),
            "switch_sets": plan.switches,
            "with_lambda": any(slot.kind == "lambda" for slot in e.slots),
            "with_momenta": watches_momenta(e),
            "chunk": CHUNK,
            "block": BLOCK,
            "widest": WIDEST_BOND,
            "acceleration": acceleration,
            "constant_mass": constant,
            "helpers": helpers(w.helpers),
            "float_too": w.work.constants.float_too,
            "operations": list(self._operations()),
            "proved": labelled(facts(e, e.facts)),
            "constant": labelled(invariants(e, e.facts)),
            "stepper": stepper(e, plan, self.places, self.slots) if fused else None,
            "wraps": any(g.periodic for g in e.families),
            "homes": [
                s.group
                for s in main
                if plan.band
                or (plan.slopes and s.group["name"] in homed)
                or s.ghosts
                or s.group["periodic"]
            ],
        }

    def _regions(self) -> dict[str, dict[str, str]]:
        """Returns the arrays at the end of the model's memory: their lengths and descriptions."""
        found, count = {}, self.places.index(self.e.count)
        if watches_momenta(self.e):
            found["momentum"] = {"count": count, "says": "Room for the momenta that outputs have"}
        if self.plan.rates:
            found["rated"] = {"count": count, "says": "Rates of states that others use"}
        if self.before.kept & {key[4:] for key in self.plan.totals if key[:4] == "sum_"}:
            found["sums"] = {"count": str(len(self.e.sums)), "says": "Sums that rows have in them"}
        if self.plan.along:
            length = self.places.index(self.places.n_lets)
            found["lets"] = {"count": length, "says": "What outputs have of each member"}
        return found

    def _system_kernels(self) -> dict[str, dict[str, Any]]:
        """Returns the kernels of struct pk_system by name. M and the Jacobians are left out, since
        the struct's members for them write dense matrices."""
        e, out = self.e, ("out",)
        found = {"acceleration": ("a",)} | {k: VECTORS.get(k, ()) for k in self.kernels}
        found |= {"singularity": out} if e.singularities or e.pivots else {}
        found |= {"switching": out} if e.switches else {}
        found |= {k: out for k in self.outputs if self._there(k)}
        return {
            name: {"name": name, "result": KERNELS[name].result, "given": ()}
            | {"outputs": [{"name": output} for output in found[name]]}
            for name in KERNELS
            if name in found and name not in ("mass", "jacobian", "inertia")
        }

    def _there(self, kernel: str) -> bool:
        return bool(self.outputs[kernel].targets or (kernel == "observe" and self.plan.observed))

    def _limit(self, limit: Limit) -> dict[str, str]:
        unless = "" if limit.unless is None else self.places.index(limit.unless)
        return {"needs": self.places.index(limit.needs), "unless": unless}

    def _readers(self) -> Iterator[dict[str, Any]]:
        """Yields the C functions that read a member of a family by its index, which may be beyond
        an end. Each array (q, v, ...) that is read by index in this way has its own function."""
        places, used = self.places, {word for b in self.lowering.blocks for word in b.words}
        for g in self.e.families:
            for kind, order in {"q": 0, "v": 1, "s": 0, "w": 2, "d": 3, "a": 3, "acc": 2}.items():
                name = f"{self.lowering.prefix}{kind}_{places.ids[g.name]}"
                if name not in used:
                    continue
                ends = []
                for at, end in g.ends:
                    item: dict[str, Any] = {"at": places.index(at), "kind": end.kind}
                    if end.kind == "free":
                        home = g.lo if at == g.lo - 1 else g.hi
                        item["home"] = places.index(places.flat(g.name, home))
                    elif kind not in ("d", "a") or g.is_state:
                        order = 1 if kind == "a" else order
                        item["lines"] = self.given[g.name, at][order].statements
                    ends.append(item)
                yield places.group(g) | {"reader": name, "kind": kind, "given": ends}

    def _band(self) -> dict[str, Any]:
        """Returns the template variables of the band matrix: a band, in which the families are
        interleaved by index, and a border of scalar coordinates."""
        e, ids = self.e, self.places.ids
        return {
            **shape_of(e, self.places, self.plan.made),
            "periodic": any(g.periodic for g in e.families),
            "corner": [
                {"a": a, "b": b, "key": f"mass_{ids[a]}_{ids[b]}"} for a, b in e.mass.corner
            ],
            "scalars": [g.name for g in e.scalars],
        }

    def _operations(self) -> Iterator[str]:
        totals = (t.rows for key, t in self.plan.totals.items() if key in TOTALS and t.rows)
        for s in (*(s for found in self.plan.rows.values() for s in found), *totals):
            yield f"{s.name}: {operations_text(s.inner.operations)} a member"
        if self.plan.chain:
            yield from self.plan.chain.operations


def _told(e: LoopEquations) -> Facts:
    """Returns the facts for the runtime's table. For equations solved for the accelerations, p = v
    and p' = a, so the mass matrix M is 1."""
    one = {"mass_constant": True, "mass_diagonal": True, "quadratic": True}
    return replace(e.facts, **one) if e.solved else e.facts


def _value(node: Node, where: str) -> Block:
    return Block.of(RETURN, "", [node], where)
