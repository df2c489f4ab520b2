"""Turns FamilyEquations into a FamilyProgram: template variables, as text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

from ....graph.affine import Affine
from ....middle.families.equations import FamilyEquations, Limit
from ....middle.families.indices import size_values
from ....middle.structure import Structure
from ...facts import facts, invariants
from ...kernels import KERNELS
from ...kernels import kernel as spec_of
from .. import tables
from ..describe import labelled
from ..helpers import helpers
from ..program import FamilyProgram, operations_text
from ..render import frame, pasted
from ..tree import Scope, rendered
from . import introspection, parameters
from .bound import Layout, bound_context, layout_of_k, layout_of_slopes
from .chain import chain_context
from .headers import headers
from .kernels import Terms, Vector
from .memory import memory_regions
from .places import M
from .plan import TOTALS, VECTORS, divides, within
from .prepared import SAMPLING, Prepared
from .rows import extreme
from .switches import described as switches
from .text import KernelText
from .vectors import VectorText, pair_loop


def lower_families(
    e: FamilyEquations,
    libm: bool = False,
    wanted: frozenset[str] | None = None,
    plain: bool = False,
) -> FamilyProgram:
    """Returns the C of a model with loops, with the kernels `wanted` (None: all). Raises NotKept
    if an equation cannot be written as a loop."""
    return FamilyProgram(e, _Context(e, wanted, libm).text(plain))


class _Context(Prepared):
    """The template variables of a model."""

    def text(self, plain: bool) -> dict[str, Any]:
        e, w, plan, index = self.e, self.lowering, self.plan, self.places.index
        model, group, ids = e.model, self.places.group, self.places.ids
        constant = e.facts.mass_constant and not e.carried  # recurrences use its memory
        kernels = [
            {"name": kernel, "outputs": list(outputs), "inside": list(within(e)[kernel])}
            for kernel, outputs in VECTORS.items()
            if kernel in self.kernels
        ]
        parameters = [introspection.parameter(e, self.places, k) for k in range(len(e.parameters))]
        system = self._system_kernels()
        # In struct pk_system these kernels are replaced by others: with constraints by kernels that
        # add J^T lambda, for solved equations by one in which p = v and p' = a.
        own = {"force", "canonical"} if e.bound else {"canonical"} if e.solved else set()
        answered = plan.slopes is not None and plan.slopes.answered
        accelerates = self.before.reads("acceleration")
        banded = "inertia" in plan.matrices
        layouts = self._layouts()
        regions = memory_regions(e, self.places, plan, layouts, answered or accelerates)
        names = introspection.names(e)
        if plain and "momenta" not in self.kernels:
            names["momentum_names"] = []
        block = bool(regions or e.switches or self._families_of_parameters)
        found = {
            **frame(model, _told(e), set(system) - own, parameters, names, self.fields),
            "plain": plain,
            "any_follows": any(g.declared.follows for g in e.parameters),
            "n": e.count.value(size_values(model)),
            "kernels": list(system.values()),
            "sincos_header": pasted("sincos.h") if any(b.trig for b in w.blocks) else "",
            "jet": "",
            "jet_wide": "",
            "reductions": (),
            "events": tables.events(e),
            "cyclic": (),
            "forms": (),
            "n_hoisted": w.hoisted_count,
            "block": block,
            "block_of_more": self._families_of_parameters,
            "parameter_functions": self._parameter_functions(constant and banded, block, plain),
            "sizes": [
                {"c_name": self.places.sizes[s.name], "name": s.name, "value": s.value}
                | {"says": s.description}
                for s in model.sizes
            ],
            "count": index(e.count),
            "first_order": index(e.first_order),
            "n_first_order": e.first_order.value(size_values(model)),
            "unseen": [group(g) for g in e.unseen],
            "rotations": list(introspection.rotations(e, self.places)),
            "groups": [group(g) for g in e.coordinates],
            "families": [group(g) for g in e.families],
            "scalars": [group(g) for g in e.scalars],
            "limits": [self._limit(limit) for limit in e.limits],
            "layouts": layouts,
            "K": layouts.get("K"),
            "K_rings": any(g.periodic for g in e.families),
            "regions": regions,
            "carried": chain_context(plan.chain),
            "extended": e.extended,
            "band": banded,
            "inner": "whole_" if e.carried else "",
            "inner_vectors": [
                {"name": kernel, "outputs": list(outputs)}
                for kernel, outputs in within(e).items()
                if kernel in plan.vectors
            ],
            **bound_context(e, self.places),
            "solved": e.solved,
            "plan": plan,
            "vectors": kernels,
            "with_mass": {"mass", "inertia"} & self.kernels,
            "with_inertia": e.bound or ("inertia" in self.kernels and not e.carried),
            "with_canonical": "canonical" in self.kernels,
            "with_multipliers": self.with_multipliers,
            "with_slopes": plan.slopes is not None,
            "closed": "slopes_closed" in plan.matrices,
            "answered": answered,
            "pulled": "slopes_closed" in plan.matrices and bool(e.bound or e.solved),
            "scalar_kernels": [k for k in TOTALS if k in plan.totals],
            "says": {name: spec_of(name).says for name in (*VECTORS, *TOTALS, *self.outputs)},
            "outputs": {k: x.statements for k, x in self.outputs.items() if self._there(k)},
            "arrays": {k: SAMPLING.get(k, ("out",)) for k in self.outputs},
            "reset_kernels": [x.kernel for x in model.resetting],
            "held": tables.held(e),
            "reset_events": tables.reset_events(e),
            **introspection.outputs_of_members(e, self.places, plan),
            "singularities": list(introspection.singularities(e)),
            "pivots": ("mass" if divides(e) else "pivots") if e.pivots else "",
            "before": self.before,
            "accelerates": accelerates,
            "rated": [(ids[name], x, group(e.group(name))) for name, x in plan.rates.items()],
            "lets": [self._lets(k, found) for k, found in plan.along.items()],
            "switches": list(switches(e, self.places)),
            "divides": divides(e),
            "same_as_force": self._same_as_force,
            "constant_mass": constant,
            "masses": [block.value for block in plan.masses],
            "checked": "mass" in plan.vectors or bool(plan.masses),
            "alike": [(group(g), plan.alike[g.name].value) for g in e.coordinates if plan.alike],
            "helpers": helpers(w.helpers),
            "float_too": w.work.constants.float_too,
            "operations": list(self._operations()),
            "proved": labelled(facts(e, e.facts)),
            "constant": labelled(invariants(e, e.facts)),
            "stepper": self.fused,
            "lag": self.lag,
            "kicks": self.kicks,
        }
        text = KernelText(model.name, self.numbers, self.readers, self.block)

        def made_of(end: str) -> list[str]:
            """Returns pointers to the matrices of recurrences in one layout."""
            return [f"&{model.name}_{x.name}_{end}of" for x in plan.made]

        found["made_of"] = made_of
        tables_of = self._tables(text, layouts)  # It notes which readers are used.
        found |= {
            "text": text,
            "tables_of": (self.readers.text + tables_of).rstrip() + "\n",
            "numbers": self.numbers,
        }
        found |= {
            "headers": partial(headers, self.block),
            "vector_texts": self.vectors,
            "total": self._total,
        }
        # All ranges are known now: behind them in `at_` are the places of the regions.
        room = 3 * len(self.numbers.rows) + len(self.numbers.more)
        at = "p->at_" if room or regions else "NULL"
        state = f"const struct pk_members state = {{p, {at}, 0, NULL, NULL, NULL}}"
        found |= {"sizes_alone": f"{state}, *const x = &state;"}
        return found | {"room": room, "with_at": room or regions, "at": at}

    @property
    def _families_of_parameters(self) -> bool:
        return any(g.is_family for g in self.e.parameters)

    def _layouts(self) -> dict[str, Layout]:
        found = {}
        if "inertia" in self.plan.matrices:
            found["K"] = layout_of_k(self.e, self.plan, self.numbers)
        if self.plan.slopes is not None:
            found["slopes"] = layout_of_slopes(self.e, self.plan.slopes, self.numbers)
        return found

    def _vector(self, text: KernelText, vector: Vector) -> str:
        """Returns the functions that the C text of a vector needs before its kernel."""
        made = VectorText(vector, self.e, self.places, self.readers, self.block)
        self.vectors[vector.name] = made
        unused = vector.name == "acceleration" and self._same_as_force and not vector.kicks
        return text.functions(vector.terms) + ("" if unused else made.functions)

    def _tables(self, text: KernelText, layouts: dict[str, Layout]) -> str:
        """Returns all functions of terms, and the tables of matrices and lists."""
        plan = self.plan
        vectors = (*plan.vectors.values(), *plan.rates.values())
        parts = [self._vector(text, x) for x in vectors]
        if plan.chain and plan.chain.elimination:
            found = (rows.vector for rows in plan.chain.elimination.mass)
            parts += [self._vector(text, vector) for vector in found if vector.outputs]
        for key, kernel in plan.matrices.items():
            of = layouts["slopes" if key.startswith("slopes") else "K"]
            parts.append(text.matrix(kernel, of.unknowns))
        for item, kernel in zip(self.e.carried, plan.made, strict=False):
            if "K" in layouts:
                parts.append(text.matrix(kernel, layouts["K"].unknowns))
            if "slopes" in layouts:
                carried = {g.name for g in self.e.carried_groups}
                known = {
                    name: number
                    for (kind, name), number in layouts["slopes"].unknowns.items()
                    if kind == ("rate" if name in carried else "v")
                }
                known["made", item.group.name] = layouts["slopes"].unknowns[
                    "hung_p", item.group.name
                ]
                parts.append(text.matrix(kernel, known, "slopes_", "K" not in layouts))
        parts += map(text.functions, (*plan.totals.values(), *plan.along.values()))
        written = (terms for rows in plan.written.values() for terms, _ in rows)
        parts.append(text.functions(written))
        parts.append(text.terms_table("singularity_terms", plan.singularities))
        parts.append(text.terms_table("switching_terms", plan.switches))
        if plan.chain:
            for levels in plan.chain.carrying.levels.values():
                parts.append(text.functions(x.terms for x in levels))
        return "".join(parts)

    def _lets(self, k: int, found: list[Terms]) -> tuple[int, str, str, list[dict[str, Any]]]:
        """Returns the number of a pass along members, its range, and what it computes."""
        parts = [x for item in self.e.along[k] for x in item.parts]
        ends = [[self.places.index(x.over[end]) for x in parts] for end in (0, 1)]
        rows = [
            {"terms": terms, "lo": lo, "hi": hi, "place": self.places.index(place)}
            for terms, x, lo, hi in zip(found, parts, *ends, strict=True)
            for place in [self.places.let(x.to[0][0], M)]
        ]
        return k, extreme(ends[0], "pk_least"), extreme(ends[1], "pk_most"), rows

    def _total(self, found: list[Terms]) -> str:
        """Returns the C lines that return a total."""
        name, parts, lines = self.e.model.name, [], []
        for terms in found:
            if terms.is_pairs:
                adding = ["pk_add_up(o[0], n, 1, eight);"]
                lines.append(Scope([*pair_loop(name, self.places, terms, adding)]))
                continue
            lo, hi = map(self.places.index, terms.over or (Affine(), Affine()))
            parts.append(f"pk_sum(x, {name}_{terms.name}, {lo}, {hi})")
        if lines:
            lines.insert(0, "pk_real eight[8] = {0};")
            parts.append("pk_whole(eight)")
        if not parts:
            lines.append("(void)x;")
        return "\n".join(rendered([*lines, f"return {' + '.join(parts) or 0};"]))

    def _parameter_functions(self, factored: bool, block: bool, plain: bool) -> str:
        e, w = self.e, self.lowering
        rows = [
            parameters.code(g, self.places, self.bounds[k], self.defaults[k], k, e.summed)
            for k, g in enumerate(e.parameters)
        ]
        return parameters.functions(
            e.model.name,
            rows,
            self.starts,
            w.hoisted_count,
            w.prepare,
            factored=factored,
            bound=bool(e.bound),
            block=block,
            fixed=self.before.fixed,
            tables=self.fields,
            summed=e.summed,
            plain=plain,
        )

    def _system_kernels(self) -> dict[str, dict[str, Any]]:
        """Returns the kernels of struct pk_system by name. M and the Jacobians are left out, since
        the struct's members for them write dense matrices."""
        e, out = self.e, ("out",)
        found = {"acceleration": ("a",)} | {k: VECTORS.get(k, ()) for k in self.kernels}
        found |= {"singularity": out} if e.singularities or e.pivots else {}
        found |= {"switching": out} if e.switches else {}
        found |= {k: SAMPLING.get(k, out) for k in self.outputs if self._there(k)}
        return {
            name: {"name": name, "result": KERNELS[name].result, "given": ()}
            | {"outputs": [{"name": output} for output in found[name]]}
            for name in KERNELS
            if name in found and name not in ("mass", "jacobian", "inertia")
        }

    def _there(self, kernel: str) -> bool:
        return bool(self.outputs[kernel].targets or kernel in self.plan.written)

    def _limit(self, limit: Limit) -> dict[str, str]:
        unless = "" if limit.unless is None else self.places.index(limit.unless)
        return {"needs": self.places.index(limit.needs), "unless": unless}

    def _operations(self) -> Iterator[str]:
        for key, kernel in self.plan.vectors.items():
            if key in VECTORS or key in ("acceleration", "mass", "divide"):
                found = sum((block.operations for block in kernel.blocks), Counter())
                yield f"{key}: {operations_text(found)} a member"
        for key in TOTALS:
            terms = [x for x in self.plan.totals.get(key, ()) if x.over]
            if terms:
                found = sum((x.block.operations for x in terms), Counter())
                yield f"{key}: {operations_text(found)} a member"
        if self.plan.chain:
            yield from self.plan.chain.operations


def _told(e: FamilyEquations) -> Structure:
    """Returns the facts for the runtime's table. For equations solved for the accelerations, p = v
    and p' = a, so the mass matrix M is 1."""
    one = {"mass_constant": True, "mass_diagonal": True, "quadratic": True}
    return replace(e.facts, **one) if e.solved else e.facts
