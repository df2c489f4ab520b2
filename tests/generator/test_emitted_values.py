"""The emitted C, run: its values are those of the graph, and what is no number is refused."""

import math
import random

import pytest
from building import links
from c_harness import (
    COMPILERS,
    DERIVED,
    MASS,
    ODD,
    PARAMETER,
    STRICT,
    TYPES,
    Loaded,
    failed,
    lowered,
    read_text,
    run,
    texts,
    write,
)

from pkgen.back.kernels import KERNELS
from pkgen.back.targets import CHECK, FILL, RETURN
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol


@pytest.fixture(scope="module", params=texts(), ids=lambda p: p[0])
def model(request):
    return read_text(request.param[1], request.param[0] + ".lag")


@pytest.mark.parametrize("compiler", COMPILERS)
def test_values_are_those_of_the_graph(model, compiler, tmp_path):
    equations, program = model
    loaded = Loaded(program, tmp_path, compiler)
    n = len(equations.coordinates)
    rng = random.Random(2385)
    nonzero = set()
    for _ in range(25):
        for i, slot in enumerate(equations.parameters):
            loaded.params[i] = rng.uniform(0.5, 2) * (-1 if slot.lo is None and i % 2 else 1)
        assert loaded.prepare() == 0
        t, q, v, u, a = (
            rng.uniform(0, 3),
            [rng.uniform(-2, 2) for _ in range(n)],
            [rng.uniform(-2, 2) for _ in range(n)],
            [rng.uniform(-2, 2) for _ in equations.inputs],
            [rng.uniform(-2, 2) for _ in range(n)],
        )
        values = {Symbol(Kind.TIME): t}
        for kind, row in [
            (Kind.PARAMETER, list(loaded.params)[: len(equations.parameters)]),
            (Kind.COORDINATE, q),
            (Kind.RATE, v),
            (Kind.INPUT, u),
            (Kind.ACCELERATION, a),
        ]:
            values |= {Symbol(kind, i): x for i, x in enumerate(row)}
        for kernel in program.kernels:
            result, outputs = loaded.call(kernel.name, t, q, v, u, a)
            if kernel.result == "int":
                assert result == 0
            by_name = {o.name: x for o, x in zip(kernel.outputs, outputs, strict=True)}
            assert all(9.875 not in x for x in outputs), "something was not written"
            for target in KERNELS[kernel.name].targets(equations):
                if target.kind in (CHECK, FILL):
                    continue
                (expected,) = evaluate(equations.graph, target.nodes, values)
                places = [target.where, *target.also]
                got = [result] if target.kind == RETURN else [_at(by_name, p) for p in places]
                for value in got:
                    assert value == pytest.approx(expected, rel=1e-12, abs=1e-13), kernel.name
                if expected:
                    nonzero.add(kernel.name)
    constant = {"mass", "jacobian"} if equations.model.name == "bead_on_hoop" else set()
    assert nonzero | constant >= {k.name for k in program.kernels}


def _at(arrays, place):
    name, index = place[:-1].split("[")
    return arrays[name][int(index)]


def test_prepare_catches_what_is_out_of_bounds(tmp_path):
    equations, program = read_text(ODD)
    loaded = Loaded(program, tmp_path)
    assert loaded.prepare() == 0
    names = [slot.quantity.name for slot in equations.parameters]
    for name, wrong in [
        ("I", 0.0),
        ("I", -1.0),
        ("I", math.inf),
        ("I", math.nan),
        ("k[2]", -1e-9),
        ("linux", math.nan),
        ("linux", -math.inf),
        ("c", 0.1),
        ("c", 100.5),
        ("c", math.nan),
    ]:
        index = names.index(name)
        kept = loaded.params[index]
        loaded.params[index] = wrong
        assert loaded.prepare() == failed(PARAMETER, index), (name, wrong)
        loaded.params[index] = kept
    for name, right in [("k[2]", 0.0), ("c", 100.0)]:
        loaded.params[names.index(name)] = right
        assert loaded.prepare() == 0
    # Each allowed, but what is computed from them overflows.
    loaded.params[names.index("I")] = 1.5e308
    assert loaded.prepare() == failed(DERIVED)


