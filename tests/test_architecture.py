"""The floor plan: arrows run one way, no circle among files, and few files at each root.

`FLOORS` is docs/architecture.md as data. A folder may use those on floors below its own.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from conftest import ROOT

PKGEN = ROOT / "generator" / "pkgen"
FLOORS = """
system source limits functions __init__
tree methods
model indices front
graph
equations front/check
middle middle/points
middle/expand middle/analyze
middle/particles
middle/derive
middle/reduce middle/loops
back/c loop_proofs
compiler
run
scenes
analysis/chart
analysis/choose analysis/stability explain
cli
__main__
"""
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS.split("\n")) for room in rooms.split()}


def _modules() -> dict[str, Path]:
    found = {}
    for path in sorted(PKGEN.rglob("*.py")):
        parts = path.relative_to(PKGEN.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


MODULES = _modules()


def _imported(name: str) -> Iterator[str]:
    """The modules that a module names in `import`, those for its annotations among them."""
    path = MODULES[name]
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = package.split(".")[: len(package.split(".")) - node.level + 1]
            base = ".".join([*base, node.module] if node.module else base)
            for alias in node.names:
                inner = f"{base}.{alias.name}"
                yield inner if inner in MODULES else base


def _included(path: Path, files: Mapping[str, Path]) -> Iterator[str]:
    for name in re.findall(r'^#include [<"]([\w./]+)[>"]', path.read_text(), re.M):
        if name in files:
            yield name


def _room(name: str) -> str:
    folder = MODULES[name].parent.relative_to(PKGEN)
    return MODULES[name].stem if folder == Path() else folder.as_posix()


def _circle(arrows: Mapping[str, set[str]]) -> list[str]:
    """The files of one circle; empty without any."""
    done: set[str] = set()
    for start in arrows:
        path: list[str] = []
        stack = [(start, iter(sorted(arrows[start])))] if start not in done else []
        path += [start] if stack else []
        while stack:
            name, rest = stack[-1]
            target = next(rest, None)
            if target is None:
                stack.pop()
                done.add(path.pop())
            elif target in path:
                return path[path.index(target) :]
            elif target not in done:
                path.append(target)
                stack.append((target, iter(sorted(arrows[target]))))
    return []


PYTHON = {name: set(_imported(name)) - {name} for name in MODULES}


def test_a_circle_is_found() -> None:
    assert _circle({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c"]
    assert _circle({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == []


def test_no_circle_among_modules() -> None:
    assert _circle(PYTHON) == []


def test_arrows_point_down() -> None:
    wrong = [
        f"{name} -> {target}"
        for name, targets in PYTHON.items()
        for target in targets
        if _room(name) != _room(target)
        and FLOOR[_room(target)] >= FLOOR[_room(name)]
        and not MODULES[target].name == "__init__.py"
    ]
    assert wrong == []


def test_every_room_is_used_and_has_a_floor() -> None:
    assert {_room(name) for name in MODULES} <= FLOOR.keys() | {"back", "analysis"}
    assert set(FLOOR) <= {_room(name) for name in MODULES}


@pytest.mark.parametrize(
    ("folder", "pattern", "most"),
    [(PKGEN, "*.py", 14), (ROOT / "runtime" / "src", "*.c", 12)],
)
def test_few_files_stand_at_the_root(folder: Path, pattern: str, most: int) -> None:
    assert len(list(folder.glob(pattern))) <= most


def test_each_package_says_what_it_is_for() -> None:
    silent = [
        name
        for name, path in MODULES.items()
        if path.name == "__init__.py" and not ast.get_docstring(ast.parse(path.read_text()))
    ]
    assert silent == []
