"""A wheel has all that is in the packages; an editable installation does not show that."""

from __future__ import annotations

import re
from pathlib import Path

from conftest import ROOT

PROJECT = (ROOT / "pyproject.toml").read_text(encoding="utf-8")  # Python 3.10 has no tomllib
ROOTS = {"pkgen": ROOT / "generator/pkgen", "pkgen_runtime": ROOT / "runtime"}


def _listed(key: str) -> list[str]:
    return re.findall(r'"([^"]+)"', re.search(rf"^{key} = \[(.*?)\]", PROJECT, re.M | re.S)[1])


def _package(folder: Path) -> str:
    name = next(name for name, root in ROOTS.items() if folder.is_relative_to(root))
    return ".".join([name, *folder.relative_to(ROOTS[name]).parts])


def test_every_folder_of_python_is_a_package() -> None:
    folders = {path.parent for root in ROOTS.values() for path in root.rglob("*.py")}
    assert sorted(_listed("packages")) == sorted(map(_package, folders))


def test_every_other_file_goes_with_its_package() -> None:
    packages, missing = _listed("packages"), []
    for root in ROOTS.values():
        for path in root.rglob("*"):
            if path.is_dir() or path.suffix in (".py", ".pyc", ".md"):
                continue
            package = max((p for p in packages if _package(path).startswith(p)), key=len)
            data = _listed(f'(?:"{package}"|{package})')
            inside = path.relative_to(ROOTS[package.split(".")[0]])
            inside = inside.relative_to(Path(*package.split(".")[1:]))
            if not any(
                inside.match(pattern) and len(inside.parts) == pattern.count("/") + 1
                for pattern in data
            ):
                missing.append(str(path))
    assert not missing
