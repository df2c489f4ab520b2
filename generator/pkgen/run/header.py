"""ctypes structures and functions of pk/run.h and pk/stability.h, parsed from the headers."""

from __future__ import annotations

import ctypes
import re
from ctypes import CFUNCTYPE, POINTER, Structure

from ..system.toolchain import RUNTIME

_COMMENT = re.compile(r"/\*.*?\*/", re.S)
_STRUCT = re.compile(r"struct (\w+) \{(.*?)\n\};", re.S)
_FUNCTION = re.compile(r"^((?:const )?[\w ]+ \*?)(pk_(?:run|stability)_\w+)\(([^;]*)\);", re.M)
# Matches a type, then either names with stars or a function pointer with its arguments.
_DECLARED = re.compile(r"(?:const )?((?:struct |enum |unsigned )?\w+) ([^(]+|\(\*(\w+)\)\((.*)\))")
_PLAIN: dict[str, object] = {
    "void": None,
    "char": ctypes.c_char,
    "int": ctypes.c_int,
    "unsigned": ctypes.c_uint,
    "long": ctypes.c_long,
    "unsigned long": ctypes.c_ulong,
    "size_t": ctypes.c_size_t,
    "double": ctypes.c_double,
    "enum pk_run_code": ctypes.c_int,
}


def _type(name: str, stars: int) -> object:
    """Returns the ctypes type; a pointer to an unknown type is a void pointer."""
    found = _PLAIN[name] if name in _PLAIN else STRUCTURES.get(name)
    if stars and (found is None or name == "char"):
        found = ctypes.c_char_p if name == "char" else ctypes.c_void_p
        stars -= 1
    for _ in range(stars):
        found = POINTER(found)
    return found


def _declared(text: str) -> list[tuple[str, object]]:
    """Parses a declaration, `double a, *b` or a function pointer; returns names and types."""
    name, names, function, arguments = _DECLARED.fullmatch(" ".join(text.split())).groups()
    if function:
        return [(function, CFUNCTYPE(_type(name, 0), *_arguments(arguments)))]
    each = (word.strip() for word in names.split(","))
    return [(word.lstrip("*"), _type(name, word.count("*"))) for word in each]


def _arguments(text: str) -> list[object]:
    return [] if text == "void" else [_declared(one)[0][1] for one in text.split(",")]


STRUCTURES: dict[str, type[Structure]] = {}
FUNCTIONS: dict[str, tuple[object, list[object]]] = {}  # name: (result, arguments)
for _header in ("run.h", "stability.h"):
    _text = _COMMENT.sub("", (RUNTIME / "include/pk" / _header).read_text(encoding="utf-8"))
    for _name, _members in _STRUCT.findall(_text):
        _fields = [field for one in _members.split(";") if one.strip() for field in _declared(one)]
        STRUCTURES[f"struct {_name}"] = type(_name, (Structure,), {"_fields_": _fields})
    for _result, _name, _given in _FUNCTION.findall(_text):
        ((_, _made),) = _declared(f"{_result}result")
        FUNCTIONS[_name] = (_made, _arguments(_given))

_text = (RUNTIME / "include/pk/status.h").read_text(encoding="utf-8")
STATUSES = {int(n): name for name, n in re.findall(r"X\((PK_\w+), (-?\d+), ", _text)}