def test_defaults_follow_unless_given(tmp_path):
    equations, program = read_text(ODD)
    loaded = Loaded(program, tmp_path)
    names = [slot.quantity.name for slot in equations.parameters]
    i, c = names.index("I"), names.index("c")
    assert loaded.params[c] == pytest.approx(1.2)
    loaded.params[i] = 3.5
    given = [0] * len(names)
    given[c] = 1
    loaded.derive(given)
    assert loaded.params[c] == pytest.approx(1.2)
    loaded.derive()
    assert loaded.params[c] == pytest.approx(2.1)
    assert [loaded.params[names.index(f"k[{j}]")] for j in (1, 2, 3)] == [3, 4, 5]


def test_helpers_hand_nan_on(tmp_path):
    text = "model m\ncoord x, y\nkinetic x'^2 + y'^2\nobserve low = min(x, y)\n"
    text += "observe high = max(x, y)\nobserve up = step(x)\nobserve way = sign(x)\n"
    loaded = Loaded(lowered(text), tmp_path)
    nan, inf = math.nan, math.inf
    for q, expected in (
        ([2.5, 3], [2.5, 3, 1, 1]),
        ([0.0, -1], [-1, 0, 1, 0]),
        ([-inf, inf], [-inf, inf, 0, -1]),
        ([nan, 1], [nan] * 4),
        ([1, nan], [nan, nan, 1, 1]),
    ):
        assert loaded.call("observe", 0, q, [0, 0])[1][0] == pytest.approx(expected, nan_ok=True)


def test_singular_mass_is_refused_and_nothing_written(tmp_path):
    # Singular where e is 0, nearly so where it is tiny.
    text = "model m\nparam e = 1\ncoord x, y\nkinetic (x' + cos(y)*y')^2 + e*y'^2\npotential x\n"
    refused = failed(MASS, 1)
    for unroll in (True, False):
        program = lowered(text, unroll=unroll)
        (tmp_path / str(unroll)).mkdir()
        loaded = Loaded(program, tmp_path / str(unroll))
        for e, status in [(1.0, 0), (1e-3, 0), (0.0, refused), (1e-17, refused), (-0.5, refused)]:
            loaded.params[0] = e
            # Unrolled, 1/e is hoisted, and prepare says what is wrong already.
            assert loaded.prepare() == (failed(DERIVED) if unroll and not e else 0)
            result, outputs = loaded.call("acceleration", 0, [0.3, 0.2], [0.1, 0.4])
            assert result == status, (e, unroll)
            assert (outputs[0] == [9.875, 9.875]) == (status != 0)
        assert loaded.call("acceleration", 0, [0.3, math.nan], [0, 0])[0] == failed(MASS, 1)


@pytest.mark.parametrize("n", [3, 4, 5, 8, 11])  # rows are taken by fours
def test_loop_solves_what_is_unrolled(tmp_path, n):
    rng = random.Random(5)
    results = []
    q, v = ([rng.uniform(-2, 2) for _ in range(n)] for _ in range(2))
    for unroll in (True, False):
        (tmp_path / str(unroll)).mkdir()
        program = lowered(links(n, own=True), unroll=unroll)
        kernel = program.kernel("acceleration")
        assert kernel is not None and kernel.solves is not unroll
        loaded = Loaded(program, tmp_path / str(unroll), "clang" if unroll else "gcc")
        status, (a,) = loaded.call("acceleration", 0, q, v)
        assert status == 0
        results.append(a)
    assert results[0] == pytest.approx(results[1], rel=1e-10)
    assert max(map(abs, results[0])) > 0.1


