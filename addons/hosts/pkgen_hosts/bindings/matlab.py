"""Makes a MEX function for MATLAB and Octave, and .m functions that take names and values."""

from __future__ import annotations

from pkgen.back.exported import Exported, Host
from pkgen.back.host.data import tables
from pkgen.back.templates import filled

from .c import HERE, sources
from .names import step
from .rust import place


def make(model: Exported) -> dict[str, bytes]:
    of, name = model.description, model.name
    c = {place("c", path): text for path, text in sources(model).items()}
    c["c/gateway.c"] = '#include "names.h"\n' + filled(HERE, "gateway.c.j2", name=name)
    named = tables(of)
    context = {
        "name": name,
        "title": of["title"],
        "run": {**of["run"], "step": step(of)},
        "sources": [path for path in c if path.endswith(".c")],
        "lists": {kind: _cells([q["name"] for q in rows]) for kind, rows in named.items()},
        "n_q": len(named["coordinates"]),
        "n": len(named["rates"]),
        "example": next((p["name"] for p in named["parameters"] if "[" not in p["name"]), ""),
    }
    files = {f"{name}{end}.m": filled(HERE, f"matlab{end}.m.j2", **context) for end in ENDS}
    files["build.m"] = filled(HERE, "build.m.j2", **context)
    return {path: text.encode() for path, text in {**c, **files}.items()}


ENDS = ("", "_values", "_rates")


def _cells(names: list[str]) -> str:
    quoted = ("'" + name.replace("'", "''") + "'" for name in names)
    return "{" + ", ".join(quoted) + "}"


MATLAB = Host("matlab", "MEX for MATLAB and Octave, with functions over it", make)
