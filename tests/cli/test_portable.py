"""--portable: the same bits with fused multiply-add and without, in the processor and in the C
library."""

from __future__ import annotations

import json
import os
import platform
from pathlib import Path

import pytest

from conftest import ROOT, ran
from pkgen.compiler import compile_model
from pkgen.front.read import read
from pkgen.run.build import build_library

DOUBLE = ROOT / "models/double_pendulum.lag"
METHODS = {"gauss": [], "dop853": [], "gauss4": ["--step", "0.01"], "rk4": ["--step", "0.001"]}
# glibc chooses pow, exp and log by the processor.
OLD = "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX2_Usable,-FMA_Usable"


def has_fma() -> bool:
    info = Path("/proc/cpuinfo")
    return platform.machine() == "x86_64" and info.exists() and " fma " in info.read_text()


@pytest.mark.skipif(not has_fma(), reason="of an x86 processor with FMA its absence is tried")
@pytest.mark.parametrize("method", METHODS)
def test_the_same_bits_with_and_without(method: str, tmp_path: Path) -> None:
    def rows(portable: list[str], flags: str, tunables: str) -> str:
        words = ["run", DOUBLE, "--method", method, *METHODS[method], "--until", "30"]
        more = {"CFLAGS": f"-O1 {flags}", "GLIBC_TUNABLES": tunables}
        done = ran(*words, "--every", "0.5", *portable, env={**os.environ, **more})
        return done.stdout

    portable = rows(["--portable"], "", "")
    assert rows(["--portable"], "-mno-fma", OLD) == portable
    assert rows([], "", "") != portable  # or nothing would be shown


def test_the_c_and_what_stands_beside_the_rows_say_so(pkgen, tmp_path: Path) -> None:
    for words, said in (([], False), (["--portable"], True)):
        out = tmp_path / f"{said}.csv"
        assert pkgen("run", DOUBLE, "--until", "1", *words, "-o", out).returncode == 0
        assert json.loads(Path(f"{out}.json").read_text())["portable"] is said
        assert pkgen(DOUBLE, *words, "-o", tmp_path).returncode == 0
        text = (tmp_path / "double_pendulum.c").read_text()
        assert ("#define PK_PORTABLE 1" in text) is said


def test_the_runtime_is_portable_as_well(monkeypatch) -> None:
    """It is compiled by itself, with the flags of the model."""
    seen = []
    monkeypatch.setattr("pkgen.run.build.runtime_name", lambda tools: seen.append(tools) or "x")
    monkeypatch.setattr("pkgen.run.build.cached", lambda *_: Path())
    for portable in (False, True):
        build_library(compile_model(read(DOUBLE), portable=portable).files, "double_pendulum")
    assert ["-DPK_PORTABLE" in tools.flags for tools in seen] == [False, True]