@pytest.mark.parametrize("n", [2, 7])
def test_a_constant_mass_is_factored_by_prepare(tmp_path, n):
    """Dense, e on its diagonal: the kernel has no factorisation, and no pivot of e = -1."""

    text = (
        f"model dense\nsize n = {n}\nparam e = 1\ncoord x[1..n]\npotential sum(x[i]^3, i = 1..n)\n"
    )
    text += "kinetic sum(e*x[i]'^2, i = 1..n) + "
    text += "sum(x[i]'*x[j]'/(1 + i + j), i = 2..n, j = 1..i-1)\n"
    rng = random.Random(7)
    q, v = ([rng.uniform(-2, 2) for _ in range(n)] for _ in range(2))
    results = []
    for unroll in (True, False):
        (tmp_path / str(unroll)).mkdir()
        program = lowered(text, unroll=unroll, mass_constant=True)
        loaded = Loaded(program, tmp_path / str(unroll), "clang" if unroll else "gcc")
        header = (tmp_path / str(unroll) / "dense.h").read_text()
        assert ("factors_" in header) is not unroll
        for e in (1.0, 2.5):
            loaded.params[0] = e
            assert loaded.prepare() == 0
            status, (a,) = loaded.call("acceleration", 0, q, v)
            assert status == 0
            results.append(a)
        loaded.params[0] = -1.0
        loaded.prepare()
        assert loaded.call("acceleration", 0, q, v)[0] == 1
    assert results[:2] == [pytest.approx(a, rel=1e-12) for a in results[2:]]
    assert max(map(abs, results[0])) > 0.1 and results[0] != pytest.approx(results[1], rel=0.1)


def test_parts_of_a_long_kernel_work_together(tmp_path, monkeypatch):
    from pkgen.back.c import chunk

    rng = random.Random(6)
    q, v = ([rng.uniform(-2, 2) for _ in range(6)] for _ in range(2))
    results = []
    for longest, part in [(10_000, 10_000), (11, 9)]:  # the initial values are twelve
        monkeypatch.setattr(chunk, "_LONGEST", longest)
        monkeypatch.setattr(chunk, "_BLOCK", part)
        (tmp_path / str(part)).mkdir()
        program = lowered(links(6, own=True))
        kernel = program.kernel("acceleration")
        assert kernel is not None and (len(kernel.blocks) > 5) == (part == 9)
        write(program, tmp_path / str(part))
        for scalar in TYPES.values():
            for compiler in COMPILERS:
                run(
                    compiler, *STRICT, *scalar, "-fsyntax-only", "links.c", cwd=tmp_path / str(part)
                )
        loaded = Loaded(program, tmp_path / str(part))
        results.append([loaded.call(k.name, 0, q, v) for k in program.kernels])
    assert results[0] == results[1]


def test_constants_are_right_to_the_last_bit(tmp_path):
    """1/3, 9.81 and pi in each type against division and the type's own constants."""
    text = (
        "model c\ncoord x\nkinetic x'^2/2\n"
        "observe third = 1/3 + x\nobserve g = 9.81 + x\nobserve circle = pi + x\n"
    )
    _, program = read_text(text)
    write(program, tmp_path)
    (tmp_path / "main.c").write_text(
        "#include <stdio.h>\n"
        '#include "c.h"\n'
        "int main(void)\n{\n"
        "    struct c_params p;\n    pk_real q[1] = {0}, v[1] = {0}, out[3];\n"
        "    volatile pk_real one = 1, three = 3;\n"
        "    c_defaults(&p);\n    c_observe(&p, 0, q, v, NULL, out);\n"
        "    return !(out[0] == one / three && out[1] == PK_C(9.81)\n"
        "             && out[2] == PK_F(acos)(-one));\n"
        "}\n"
    )
    for flags in (*TYPES.values(), ["-DPK_FLOAT128"]):
        quad = ["-lquadmath"] if flags == ["-DPK_FLOAT128"] else []
        run("gcc", "-std=c99", *flags, "main.c", "c.c", "-o", "x", *quad, "-lm", cwd=tmp_path)
        run(tmp_path / "x", cwd=tmp_path)
