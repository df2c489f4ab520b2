"""Sets of rows, totals and pairs as the strings, numbers and lists that the templates see."""

from __future__ import annotations

from itertools import zip_longest
from typing import Any

from ...graph.affine import ROW, Affine, variable
from ...middle.loops.loops import Group, LoopEquations
from ..targets import STORE
from .loops import Block, Lowering
from .loops_sets import PairSet, RowSet, TotalSet

M = variable(ROW)


def _value(block: Block) -> str:
    """Of a block that is one expression."""
    [statement] = block.statements
    return statement.text


class Text:
    """One for each model, once its blocks are written."""

    def __init__(self, e: LoopEquations, lowering: Lowering, diagonal: bool):
        self.e, self.lowering, self.diagonal = e, lowering, diagonal

    def group(self, g: Group) -> dict[str, Any]:
        w, declared = self.lowering, g.declared
        first = w.first.get(g.name, Affine())
        family = g.is_family
        return {
            "name": g.name,
            "is_family": family,
            "first": w.index(first),
            "lo": w.index(g.lo) if family else "0",
            "hi": w.index(g.hi) if family else "0",
            "count": w.index(g.count),
            "cell": w.index(first + M - g.lo) if family else w.index(first),
            "other": w.index(first + variable("j") - g.lo) if family else w.index(first),
            "says": " ".join(
                x
                for x in (declared.description, f"[{declared.unit}]" if declared.unit else "")
                if x
            ),
            "lo_text": g.lo.text() if family else "",
            "hi_text": g.hi.text() if family else "",
            "first_text": first.text(),
        }

    def parameter(self, k: int, pieces) -> dict[str, Any]:
        w, e = self.lowering, self.e
        group = e.parameters[k]
        item = group.declared
        bounds = e.bounds[k]
        block = pieces["bounds"][k]
        ends = {s.target: s.text for s in block.statements if s.kind == STORE}
        return self.group(group) | {
            "name": item.name,
            "unit": item.unit,
            "description": item.description,
            "c_name": w.fields[item.name],
            "member": w.member(item.name, M if group.is_family else None),
            "index": k,
            "follows": int(item.follows),
            "lo_open": int(item.bounds.lo_open or bounds.lo is None),
            "hi_open": int(item.bounds.hi_open or bounds.hi is None),
            "least": ends.get("lo", "-PK_INFINITY"),
            "greatest": ends.get("hi", "PK_INFINITY"),
            "from": w.index(group.lo) if group.is_family else "",
            "to": w.index(group.hi) if group.is_family else "",
            "needs": [s for s in block.statements if s.kind != STORE],
            "uses_index": "m" in block.words,
        }

    def limit(self, limit) -> dict[str, str]:
        w = self.lowering
        return {
            "needs": w.index(limit.needs),
            "unless": "" if limit.unless is None else w.index(limit.unless),
            "text": limit.needs.text(),
        }

    def readers(self, pieces) -> list[dict[str, Any]]:
        """Functions that read a cell wherever it lies: of q, v, w, d of each family."""
        w, e = self.lowering, self.e
        used = {word for b in w.blocks for word in b.words}
        found = []
        for g in e.families:
            for order, kind in enumerate(("q", "v", "w", "d")):
                name = f"{w.prefix}{kind}_{g.name}"
                if name not in used:
                    continue
                ends = []
                for at, end in g.ends:
                    item = {"at": w.index(at), "kind": end.kind, "lines": []}
                    if end.kind == "free":
                        item["home"] = w.index(
                            w.first[g.name] + (g.lo if at == g.lo - 1 else g.hi) - g.lo
                        )
                    elif kind != "d":
                        item["lines"] = pieces["given"][g.name, at][order].statements
                    ends.append(item)
                found.append(
                    self.group(g)
                    | {"reader": name, "kind": kind, "ends": ends, "periodic": g.periodic}
                )
        return found

    def lines(self, item: dict[str, Any]) -> dict[str, Any]:
        return {k: v for k, v in item.items() if k != "block"} | {"lines": item["block"].statements}

    def rows(self, s: RowSet) -> dict[str, Any]:
        w = self.lowering
        group = self.group(s.group) if s.group else {"name": s.name}
        return {
            "name": s.name,
            "group": group,
            "outputs": s.outputs,
            "inner": s.inner.statements,
            "trig": s.inner.trig or bool(s.flux and s.flux.trig),
            "inner_trig": s.inner.trig,
            "flux": s.flux.statements if s.flux else None,
            "flux_trig": bool(s.flux and s.flux.trig),
            "n_flux": s.n_flux,
            "span": s.span,
            "plain": s.plain,
            "scale": _value(s.scale) if s.scale else "",
            "guarded": [
                {"lo": w.index(g.lo), "hi": w.index(g.hi), "lines": g.block.statements}
                for g in s.guarded
            ],
            "lows": [w.index(x) for x in s.lows],
            "highs": [w.index(x) for x in s.highs],
            "firsts": list(dict.fromkeys(w.index(g.lo) for g in s.guarded)),
            "lasts": list(dict.fromkeys(w.index(g.hi) for g in s.guarded)),
            "ghosts": s.ghosts,
            "below": s.below,
            "above": s.above,
            "ends": self.homes(s.group) if s.group else [],
            "periodic": bool(s.group and s.group.periodic),
        }

    def homes(self, g: Group) -> list[dict[str, str]]:
        """Ghosts that stand for a cell: free ends."""
        w = self.lowering
        return [
            {"at": w.index(at), "home": w.index(g.lo if at == g.lo - 1 else g.hi)}
            for at, end in g.ends
            if end.kind == "free"
        ]

    def total(self, t: TotalSet) -> dict[str, Any]:
        w = self.lowering
        return {
            "name": t.name,
            "constant": t.constant.statements,
            "rows": self.rows(t.rows) if t.rows else None,
            "pairs": [
                {
                    "lo": w.index(p.lo),
                    "hi": w.index(p.hi),
                    "first": w.index(p.first),
                    "last": w.index(p.last),
                    "lines": b.statements,
                }
                for p, b in t.pairs
            ],
        }

    def singularities(self, sets: list[TotalSet]) -> dict[str, Any]:
        """The kernel's sets of values, and what the tables say of each: M's pivots come first."""
        e = self.e
        entries = []
        if e.pivots:
            for g in e.coordinates:
                ends = (g.lo, g.hi) if g.is_family else ()
                at = "[i]" if g.is_family else ""
                entries.append(self._singularity(f"the pivot of {g.name}{at}", "COORDINATES", ends))
        for singularity in e.singularities:
            [over] = [
                *((p.lo, p.hi) for p in singularity.terms.parts),
                *((p.lo, p.hi, p.first, p.last) for p in singularity.terms.pairs),
            ] or [()]
            entries.append(self._singularity(singularity.name, singularity.use, over))
        pivots = ("mass" if self.diagonal else "pivots") if e.pivots else ""
        return {"sets": [self.total(t) for t in sets], "entries": entries, "pivots": pivots}

    def _singularity(self, text: str, use: str, over: tuple[Affine, ...]) -> dict[str, str]:
        found = {"name": text, "kind": f"PK_SINGULARITY_{use}"}
        for key, at in zip_longest(("lo", "hi", "first", "last"), over):
            found[key] = "" if at is None else self.lowering.index(at)
            found[f"{key}_text"] = "" if at is None else at.text({ROW: "i"})
        return found

    def pair(self, s: PairSet) -> dict[str, Any]:
        w, f = self.lowering, s.force
        groups = {g.name: self.group(g) for g in self.e.coordinates}
        count = len(f.by_row)
        return {
            "lo": w.index(f.lo),
            "hi": w.index(f.hi),
            "first": w.index(f.first),
            "last": w.index(f.last),
            "lines": s.block.statements,
            "outputs": count + len(f.by_other) + len(f.by_scalar),
            "by_row": [{"k": k, "at": groups[n]["cell"]} for k, (n, _) in enumerate(f.by_row)],
            "by_other": [
                {"k": count + k, "at": groups[n]["other"]} for k, (n, _) in enumerate(f.by_other)
            ],
            "by_scalar": [
                {"k": count + len(f.by_other) + k, "at": groups[n]["first"]}
                for k, (n, _) in enumerate(f.by_scalar)
            ],
        }

    def band(self) -> dict[str, Any] | None:
        """The shape of M: cells interleaved by index, then scalar coordinates as a border."""
        e = self.e
        if self.diagonal:
            return None
        names = [g.name for g in e.families]
        count = len(names)
        width = max(
            (
                abs(shift * count + names.index(b) - names.index(a))
                for a, b, shift in e.mass.entries
            ),
            default=0,
        )
        return {
            "width": width,
            "periodic": any(g.periodic for g in e.families),
            "corner": [{"a": a, "b": b, "key": f"mass_{a}_{b}"} for a, b in e.mass.corner],
            "scalars": [g.name for g in e.scalars],
        }
