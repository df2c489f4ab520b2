"""Makes a Rust crate: its build.rs compiles the C, and its public functions are safe Rust."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Mapping
from typing import Any

from pkgen.back.c.ctext import visible
from pkgen.back.exported import Exported, Host
from pkgen.back.host.data import tables
from pkgen.back.templates import filled

from .c import HERE, sources
from .names import step

_WORDS = """
    abstract as async await become box break const continue crate do dyn else enum extern false
    final fn for gen if impl in let loop macro match mod move mut override priv pub ref return self
    static struct super trait true try type typeof union unsafe unsized use virtual where while
    yield
"""
WORDS = frozenset(_WORDS.split())


def make(model: Exported) -> dict[str, bytes]:
    of = model.description
    name = model.name
    context = {
        "name": name,
        "crate": name.lower(),
        "doc": _doc(of["description"] or of["title"]),
        "title": _doc(of["title"]),
        "fields": fields(of["parameters"]),
        "tables": {kind: [_row(q) for q in rows] for kind, rows in tables(of).items()},
        "run": {**of["run"], "step": step(of)},
        "looped": of["looped"],
        "first": next((f for f in fields(of["parameters"]) if not f["count"]), None),
    }
    files = {place("c", path): text for path, text in sources(model).items()}
    for path in ("Cargo.toml", "build.rs", "src/lib.rs"):
        files[path] = filled(HERE, f"{path.rpartition('/')[2]}.j2", **context)
    return {path: text.encode() for path, text in files.items()}


def place(folder: str, path: str) -> str:
    return path if path == "LICENSE" else f"{folder}/{path}"


def fields(parameters: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Returns the fields of the Rust `struct Parameters`. A family of parameters is one array
    field. A default of NaN marks a parameter that is computed from other parameters unless it is
    set."""
    found = []
    for stem, members in itertools.groupby(parameters, lambda p: p["name"].partition("[")[0]):
        rows = list(members)
        first = rows[0]
        family = first["name"] != stem
        word = (stem + "_" if stem in WORDS else stem).replace(".", "_")
        values = [None if p["follows"] else p["value"] for p in rows]
        about = ", ".join(w for w in (first["description"], first["unit"]) if w)
        entry = {"name": word, "count": len(rows) if family else 0, "doc": _doc(about)}
        found.append(
            {**entry, "values": ["f64::NAN" if v is None else repr(float(v)) for v in values]}
        )
    return found


def _doc(text: str) -> str:
    """Escapes text for a comment of rustdoc, which interprets Markdown and HTML."""
    return re.sub(r"[\[\]\\`<>&]", r"\\\g<0>", " ".join(text.split()))


def _row(q: Mapping[str, Any]) -> str:
    words = (q["name"], q["unit"], q["description"])
    return ", ".join(_string(w) for w in words)


def _string(text: str) -> str:
    return json.dumps(visible(text), ensure_ascii=False)


RUST = Host("rust", "a crate, whose build.rs compiles the C", make)
