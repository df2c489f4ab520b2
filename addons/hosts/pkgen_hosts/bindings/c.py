"""The C of the bindings: the model, its interface, their part of the runtime. Each public symbol
is prefixed with the model's name, so that a program may link several models."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

from pkgen.back.exported import Exported
from pkgen.back.host.data import interface
from pkgen.back.library import Target, library
from pkgen.back.runtime import licence, public_names

HERE = Path(__file__).parent / "templates"
_NAME = re.compile(r"\bpk_\w*\w\b(?!\s*##)")  # of structs too, as they look like functions


def _files(model: Exported) -> dict[str, str]:
    return model.with_runtime(interface(model.name, model.own, model.description))


def sources(model: Exported) -> dict[str, str]:
    """Returns C sources that compile without -I and -D."""
    files = _files(model)
    shared = [text for path, text in files.items() if path not in model.files]
    said = {name for text in shared for name in _NAME.findall(text)}
    names = sorted({*public_names(files), *said})
    prefixed = "".join(f"#define {n} {model.name}_{n}\n" for n in names)
    files = {path: _first(path, text) for path, text in files.items()}
    return {**files, "names.h": prefixed, "LICENSE": licence()}


def shared(model: Exported, target: Target | None) -> bytes:
    """Returns the same as a shared library that exports the interface alone."""
    return library(_files(model), "pk_host_", target)


def _first(path: str, text: str) -> str:
    """Returns the text of a C file with an #include of the model's prefixed names first."""
    if not path.endswith(".c"):
        return text
    names = posixpath.relpath("names.h", posixpath.dirname(path) or ".")
    return f'#include "{names}"\n{text}'
