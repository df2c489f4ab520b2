"""What keeps a run from harm: limits of time and memory, readers that go away, a bounded cache."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from conftest import ROOT
from pkgen import build, scene_use
from pkgen.inlined import INLINED
from pkgen.resources import ResourcesExceeded, bounded

DOUBLE = ROOT / "models/double_pendulum.lag"


def test_time_is_bounded(pkgen) -> None:
    done = pkgen("check", DOUBLE, "--max-seconds", "0.001")
    assert done.returncode == 1
    assert "CPU time" in done.stderr and "--max-seconds" in done.stderr


def test_memory_is_bounded() -> None:
    with pytest.raises(ResourcesExceeded, match="64 MiB"), bounded(60, 64 << 20):
        bytearray(512 << 20)
    assert len(bytearray(512 << 20)) == 512 << 20  # and the bound is gone afterwards


@pytest.mark.parametrize("arguments", ["--dump=render", "--dump=derive"])
def test_a_reader_of_python_s_own_output_goes_away(arguments: str) -> None:
    command = f"{sys.executable} -m pkgen {DOUBLE} {arguments} | true"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, timeout=60)
    assert done.stderr == ""


def test_a_fixed_step_is_kept_unless_rows_are_asked_for(pkgen) -> None:
    arguments = ["run", DOUBLE, "--method", "rk4", "--step", "0.01", "--until", "1", "--json"]
    result = json.loads(pkgen(*arguments).stdout)
    assert result["report"]["step"] == 0.01 and len(result["rows"]) == 101
    result = json.loads(pkgen(*arguments, "--every", "0.025").stdout)
    assert result["report"]["step"] == 0.025 / 3 and len(result["rows"]) == 41


def test_stages_are_told_apart(pkgen) -> None:
    first = {"parse": "File", "analyze": "Structure", "derive": "%0", "lower": "program"}
    for stage, begins in first.items():
        assert pkgen(DOUBLE, f"--dump={stage}").stdout.startswith(begins)


def test_the_cache_keeps_the_newest(tmp_path: Path) -> None:
    for age in range(build.KEPT_PROGRAMS + 3):
        entry = tmp_path / f"model-{age}"
        entry.mkdir()
        os.utime(entry, (1e9 - age, 1e9 - age))
    build._prune(tmp_path)
    left = {p.name for p in tmp_path.iterdir()}
    assert left == {f"model-{age}" for age in range(build.KEPT_PROGRAMS)}


def test_a_cache_that_comes_to_another_processor_is_not_used(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PKGEN_CACHE", str(tmp_path))
    monkeypatch.setattr(build, "_build_runtime", lambda tools, directory: directory.mkdir())
    (tmp_path / "runtime").mkdir()
    tools = build.find_toolchain()
    assert len(tools.target) == 24 and ("-march=native" in tools.flags or not build.NATIVE)
    elsewhere = replace(tools, target="another processor")
    assert build.runtime_library(tools) != build.runtime_library(elsewhere)


def test_what_a_method_calls_and_carries_is_as_the_runtime_says() -> None:
    """The generator knows it without a C compiler."""
    for method in build.driver_methods():
        name, flags = method["name"], set(method["flags"])
        called = scene_use.called(name)
        assert ("quadrature" in flags) == scene_use.carries_quadratures(name), name
        assert "jacobian" in called or "jacobians" not in flags, name
        assert "linear" in called or "linear" not in flags, name


def test_every_method_but_newtons_is_compiled_with_the_model() -> None:
    mine = [m for m in build.driver_methods() if not m["name"].startswith("gsl_")]
    # Newton's method and what takes `linear` go through function pointers; one that is exact
    # evaluates nothing.
    called = {m["name"] for m in mine if {"jacobians", "linear", "exact"} & set(m["flags"])}
    inlined = {m["name"] for m in mine} - called
    assert inlined == set(INLINED) and len(inlined) >= 8
