"""Implicit methods on families kept as loops, by banded Newton: beside members written out, and
with steps far beyond what explicit methods can."""

from __future__ import annotations

import json
import math
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from test_loops_features import both, rows  # noqa: F401 (a fixture)

from conftest import case, ran

STIFF = {
    "sine_gordon": case("sine_gordon"),
    "ring": case("loops_implicit_ring"),
    # M is not dominated by its diagonal: no norm of its inverse is known from its entries.
    "coupled": case("coupled"),
    "heat": case("heat"),
}


@pytest.mark.parametrize("method", ["gauss1", "gauss3", "radau5"])
@pytest.mark.parametrize("name", STIFF)
@pytest.mark.parametrize("size", (1, 2, 3, 20))
def test_stiff_steps_are_those_of_members_written_out(
    name: str,
    size: int,
    method: str,
    both,  # noqa: F811
) -> None:
    words = ("--until", 2, "--every", 1, "--size", f"N={size}")
    (loops, told), (written, _) = both(STIFF[name], *words, "--method", method, "--step", 0.25)
    assert told["steps"] == 8
    for one, other in zip(loops, written, strict=True):
        assert one == pytest.approx(other, rel=1e-11, abs=1e-11)


def test_heat_is_conducted_by_steps_as_long_as_one_likes(tmp_path: Path) -> None:
    """An explicit step is stable up to 2/(4 D): these are a million times as long."""
    model = tmp_path / "line.lag"
    model.write_text(
        "model line\nsize N = 1000\nparam D = 1e8\nstate u[1..N]\nfixed u[0] = 1\n"
        "fixed u[N+1] = 0\nrate u[i = 1..N] = D*(u[i-1] - 2*u[i] + u[i+1])\n"
    )
    words = ("--until", 0.03, "--every", 0.03, "--record", "u[250]", "--json")
    out = tmp_path / "out.csv"
    done = ran("run", model, *words, "--method", "radau5", "--step", 0.005, "-o", out)
    # Fourier's series of the chain, slowest first; each mode k decays by 4 D sin^2.
    expected = 1 - 250 / 1001
    for k in range(1, 40):
        angle = k * math.pi / 1001
        amplitude = 1 / math.tan(angle / 2) / 1001
        rate = 4 * 1e8 * math.sin(angle / 2) ** 2
        expected -= amplitude * math.sin(250 * angle) * math.exp(-rate * 0.03)
    assert rows(out.read_text())[-1][1] == pytest.approx(expected, abs=1e-4)
    assert json.loads(done.stdout)["report"]["steps"] == 6


LIMIT = 1 << 30  # bytes of address space: of 20,000 numbers a matrix of each with each takes 3.2e9


@pytest.mark.parametrize("method", [("radau", "--rtol", "1e-4"), ("gauss2", "--step", "1e-5")])
def test_memory_grows_with_the_members(method: tuple[str, ...], tmp_path: Path) -> None:
    """Radau's tolerances once had M whole."""
    model = tmp_path / "chain.lag"
    model.write_text(
        "model chain\nsize N = 20000\nparam k = 1e6\ncoord q[1..N]\nfixed q[0] = 0\n"
        "kinetic sum(q[i]'^2/2, i = 1..N) + sum((q[i] - q[i-1])'^2/8, i = 1..N)\n"
        "potential sum(k*(q[i] - q[i-1])^2/2, i = 1..N)\nstart q[i = 1..N] = 1e-3*sin(i/100)\n"
    )
    words = ("--until", "1e-5", "--every", "1e-5", "--record", "energy", "--method", *method)
    done = subprocess.run(
        [sys.executable, "-m", "pkgen", "run", model, *words],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (LIMIT, LIMIT)),
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    first, last = (row[1] for row in rows(done.stdout))
    assert first != last and last == pytest.approx(first, rel=1e-9)
