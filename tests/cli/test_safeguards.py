"""What keeps a run from harm: limits of time and memory, readers that go away, a bounded cache."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from conftest import ROOT
from pkgen.methods import METHODS, NONE
from pkgen.run import build, runtime
from pkgen.system import toolchain
from pkgen.system.resources import ResourcesExceeded, bounded

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
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, timeout=300)
    assert done.stderr == ""


def test_a_fixed_step_is_kept_whatever_rows_are_asked_for(pkgen) -> None:
    arguments = ["run", DOUBLE, "--method", "rk4", "--step", "0.01", "--until", "1", "--json"]
    result = json.loads(pkgen(*arguments).stdout)
    assert result["report"]["step"] == 0.01 and len(result["rows"]) == 101
    result = json.loads(pkgen(*arguments, "--every", "0.025").stdout)
    assert result["report"]["step"] == 0.01 and len(result["rows"]) == 41


def test_stages_are_told_apart(pkgen) -> None:
    first = {"parse": "File", "analyze": "Structure", "derive": "%0", "lower": "program"}
    for stage, begins in first.items():
        assert pkgen(DOUBLE, f"--dump={stage}").stdout.startswith(begins)


def test_a_cache_that_comes_to_another_processor_is_not_used(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PKGEN_CACHE", str(tmp_path))
    monkeypatch.setattr(runtime, "_compiled", lambda tools, part: tmp_path)
    tools = toolchain.find_toolchain()
    assert len(tools.target) == 24 and ("-march=native" in tools.flags or not toolchain.NATIVE)
    elsewhere = replace(tools, target="another processor")
    assert runtime.runtime_library(tools) != runtime.runtime_library(elsewhere)


def test_what_is_known_of_methods_is_as_the_runtime_says() -> None:
    """The generator knows it without a C compiler."""
    found = {m["name"]: m for m in build.runtime_methods()}
    gsl = {name for name in METHODS if name.startswith("gsl_")}
    assert set(METHODS) - set(found) in (set(), gsl) and len(METHODS) > 30
    assert set(found) <= set(METHODS)
    noted = {trait for method in METHODS.values() for trait in method.traits}
    for name, method in found.items():
        assert METHODS[name].traits == noted & set(method["flags"]), name
        assert set(METHODS[name].requires) == set(method["requires"]), name


def test_kernels_that_a_method_calls() -> None:
    """See pk_missing_kernel() in src/core/check.c; exponential takes `linear` as its matrix."""
    called = {name: method.kernels for name, method in METHODS.items()}
    always = called["rk4"]
    assert NONE.kernels == called["gsl_rkf45"] == always and "acceleration" in always
    assert called["gauss4"] == always | {"canonical", "mass", "jacobian"}
    assert called["exponential"] == called["gsl_msbdf"] == always | {"mass", "linear"}


def test_every_method_but_newtons_is_compiled_with_the_model() -> None:
    mine = [m for m in build.runtime_methods() if not m["name"].startswith("gsl_")]
    # Newton's method, what takes `linear` or `fast` and steps on SO(3) go through function
    # pointers; one that is exact evaluates nothing.
    apart = {"jacobians", "linear", "exact", "group"}
    others = {m["name"] for m in mine if apart & set(m["flags"]) or "fast" in m["requires"]}
    inlined = {name for name, method in METHODS.items() if method.inlined}
    assert inlined == {m["name"] for m in mine} - others and len(inlined) >= 8
