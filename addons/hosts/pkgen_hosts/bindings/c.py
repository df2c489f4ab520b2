"""The C of the bindings: the model, its callers, and their part of the runtime. Each public symbol
is prefixed with the model's name, so that a program may link several models."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pkgen.back.exported import Exported
from pkgen.back.library import Target, library
from pkgen.back.runtime import alone, licence, public_names
from pkgen.back.templates import filled
from pkgen.back.wasm_kernels import LIVE, which_model
from pkgen.own import in_c
from pkgen.system.exits import UsageError

HERE = Path(__file__).parent / "templates"
CALLS = ("live.h", "motion.c", "params.c", "values.c")
_NAME = re.compile(
    r"\bpk_\w*\w\b(?!\s*##)"
)  # of structs too, as they look like functions
_EXPORTED = re.compile(r"EXPORT\((live_\w+)\)\(")


def calls(model: Exported) -> dict[str, str]:
    """Returns the C files that call the model, and the one that names it."""
    found = {name: (LIVE / name).read_text(encoding="utf-8") for name in CALLS}
    found["model.c"] = filled(
        HERE,
        "model.c.j2",
        which=which_model(model.name, model.own),
        own_tables=in_c.FILE if model.own else "",
        parameters=[p for p in model.description["parameters"] if _own_value(p, "")],
        inputs=[repr(float(u["value"])) for u in model.description["inputs"]],
        starts=list(starts(model.description)),
    )
    return found | ({in_c.FILE: in_c.tables(model.own)} if model.own else {})


def sources(model: Exported) -> dict[str, str]:
    """Returns C sources that compile without -I and -D, with headers in their own folders."""
    called = calls(model)
    runtime = model.runtime(*called.values())
    files = {f"live/{path}": text for path, text in called.items()}
    files |= {f"model/{path}": text for path, text in model.files.items()}
    files = alone({**files, **runtime})
    said = {name for text in runtime.values() for name in _NAME.findall(text)}
    names = sorted({*public_names(runtime), *said, *NAMES})
    files["names.h"] = "".join(f"#define {n} {model.name}_{n}\n" for n in names)
    files = {path: _first(path, text) for path, text in files.items()}
    return {**files, "LICENSE": licence()}


def shared(model: Exported, target: Target | None) -> bytes:
    """Returns the same as a shared library that exports only symbols with the prefix live_."""
    called = calls(model)
    clash = called.keys() & model.files.keys()
    if clash:
        raise UsageError(f"there is another {clash.pop()} in it: call the model otherwise")
    files = {**model.files, **called, **model.runtime(*called.values())}
    return library(alone(files), "live_", target)


NAMES = [
    *("live_system", "live_own", "live_own_count", "live_reason_text", "live_method", "refuse"),
    *("live_given", "live_begin", "live_inputs"),
    *(n for f in CALLS for n in _EXPORTED.findall((LIVE / f).read_text(encoding="utf-8"))),
]


def _first(path: str, text: str) -> str:
    """Returns the text of a C file with an #include of the model's prefixed names first."""
    if not path.endswith(".c"):
        return text
    names = posixpath.relpath("names.h", posixpath.dirname(path))
    return f'#include "{names}"\n{text}'


def _own_value(item: dict[str, Any], what: str) -> bool:
    """Whether it has a numeric value that does not follow from other parameters."""
    return not item[f"{what}_follows" if what else "follows"] and item[what or "value"] is not None


def starts(description: Any) -> Iterator[str]:
    """Yields C statements that set the start values which do not follow from parameters."""
    for item in description["coordinates"]:
        for what in ("q", "v"):
            if _own_value(item, what):
                yield f"{what}[{item['index']}] = {float(item[what])!r};"
    for item in description["rotations"]:
        keys = ("rate_indices", "rate_values", "rates_follow")
        for k, x, follows in zip(*(item[key] for key in keys), strict=True):
            if x is not None and not follows:
                yield f"v[{k}] = {float(x)!r};"
    for item in description["states"]:
        if _own_value(item, ""):
            yield f"v[{item['index']}] = {float(item['value'])!r};"
