"""LoopEquations -> LoopProgram: what the templates of a model with loops see, as text."""

from __future__ import annotations

from typing import Any

from ...graph.affine import ROW, variable
from ...middle.loops.expand import size_values
from ...middle.loops.loops import Assigned, Facts, LoopEquations
from ...middle.quantities import input_quantities
from ...record import record
from ...version import __version__
from ..facts import loop_facts, loop_invariants
from ..targets import RETURN, STORE, Target
from .describe import labelled
from .helpers import helpers
from .loops import CHUNK, FIXED, INNER, WIDEST_BOND, Block, Lowering
from .loops_plan import TOTALS, VECTORS, emitted, entries, planned
from .loops_sets import Builder
from .loops_tables import named, quantity, row, system_kernels
from .loops_text import Text
from .program import operations_text
from .render import FACTS, SYSTEM_KERNELS, pasted

M = variable(ROW)
BLOCK = 16  # chunks of one stage before the next follows
LEAD = 2  # chunks that have drifted before one is kicked
_PAIRED = {"gradient": "gradient", "canonical": "pdot", "force": "force"}
SAYS = {
    "force": "f = pdot - (dp/dq) v - dp/dt",
    "canonical": "p = dL/dv and pdot = dL/dq + Q - dD/dv",
    "momenta": "p = dL/dv",
    "gradient": "dL/dq",
    "energy": "h = v.p - L",
    "lagrangian": "L",
    "kinetic": "T",
    "potential": "V",
}


@record
class LoopProgram:
    """All that the templates see: strings, numbers and lists of them."""

    name: str
    context: dict[str, Any]


def lower_loops(
    e: LoopEquations, libm: bool = False, wanted: frozenset[str] | None = None
) -> LoopProgram:
    """Blocks of C for a model's loops, with the kernels wanted (None: all); raises Unrolled where a
    row cannot be one."""
    return LoopProgram(e.model.name, _Context(e, emitted(e, wanted)).build(libm))


