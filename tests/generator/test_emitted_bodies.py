"""The C of rotations and constraints: strict in every type, for C++ too; self-test and lanes."""

import ctypes
import random
import re
from pathlib import Path

import pytest
from c_harness import BUILDS, RUNTIME, TYPES, Loaded, no_warnings, run
from test_attitudes import HUNG
from test_constraint_claims import BALL
from test_constraints import BODY, OUTPUTS, ROWS

from conftest import case
from pkgen.compiler import Compilation, compile_model
from pkgen.source import Source

# Coordinates and constraints that are called what kernels call their arguments.
NAMED = case("named")
# Short rods: what the self-test takes differences of bends within a quarter of a metre.
CHAIN = case("emitted_bodies_chain")
TEXTS = {
    "chain": CHAIN,
    "hung": HUNG,
    "bound": "model bound\n" + BODY + ROWS + OUTPUTS,
    "ball": BALL,
    "named": NAMED,
}


@pytest.fixture(scope="module", params=TEXTS)
def made(request, monkeypatch_module) -> Compilation:
    return compile_model(Source("model.lag", TEXTS[request.param]), self_test=True)


@pytest.fixture(scope="module")
def monkeypatch_module():
    """Starts that hold take a computer to find, and are no part of this."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pkgen.middle.derive.derive.at_the_start", lambda _, rows, *__: (rows, []))
        yield patch


def write(made: Compilation, directory: Path) -> str:
    for name, text in made.files.items():
        (directory / name).write_text(text, encoding="utf-8")
    return made.model.name


@pytest.mark.parametrize(("compiler", "scalar"), BUILDS)
def test_no_warnings(made, compiler, scalar, tmp_path):
    no_warnings(compiler, scalar, write(made, tmp_path), tmp_path)


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_header_from_cpp(made, compiler, tmp_path):
    name = write(made, tmp_path)
    (tmp_path / "use.cpp").write_text(f'#include "{name}.h"\nint main() {{ return 0; }}\n')
    run(
        compiler,
        *["-std=c++17", "-Wall", "-Wextra", "-Werror"],
        *RUNTIME,
        "-c",
        "use.cpp",
        cwd=tmp_path,
    )


@pytest.mark.parametrize("scalar", TYPES)
def test_self_test_passes(made, scalar, tmp_path):
    name = write(made, tmp_path)
    files = [f"{name}.c", f"{name}_selftest.c"]
    run("gcc", "-std=c99", *TYPES[scalar], *files, "-o", "x", "-lm", cwd=tmp_path)
    passed = re.fullmatch(r"(\d+) passed, 0 failed\n", run(tmp_path / "x", cwd=tmp_path))
    assert passed and int(passed[1]) > 200


def test_lanes_are_the_scalar_kernel_to_the_bit(made, tmp_path):
    c = Loaded(made.program, tmp_path, optimise="-O2")
    n, lanes = len(made.program.equations.coordinates), 8
    draw = random.Random(2385)
    q, v = ([[draw.uniform(-1, 1) for _ in range(lanes)] for _ in range(n)] for _ in range(2))
    t = [draw.uniform(0, 1) for _ in range(lanes)]
    flat = [(ctypes.c_double * (n * lanes))(*(x for r in rows for x in r)) for rows in (q, v)]
    u, out = (ctypes.c_double * lanes)(), (ctypes.c_double * (n * lanes))()
    times = (ctypes.c_double * lanes)(*t)
    kernel = c.function("lanes", ctypes.c_ulonglong)
    assert kernel(c.params, times, *flat, u, out) == 0
    for lane in range(lanes):
        state = [row[lane] for row in q], [row[lane] for row in v]
        failed, (a,) = c.call("acceleration", t[lane], *state)
        assert not failed
        assert [out[i * lanes + lane] for i in range(n)] == a
        assert any(a)


def test_the_system_says_what_there_is(tmp_path, monkeypatch_module):
    """The table that the runtime reads, of a model with all of it."""
    made = compile_model(Source("model.lag", TEXTS["bound"]))
    (source,) = (text for name, text in made.files.items() if name.endswith("_system.c"))
    table = source[source.index("const struct pk_system") :]
    for line in (
        ".n = 12,",
        ".n_first_order = 8,",
        ".n_rotations = 1,",
        ".unconstrained = bound_sys_unconstrained,",
        ".inertia = bound_sys_inertia,",
    ):
        assert line in table
    rows = re.search(r"\.constraints = \{(.*?)\}", table, re.S)[1]
    for line in (
        ".n = 4,",
        ".n_holonomic = 3,",
        ".names = bound_constraints,",
        ".values = bound_sys_constraint,",
        ".jacobian = bound_sys_constraint_jacobian,",
        ".multipliers = bound_sys_multipliers",
    ):
        assert line in rows
    assert '{"lambda_pin", "", ""}' in made.files["bound.c"].replace("\n    ", " ")
