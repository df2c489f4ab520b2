"""The Julia package: each ccall is that of the C, its text parses; its example where Julia is."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from conftest import ROOT, run_pkgen
from pkgen.back.host.data import HERE

PAGE = (ROOT / "addons/hosts/export-julia.md").read_text()
# How C says what ccall says by these.
SAME = {
    "Csize_t": r"size_t",
    "Cint": r"int",
    "Float64": r"double",
    "Cvoid": r"void",
    "Cstring": r"const char ?\*",
    "Ptr{Cvoid}": r"(const )?(void|struct pk_host_motion) ?\*",
    "Ptr{Float64}": r"(const )?double ?\*",
}


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("julia") / "DoublePendulum"
    words = ("export", ROOT / "models/double_pendulum.lag", "--as", "julia", "-o", folder)
    done = run_pkgen(*words)
    assert done.returncode == 0, done.stderr
    return folder


def prototypes() -> dict[str, tuple[str, list[str]]]:
    text = re.sub(r"/\*.*?\*/", "", (HERE / "pk_host.h").read_text(), flags=re.S)
    form = r"^([a-z][\w ]*?\*?)\s?EXPORT\((pk_host_\w+)\)\(([^)]*)\);"
    found = {}
    for result, name, arguments in re.findall(form, text, re.M):
        names = [] if arguments == "void" else arguments.split(",")
        kinds = [re.sub(r"\w+$", "", " ".join(one.split())).strip() for one in names]
        found[name] = (result.strip(), kinds)
    return found


def test_each_call_is_that_of_the_c(package: Path) -> None:
    (source,) = (package / "src").glob("*.jl")
    form = r"ccall\(\s*\(:(\w+), LIB\),\s*([\w{}]+),\s*\(([^()]*)\)"
    calls = re.findall(form, source.read_text())
    known = prototypes()
    assert len(calls) > 15
    for name, result, arguments in calls:
        wanted_result, wanted = known[name]
        kinds = [word.strip() for word in arguments.split(",") if word.strip()]
        assert len(kinds) == len(wanted), name
        for kind, c in [(result, wanted_result), *zip(kinds, wanted, strict=True)]:
            assert re.fullmatch(SAME[kind], c), (name, kind, c)
    (library,) = (package / "lib").iterdir()
    shown = subprocess.run(["nm", "-D", library], capture_output=True, text=True, check=True).stdout
    assert {name for name, *_ in calls} <= set(re.findall(r" T (\w+)", shown))


def test_its_text_parses(package: Path) -> None:
    grammar = pytest.importorskip("tree_sitter_julia")
    sitter = pytest.importorskip("tree_sitter")
    parser = sitter.Parser(sitter.Language(grammar.language()))
    (source,) = (package / "src").glob("*.jl")
    assert not parser.parse(source.read_bytes()).root_node.has_error
    assert parser.parse(source.read_bytes()[:-5]).root_node.has_error


@pytest.mark.long
@pytest.mark.skipif(not shutil.which("julia"), reason="no julia here, and none in a registry")
def test_the_example_of_the_page(package: Path, tmp_path: Path) -> None:
    (script,) = re.findall(r"^```julia\n(.*?)^```", PAGE, re.M | re.S)
    (shown,) = re.findall(r"^```text\n(.*?)^```", PAGE, re.M | re.S)
    (tmp_path / "script.jl").write_text(script)
    command = ["julia", f"--project={tmp_path}", tmp_path / "script.jl"]
    done = subprocess.run(command, cwd=package.parent, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stdout == shown, done.stderr
