"""Makes a Julia package: it calls a shared library by ccall, and has y' for OrdinaryDiffEq.jl."""

from __future__ import annotations

import json
import uuid

from pkgen.back.exported import TARGET_OPTION, Exported, Host
from pkgen.back.host.data import tables
from pkgen.back.library import TARGETS, named, this_machine
from pkgen.back.runtime import licence
from pkgen.back.templates import filled

from .c import HERE, shared
from .names import step


def make(model: Exported) -> dict[str, bytes]:
    of = model.description
    package = "".join(word.capitalize() for word in model.name.split("_"))
    rows = tables(of)
    context = {
        "name": model.name,
        "package": package,
        "uuid": uuid.uuid5(uuid.NAMESPACE_URL, f"pkgen/{model.name}/{of['sha256']}"),
        "title": of["title"],
        "run": {**of["run"], "step": step(of)},
        "lists": {kind: [_string(q["name"]) for q in found] for kind, found in rows.items()},
        "units": [_string(p["unit"]) for p in rows["parameters"]],
    }
    files = {
        "Project.toml": filled(HERE, "Project.toml.j2", **context).encode(),
        f"src/{package}.jl": filled(HERE, "package.jl.j2", **context).encode(),
        "LICENSE": licence().encode(),
    }
    asked = model.options.target
    for target in named(asked) if asked else [None]:
        there = target or TARGETS[this_machine()]
        files[f"lib/{there.name}{there.suffix}"] = shared(model, target)
    return files


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("$", "\\$")


JULIA = Host(
    "julia",
    "a package that calls a shared library, for OrdinaryDiffEq too",
    make,
    options=(TARGET_OPTION,),
)