class _Context:
    def __init__(self, e: LoopEquations, kernels: frozenset[str]):
        self.e = e
        self.kernels = kernels
        self.builder = Builder(e)
        self.diagonal = e.mass.is_diagonal

    def build(self, libm: bool) -> dict[str, Any]:
        plans = planned(self.e, self.builder, self.kernels)
        self.builder.begin(libm)
        lowering = self.lowering = self.builder.lowering
        assert lowering is not None
        sets = {key: [self.builder.rows(p) for p in found] for key, found in plans["rows"].items()}
        band = [self.builder.rows(p, ghosts=False) for p in plans["band"]]
        totals = {key: self.builder.total(p) for key, p in plans["totals"].items()}
        pairs = {
            what: [self.builder.pair(pair) for pair in getattr(self.e, what).pairs]
            for kernel, what in _PAIRED.items()
            if kernel in self.kernels
        }
        pieces = self._pieces(lowering)
        pieces["singularities"] = [self.builder.total(p) for p in plans["singularities"]]
        lowering.finish()
        return self._text(sets, band, totals, pairs, pieces)

    # -- single blocks --------------------------------------------------------------------------

    def _pieces(self, w: Lowering) -> dict[str, Any]:
        e = self.e

        def value(node, where: str) -> Block:
            return w.block([Target(RETURN, "", (node,))], where)

        return {
            "given": {
                key: [value(node, INNER) for node in nodes] for key, nodes in e.given.items()
            },
            "defaults": [self._assigned(w, a) for a in e.defaults],
            "starts": [self._assigned(w, a) for a in e.starts],
            "bounds": [
                w.block(
                    [
                        Target(STORE, name, (node,))
                        for name, node in (("lo", b.lo), ("hi", b.hi))
                        if node is not None
                    ],
                    FIXED,
                )
                for b in e.bounds
            ],
            "observed": w.block(
                [Target(STORE, f"out[{k}]", (n,)) for k, n in enumerate(e.observed)], INNER
            ),
            "conserved": w.block(
                [Target(STORE, f"out[{k}]", (n,)) for k, n in enumerate(e.conserved)], INNER
            ),
        }

    def _assigned(self, w: Lowering, item: Assigned) -> dict[str, Any]:
        group = next(g for g in (*self.e.coordinates, *self.e.parameters) if g.name == item.name)
        is_parameter = any(g is group for g in self.e.parameters)
        place = item.lo if item.lo is not None and item.lo == item.hi else M
        if item.lo is None:
            place = None
        if is_parameter:
            where = w.member(item.name, place)
        else:
            where = w.cell("v" if item.order else "q", item.name, place)
        return {
            "lo": None if place is not M else w.index(item.lo),
            "hi": None if place is not M else w.index(item.hi),
            "block": w.block([Target(STORE, where, (item.node,))], FIXED),
        }

    # -- text -----------------------------------------------------------------------------------

    def _text(self, sets, band, totals, pairs, pieces) -> dict[str, Any]:
        e, w = self.e, self.lowering
        self.text = Text(e, w, self.diagonal)
        model = e.model
        facts: Facts = e.facts
        quantities = {
            "coordinates": [quantity(g, "", "unit") for g in e.coordinates],
            "rates": [quantity(g, "'", "rate_unit") for g in e.coordinates],
            "momentum_names": [quantity(g, "p_", "momentum_unit") for g in e.coordinates],
            "inputs": [row(q) for q in input_quantities(model, e.orders)],
            "observed": [row(q) for q in named(model.observed)],
            "conserved": [row(q) for q in named(model.conserved)],
        }
        acceleration = (
            "direct"
            if self.diagonal and not e.force.pairs
            else ("divide" if self.diagonal else "solve")
        )
        return {
            "version": __version__,
            "name": model.name,
            "description": model.description,
            "source_name": model.source.path.replace("\\", "/").rsplit("/", 1)[-1],
            "source_hash": model.source.sha256,
            "real_header": pasted("real.h"),
            "sincos_header": pasted("sincos.h") if any(b.trig for b in w.blocks) else "",
            "n_parameters": len(e.parameters),
            "n_inputs": len(quantities["inputs"]),
            "n_observed": len(e.observed),
            "n_conserved": len(e.conserved),
            "n_hoisted": w.hoisted_count,
            "prepare": w.prepare,
            "sizes": [
                {
                    "c_name": w.sizes[s.name],
                    "name": s.name,
                    "value": s.value,
                    "says": s.description,
                }
                for s in model.sizes
            ],
            "count": w.index(e.count),
            "default_count": e.count.value(size_values(model)),
            "groups": [self.text.group(g) for g in e.coordinates],
            "families": [self.text.group(g) for g in e.families],
            "scalars": [self.text.group(g) for g in e.scalars],
            "parameters": [self.text.parameter(k, pieces) for k in range(len(e.parameters))],
            "limits": [self.text.limit(limit) for limit in e.limits],
            "readers": self.text.readers(pieces),
            "row_sets": {key: [self.text.rows(s) for s in found] for key, found in sets.items()},
            "band_sets": [
                self.text.rows(s) | {"entries": [entry for entry, _ in entries(self.e, s.group)]}
                for s in band
            ],
            "band": self.text.band(),
            "totals": {key: self.text.total(t) for key, t in totals.items()},
            "pairs": {key: [self.text.pair(s) for s in found] for key, found in pairs.items()},
            "vectors": [
                {
                    "name": kernel,
                    "says": SAYS[kernel],
                    "outputs": [o for o, _ in outputs],
                    "whats": [what for _, what in outputs],
                    "pairs": _PAIRED.get(kernel),
                    "paired": {"force": "f", "gradient": "dLdq", "canonical": "pdot"}.get(kernel),
                }
                for kernel, outputs in VECTORS.items()
                if kernel in self.kernels
            ],
            "with_mass": "mass" in self.kernels,
            "scalar_kernels": [k for k in TOTALS if k in totals],
            "says": SAYS,
            "starts": [self.text.lines(s) for s in pieces["starts"]],
            "defaults": [self.text.lines(s) for s in pieces["defaults"]],
            "observe": self.text.lines({"block": pieces["observed"]}) if e.observed else None,
            "conserve": self.text.lines({"block": pieces["conserved"]}) if e.conserved else None,
            "singularities": self.text.singularities(pieces["singularities"]),
            "n_sums": len(e.sums),
            "chunk": CHUNK,
            "widest": WIDEST_BOND,
            "acceleration": acceleration,
            "constant_mass": facts.mass_constant,
            "facts": [flag for field, flag in FACTS if getattr(facts, field)],
            "tables": [{"name": k, "rows": rows} for k, rows in quantities.items()],
            "helpers": helpers(w.helpers),
            "float_too": w.work.constants.float_too,
            "operations": self._operations(sets, totals),
            "proved": labelled(loop_facts(e)),
            "constant": labelled(loop_invariants(facts)),
            "stepper": self._stepper(sets, acceleration),
            "wraps": any(g.periodic for g in e.families),
            "homes": [
                self.text.group(s.group)
                | {"periodic": s.group.periodic, "ends": self.text.homes(s.group)}
                for s in (band or sets["force" if "force" in sets else "acceleration"])
                if band or s.ghosts or s.group.periodic
            ],
            "fields": SYSTEM_KERNELS,
            "system_kernels": system_kernels(e, self.kernels),
        }

    def _operations(self, sets, totals) -> list[str]:
        rows = []
        for found in sets.values():
            for s in found:
                if s.inner:
                    rows.append(f"{s.name}: {operations_text(s.inner.operations)} a member")
        for key, t in totals.items():
            if t.rows and t.rows.inner and key in TOTALS:
                rows.append(f"{key}: {operations_text(t.rows.inner.operations)} a member")
        return rows

    def _stepper(self, sets, acceleration: str) -> dict[str, Any] | None:
        """Fused steps exist where the acceleration of a row needs q of cells near it and t."""
        e = self.e
        if (
            "advance" not in self.kernels
            or acceleration != "direct"
            or not e.facts.separable
            or e.scalars
            or e.model.inputs
        ):
            return None
        reach = 0
        for s in sets["acceleration"]:
            for block in (s.inner, s.flux, *(g.block for g in s.guarded)):
                if block is None:
                    continue
                for target in block.targets:
                    for node in target.nodes:
                        for slot in self.builder.sets.slots.below(node):
                            if slot.kind == "q" and slot.at is not None:
                                if not slot.at.factor(ROW):
                                    return None  # one member is felt by all
                                reach = max(reach, abs(slot.at.constant))
        spread = [g.lo - e.families[0].lo for g in e.families]
        if not all(x.is_constant for x in spread):
            return None
        if reach > CHUNK:
            return None
        together = not any(g.periodic for g in e.families)
        # What stages in flight hold of q and v stays below 64 KiB: measured against 24 to 144.
        cells = 4096 // len(e.families)
        stages = max(1, (cells - BLOCK * CHUNK) // ((LEAD + 1) * CHUNK)) if together else 1
        rows = sets["acceleration"]
        return {
            "stages": stages,
            "block": BLOCK,
            "lead": LEAD,
            "together": together,
            "lows": list(dict.fromkeys(self.lowering.index(x) for s in rows for x in s.lows)),
            "highs": list(dict.fromkeys(self.lowering.index(x) for s in rows for x in s.highs)),
            "least": [self.lowering.index(g.lo) for g in e.families],
            "greatest": [self.lowering.index(g.hi) for g in e.families],
        }
