"""Finds the files of the runtime that a C file needs; an export contains only these.

The search reads the text, without a compiler: a file needs the files that define the `pk_` names in
it, and the headers that it includes. tests/test_architecture.py compares the result with a
linker's. The search covers only the runtime's core, which links with libm alone.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from ..system.toolchain import RUNTIME

_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)
_PUBLIC = re.compile(r"^([ \t]*#[ \t]*include[ \t]*)<(pk/[^>]+)>", re.MULTILINE)
_WITH_RUNTIME = "#ifndef PK_RUNTIME\n#define PK_RUNTIME\n#endif\n"
_OWN_TABLES = '#ifndef PK_OWN_TABLES\n#define PK_OWN_TABLES "../../../{}"\n#endif\n'
_NAME = re.compile(r"\bpk_\w+")
# In code formatted by clang-format each definition starts at the beginning of a line.
_FUNCTION = re.compile(r"^(?:\w[^;{}=#]*?)\b(pk_\w+)\([^;{}]*\)\s*\{", re.MULTILINE)
_OBJECT = re.compile(r"^const [^;{}()=]*?\b(pk_\w+)(?:\[[^\]]*\])*\s*=", re.MULTILINE)
_PROTOTYPE = re.compile(r"^[a-z][^;{}#]*\([^;{}#]*;", re.MULTILINE)
_LOCAL = ("static", "extern", "typedef")
_ROWS = re.compile(r"^PK_METHODS_(\w+)\(PK_DEFINE_METHOD", re.MULTILINE)
_FAMILY = re.compile(r"#define PK_METHODS_(\w+)\(X, A\)((?:.*\\\n)+.*)")
_ROW = re.compile(r"X\(A, (\w+),[^\"]*?(\w+),\s*\\?\s*\"")  # Groups: method, tableau.
_TABLES = re.compile(r"(?<!extern )const struct pk_gauss pk_##\w+##_table")
_REGISTRY = re.compile(r"\bPK_METHODS_CORE\((?!PK_DECLARE_METHOD|X\b)")  # all methods


def sources(texts: Iterable[str]) -> dict[str, str]:
    """Returns the files of the runtime that C sources with the given texts need, directly or
    through other files of the runtime. Keys are paths in the runtime, such as `src/core/root.c`."""
    found: dict[str, str] = {}
    waiting = list(texts)
    while waiting:
        for path in needed(waiting.pop()):
            if path not in found:
                found[path] = _read(path)
                waiting.append(found[path])
    return dict(sorted(found.items()))


def alone(files: Mapping[str, str], own: str = "") -> dict[str, str]:
    """Returns the files, changed so that they compile without -I and -D. They include the runtime's
    headers by relative paths and define PK_RUNTIME. If `own` is the name of a file with tables of
    methods, they define PK_OWN_TABLES as this file."""
    tables = _OWN_TABLES.format(own) if own else ""
    homes = _headers()

    def placed(path: str, text: str) -> str:
        here = posixpath.dirname(path)
        found = _PUBLIC.sub(
            lambda m: f'{m[1]}"{posixpath.relpath(homes.get(m[2], m[2]), here or ".")}"', text
        )
        return (
            f"{_WITH_RUNTIME}{tables}{found}"
            if not path.startswith(("include/", "src/"))
            else found
        )

    return {path: placed(path, text) for path, text in files.items()}


def public_names(files: Iterable[str]) -> list[str]:
    """Returns the names with external linkage that some files of the runtime define."""
    files = set(files)
    return [name for name, home in _homes().items() if home in files]


def licence() -> str:
    return _read("LICENSE")


def needed(text: str) -> list[str]:
    """Returns the files of the runtime that a C text needs directly: the headers that it includes,
    and the files that define names in it."""
    headers, homes = _headers(), _homes()
    included = _INCLUDE.findall(text)
    included = [name if name.startswith("pk/") else Path(name).name for name in included]
    found = [headers[name] for name in included if name in headers]
    text = _PROTOTYPE.sub("", _COMMENT.sub("", text))
    names = _NAME.findall(text)
    if _REGISTRY.search(text):
        names += [name for name in homes if name.startswith("pk_method_")]
    for family in _ROWS.findall(text):
        for _, table in _ROW.findall(_rows()[family]):
            names += [f"pk_{table}_table", *([f"pk_method_{table}"] * ("pk_method_##" in text))]
    return found + [homes[name] for name in dict.fromkeys(names) if name in homes]


@cache
def _read(path: str) -> str:
    return (RUNTIME / path).read_text(encoding="utf-8")


@cache
def _headers() -> dict[str, str]:
    """Returns the paths of headers: of public ones by their #include path, of the core's by their
    file name, which is unique."""
    public = sorted((RUNTIME / "include").rglob("*.h"))
    found = {path.relative_to(RUNTIME / "include").as_posix(): path for path in public}
    found |= {path.name: path for path in sorted((RUNTIME / "src").rglob("*.h"))}
    return {name: path.relative_to(RUNTIME).as_posix() for name, path in found.items()}


@cache
def _rows() -> dict[str, str]:
    """Returns for each family of integration methods its rows in pk/methods.h, as text."""
    return dict(_FAMILY.findall(_read("include/pk/methods.h")))


@cache
def _homes() -> dict[str, str]:
    """Returns for each name with external linkage the C file of the core that defines it. The
    methods of a family are rows of a macro in pk/methods.h; the C file of the family defines them
    by expanding this macro."""
    rows = _rows()
    found: dict[str, str] = {}
    for path in sorted((RUNTIME / "src").rglob("*.c")):
        place = path.relative_to(RUNTIME).as_posix()
        text = _COMMENT.sub("", _read(place))
        for pattern in (_FUNCTION, _OBJECT):
            heads = pattern.finditer(text)
            found |= {head[1]: place for head in heads if not head[0].startswith(_LOCAL)}
        for family in _ROWS.findall(text):
            found |= {f"pk_method_{name}": place for name, _ in _ROW.findall(rows[family])}
        if _TABLES.search(text):
            found |= {f"pk_{t}_table": place for _, t in _ROW.findall(rows["COLLOCATION"])}
    return found
