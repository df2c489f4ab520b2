"""A crate: the C is compiled by its build.rs, and what is called is safe."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Mapping
from typing import Any

from ...system.exits import UsageError
from ..c.ctext import visible
from ..exported import Exported, Host
from ..templates import filled
from .c import HERE, sources

_WORDS = """
    abstract as async await become box break const continue crate do dyn else enum extern false
    final fn for gen if impl in let loop macro match mod move mut override priv pub ref return self
    static struct super trait true try type typeof union unsafe unsized use virtual where while
    yield
"""
WORDS = frozenset(_WORDS.split())
TABLES = ("parameters", "inputs", "coordinates", "rates", "outputs", "events")


def make(model: Exported) -> dict[str, bytes]:
    of = model.description
    whole(of)
    name = model.name
    context = {
        "name": name,
        "crate": name.lower(),
        "doc": _doc(of["description"] or of["title"]),
        "title": _doc(of["title"]),
        "fields": fields(of["parameters"]),
        "tables": {kind: [_row(q) for q in rows] for kind, rows in tables(of).items()},
        "run": {**of["run"], "step": float(of["run"]["step"] or 0)},
        "looped": of["looped"],
        "first": next((f for f in fields(of["parameters"]) if not f["count"]), None),
    }
    files = {place("c", path): text for path, text in sources(model).items()}
    for path in ("Cargo.toml", "build.rs", "src/lib.rs"):
        files[path] = filled(HERE, f"{path.rpartition('/')[2]}.j2", **context)
    return {path: text.encode() for path, text in files.items()}


def place(folder: str, path: str) -> str:
    return path if path == "LICENSE" else f"{folder}/{path}"


def whole(description: Mapping[str, Any]) -> None:
    if not description["whole"]:
        raise UsageError("the families are too long to be named one by one: take a smaller --size")


def tables(of: Mapping[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """Names, units and descriptions, in the order of indices."""
    rates = {
        c["index"]: {**c, "name": c["rate"], "unit": c["rate_unit"]} for c in of["coordinates"]
    }
    rates |= {s["index"]: s for s in of["states"]}
    for r in of["rotations"]:
        rates |= {
            k: {"name": n, "unit": r["rate_unit"], "description": r["description"]}
            for k, n in zip(r["rate_indices"], r["rates"], strict=True)
        }
    found = {kind: [q for q in of[kind] if not q.get("hidden")] for kind in TABLES if kind in of}
    found["rates"] = [rates[k] for k in sorted(rates)]
    return {kind: found[kind] for kind in TABLES}


def fields(parameters: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of a family one array; `values` of None follow others."""
    found = []
    for stem, members in itertools.groupby(parameters, lambda p: p["name"].partition("[")[0]):
        rows = list(members)
        first = rows[0]
        family = first["name"] != stem
        word = stem + "_" if stem in WORDS else stem
        values = [None if p["follows"] else p["value"] for p in rows]
        about = ", ".join(w for w in (first["description"], first["unit"]) if w)
        entry = {"name": word, "count": len(rows) if family else 0, "doc": _doc(about)}
        found.append(
            {**entry, "values": ["f64::NAN" if v is None else repr(float(v)) for v in values]}
        )
    return found


def _doc(text: str) -> str:
    return re.sub(r"[\[\]]", r"\\\g<0>", " ".join(text.split()))


def _row(q: Mapping[str, Any]) -> str:
    words = (q["name"], q["unit"], q["description"])
    return ", ".join(_string(w) for w in words)


def _string(text: str) -> str:
    return json.dumps(visible(text), ensure_ascii=False)


RUST = Host("rust", "a crate, whose build.rs compiles the C", make)
