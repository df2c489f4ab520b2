"""A wheel has all that is in the packages; an editable installation does not show that."""

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT

PROJECT = (ROOT / "pyproject.toml").read_text(encoding="utf-8")  # Python 3.10 has no tomllib
ROOTS = {
    path.name: path.resolve()
    for path in (ROOT / "generator").glob("pkgen*")
    if path.exists() and path.name.isidentifier()  # pkgen_lag.egg-info is no package
}


def _listed(key: str) -> list[str]:
    return re.findall(r'"([^"]+)"', re.search(rf"^{key} = \[(.*?)\]", PROJECT, re.M | re.S)[1])


def _package(folder: Path) -> str:
    name = next(name for name, root in ROOTS.items() if folder.is_relative_to(root))
    return ".".join([name, *folder.relative_to(ROOTS[name]).parts])


FOLDERS = {path.parent for root in ROOTS.values() for path in root.rglob("*.py")}
FOLDERS -= {ROOT / "addons/hosts/pkgen_hosts/python/wheel"}  # goes into wheels of models


@pytest.mark.needs_addon
def test_every_folder_of_python_is_a_package() -> None:
    """setuptools finds these alone."""
    assert not [folder for folder in FOLDERS if not (folder / "__init__.py").exists()]


@pytest.mark.needs_addon
def test_every_other_file_goes_with_its_package() -> None:
    packages, missing = [*map(_package, FOLDERS)], []
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


# Of the standard library, since Python 3.11 or later.
TOO_NEW = {
    "typing": {"Self", "Never", "LiteralString", "assert_never", "reveal_type", "Unpack"}
    | {"Required", "NotRequired", "TypeVarTuple", "dataclass_transform", "override"},
    "enum": {"StrEnum", "verify", "member", "nonmember", "property"},
    "datetime": {"UTC"},
    "contextlib": {"chdir"},
    "hashlib": {"file_digest"},
    "math": {"cbrt", "exp2", "sumprod"},
    "operator": {"call"},
    "itertools": {"batched"},
    "tomllib": set(),
    "wsgiref.types": set(),
}


def _since_3_11(text: str) -> set[str]:
    """What a text takes of the standard library that Python 3.10 has not. Its syntax is checked."""
    tree = ast.parse(text, feature_version=(3, 10))
    modules = {
        a.asname or a.name: a.name
        for n in ast.walk(tree)
        if isinstance(n, ast.Import)
        for a in n.names
    }
    found = {name for name in modules.values() if name in TOO_NEW and not TOO_NEW[name]}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module in TOO_NEW:
            new = TOO_NEW[node.module]
            found |= {a.name for a in node.names if a.name in new or not new}
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            known = TOO_NEW.get(modules.get(node.value.id, ""), set())
            found |= {node.attr} & known
        if isinstance(node, ast.Name):
            found |= {node.id} & {"ExceptionGroup", "BaseExceptionGroup"}
        found |= {"except*"} if type(node).__name__ == "TryStar" else set()
    return found


def test_python_3_10_has_all_that_is_used() -> None:
    assert 'requires-python = ">=3.10"' in PROJECT
    for path in ROOTS["pkgen"].rglob("*.py"):
        assert not _since_3_11(path.read_text(encoding="utf-8")), path
    for worse in ("from typing import Self", "import math\nmath.cbrt(8)", "import tomllib"):
        assert _since_3_11(worse)


@pytest.mark.long
def test_python_3_10_compiles_and_runs(tmp_path: Path) -> None:
    python = os.environ.get("PKGEN_PYTHON_3_10") or shutil.which("python3.10")
    # What `which` finds may be a stand-in that only tells which versions it could start.
    if not python or subprocess.run([python, "-c", ""], capture_output=True).returncode:
        pytest.skip("no python3.10 that runs here; name one by PKGEN_PYTHON_3_10")
    folder = tmp_path / "venv"
    subprocess.run([python, "-m", "venv", folder], check=True)
    made = subprocess.run(
        [folder / "bin/pip", "install", "-q", ROOT], capture_output=True, text=True
    )
    if made.returncode:
        pytest.skip(f"what pkgen needs cannot be had: {made.stderr[-200:]}")
    out = tmp_path / "rows.csv"
    for words in (["check"], ["explain"], ["run", "--until", "1", "-o", out]):
        command = [folder / "bin/pkgen", words[0], ROOT / "models/double_pendulum.lag", *words[1:]]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    assert out.read_text().count("\n") == 1002


def test_types_are_seen_from_outside(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    text = 'import pkgen; reveal_type(pkgen.load("x.lag").run(1))'
    command = [sys.executable, "-m", "mypy", "--cache-dir", tmp_path, "-c", text]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert 'Revealed type is "pkgen.api.result.Result"' in done.stdout
