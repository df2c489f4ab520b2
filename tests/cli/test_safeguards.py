"""What keeps a run from harm: limits of time and memory, readers that go away, a bounded cache."""

from __future__ import annotations

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


def test_a_cache_that_comes_to_another_processor_is_not_used(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PKGEN_CACHE", str(tmp_path))
    monkeypatch.setattr(runtime, "_compiled", lambda tools, part: tmp_path)
    tools = toolchain.find_toolchain()
    assert len(tools.target) == 24 and ("-march=native" in tools.flags or not toolchain.NATIVE)
    elsewhere = replace(tools, target="another processor")
    assert runtime.runtime_library(tools) != runtime.runtime_library(elsewhere)


def test_kernels_that_a_method_calls() -> None:
    """See pk_missing_kernel() in src/core/check.c; exponential takes `linear` as its matrix."""
    called = {name: method.kernels for name, method in METHODS.items()}
    always = called["rk4"]
    assert NONE.kernels == called["gsl_rkf45"] == always and "acceleration" in always
    assert called["gauss4"] == always | {"canonical", "mass", "jacobian"}
    assert called["exponential"] == called["gsl_msbdf"] == always | {"mass", "linear"}


def test_every_method_but_newtons_is_compiled_with_the_model() -> None:
    mine = [m for m in build.runtime_methods() if not m["name"].startswith("gsl_")]
    # Newton's method, what takes `linear`, `fast` or noise and steps on SO(3) go through function
    # pointers; one that is exact evaluates nothing.
    apart = {"jacobians", "linear", "exact", "group", "noise"}
    others = {m["name"] for m in mine if apart & set(m["flags"]) or "fast" in m["requires"]}
    inlined = {name for name, method in METHODS.items() if method.inlined}
    assert inlined == {m["name"] for m in mine} - others and len(inlined) >= 8
