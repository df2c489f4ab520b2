"""Collects the C of a binding: the model, its interface pk_host.h, and the runtime files that they
need. Each public symbol is prefixed with the model's name: a program may link several models."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

from pkgen.back.exported import Exported
from pkgen.back.host.data import interface
from pkgen.back.library import Target, library
from pkgen.back.runtime import licence, public_names

HERE = Path(__file__).parent / "templates"
# Names of the runtime that are whole, not pasted by ##.
_NAME = re.compile(r"\bpk_\w*\w\b(?!\s*##)")


def _files(model: Exported) -> dict[str, str]:
    return model.with_runtime(interface(model.name, model.own, model.description))


def sources(model: Exported) -> dict[str, str]:
    """Returns the C sources, by path. They compile without -I and -D."""
    files = _files(model)
    shared = [text for path, text in files.items() if path not in model.files]
    said = {name for text in shared for name in _NAME.findall(text)}
    names = sorted({*public_names(files), *said})
    prefixed = "".join(f"#define {n} {model.name}_{n}\n" for n in names)
    files = {path: _first(path, text) for path, text in files.items()}
    return {**files, "names.h": prefixed, "LICENSE": licence()}


def shared(model: Exported, target: Target | None) -> bytes:
    """Returns the C, compiled to a shared library that exports only the functions of pk_host.h."""
    return library(_files(model), "pk_host_", target)


def _first(path: str, text: str) -> str:
    """Returns the text of a file; a C source gets an #include of names.h before its first line."""
    if not path.endswith(".c"):
        return text
    names = posixpath.relpath("names.h", posixpath.dirname(path) or ".")
    return f'#include "{names}"\n{text}'
