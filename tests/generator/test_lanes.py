"""Lane kernels: vector code of both compilers on AVX2, AVX-512 and NEON, and the scalar kernel's
results in every lane."""

import re
import shutil
from pathlib import Path

import pytest
from c_harness import COMPILERS, MODELS, ODD, ROOT, STRICT, TYPES, read_text, run, write
from sincos_harness import targets

from conftest import case
from pkgen.back.c.lower import lower
from pkgen.middle.analyze import analyze

FAST = ["-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"]
CROSS = "aarch64-linux-gnu"
needs_cross = pytest.mark.skipif(
    shutil.which(f"{CROSS}-gcc") is None or shutil.which("qemu-aarch64") is None,
    reason=f"no {CROSS}-gcc or no qemu-aarch64 here (Debian: gcc-{CROSS} qemu-user)",
)
needs_x86 = pytest.mark.skipif("native" in targets(), reason="not an x86-64 machine")
AVX2, AVX512 = ["-mavx2", "-mfma"], ["-mavx512f", "-mfma"]
MACHINES = [
    pytest.param("gcc", AVX2, 32, marks=needs_x86, id="gcc-avx2"),
    pytest.param("gcc", AVX512, 64, marks=needs_x86, id="gcc-avx512"),
    pytest.param(f"{CROSS}-gcc", [], 16, marks=needs_cross, id="gcc-neon"),
    pytest.param("clang", AVX2, 32, marks=needs_x86, id="clang-avx2"),
    pytest.param("clang", AVX512, 64, marks=needs_x86, id="clang-avx512"),
    pytest.param(
        "clang",
        [f"--target={CROSS}", "-isystem", f"/usr/{CROSS}/include"],
        16,
        marks=needs_cross,
        id="clang-neon",
    ),
]


def emit(path: Path, directory: Path, *, libm: bool = False) -> str:
    """The C of a model, and its name."""
    equations, program = read_text(path.read_text(encoding="utf-8"), path.name)
    if libm:
        program = lower(equations, analyze.analyze(equations), libm=True)
    write(program, directory)
    return program.equations.model.name


def lane_loops(lines: list[str]) -> list[tuple[int, int]]:
    """First and last line of each loop over lanes, counted from 1."""
    starts = [i + 2 for i, x in enumerate(lines) if x == "    PK_LANE_LOOP"]
    return [(i, next(k for k, x in enumerate(lines[i:], i + 1) if x == "    }")) for i in starts]


def vector_sizes(compiler: str, flags: list[str], source: Path) -> dict[str, list[int]]:
    """The bytes of the vectors that each lane loop was made of, by the compiler's own report."""
    lines = source.read_text().splitlines()
    if compiler == "clang":
        report = ["-Rpass=(loop|slp)-vectorize"]
    else:
        report = ["-fopt-info-vec-optimized"]
    said = run(
        *("sh", "-c", '"$@" 2>&1', "sh", compiler, *FAST, *flags, *report, "-c"),
        *(source.name, "-o", "x.o"),
        cwd=source.parent,
    )
    found: dict[str, list[int]] = {}
    for number, (start, end) in enumerate(lane_loops(lines), 1):
        in_loop = rf"{source.name}:(?:{'|'.join(map(str, range(start, end)))}):\d+: "
        sizes = [int(x) for x in re.findall(in_loop + r".* using (\d+) byte vectors", said)]
        widths = re.findall(in_loop + r".*vectorized loop \(vectorization width: (\d+)", said)
        sizes += [8 * int(x) for x in widths]
        # clang unrolls a short loop whole before it looks for loops, then packs the stores.
        if re.search(in_loop + r".*Stores SLP vectorized", said):
            sizes.append(0)
        found[f"loop {number}"] = sizes
    return found


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
@pytest.mark.parametrize(("compiler", "flags", "size"), MACHINES)
def test_lane_loops_are_vector_code(compiler, flags, size, path, tmp_path):
    name = emit(path, tmp_path)
    found = vector_sizes(compiler, flags, tmp_path / f"{name}.c")
    angles = "_angles(" in (tmp_path / f"{name}.c").read_text()
    assert len(found) == (4 if angles else 2)
    for sizes in found.values():
        assert size in sizes or (compiler == "clang" and sizes == [0])


@needs_x86
@pytest.mark.parametrize("compiler", COMPILERS)
def test_a_loop_with_calls_of_libm_is_not(compiler, tmp_path):
    """So the reports do say when a loop is not vector code."""
    name = emit(next(p for p in MODELS if p.stem == "double_pendulum"), tmp_path, libm=True)
    found = vector_sizes(compiler, AVX2, tmp_path / f"{name}.c")
    assert found == {"loop 1": [], "loop 2": []} or compiler == "clang"


# M is singular at q = 0, in one coordinate whatever the parameters; an input, a coupling.
SINGULAR = case("singular")


def check(
    compiler: list[str], flags: list[str], name: str, directory: Path, runner=()
) -> list[int]:
    """How many lanes were compared, failed, and differ."""
    program = directory / "check"
    command = [*compiler, *STRICT, *FAST, *flags, f"-DMODEL={name}", f'-DSOURCE="{name}.c"', "-I."]
    source = ROOT / "tests" / "generator" / "lanes_check.c"
    run(*command, source, "-o", program, "-lm", cwd=directory)
    said = run(*runner, program, cwd=directory)
    return [int(x) for x in re.findall(r"\d+", said)]


TEXTS = {p.stem: p.read_text() for p in MODELS} | {"odd": ODD, "singular": SINGULAR}
MOST = ("odd", "double_pendulum")  # between them they have all that lanes have


@pytest.fixture(scope="module")
def written(request, tmp_path_factory):
    directory = tmp_path_factory.mktemp(request.param)
    write(read_text(TEXTS[request.param])[1], directory)
    return request.param, directory


def every(builds: list) -> list:
    """Each model in each build; quick are the first one of every model, and all of MOST."""
    return [
        pytest.param(name, *build, id="-".join([name, *build]), marks=[] if quick else [LONG])
        for name in TEXTS
        for build in builds
        for quick in [name in MOST or build == builds[0]]
    ]


LONG = pytest.mark.long
# Each compiler, machine and type at least once.
BUILDS = [
    ("gcc", "fma", "double"),
    ("gcc", "plain", "float"),
    ("gcc", "plain", "long double"),
    ("clang", "fma", "float"),
    ("clang", "plain", "double"),
]


@pytest.mark.parametrize("written, compiler, target, scalar", every(BUILDS), indirect=["written"])
def test_lanes_are_the_scalar_kernel_to_the_bit(written, compiler, target, scalar):
    name, directory = written
    flags = targets().get(target, []) + TYPES[scalar]
    compared, failed, differ = check([compiler], flags, name, directory)
    assert compared == 2 * 400 * (8 + 1 + 3 + 12)
    assert (failed > 300) == (name in ("singular", "heavy_top", "double_pendulum", "odd"))
    assert differ == 0


@needs_cross
@pytest.mark.parametrize("written, scalar", every([("double",), ("float",)]), indirect=["written"])
def test_neon_lanes_too(written, scalar):
    name, directory = written
    compiler = [f"{CROSS}-gcc", "-static"]
    _, _, differ = check(compiler, TYPES[scalar], name, directory, runner=["qemu-aarch64"])
    assert differ == 0


def test_a_wrong_lane_is_seen(tmp_path):
    """The comparison can fail: one lane's failure not noted, one constant of members wrong."""
    name = emit(next(p for p in MODELS if p.stem == "double_pendulum"), tmp_path)
    path = tmp_path / f"{name}.c"
    source = path.read_text()
    for right, wrong in [
        ("any |= bad[l];", "any |= bad[l] & 2;"),
        ("p.m2_l1_l2 = P[11 * W + l];", "p.m2_l1_l2 = P[10 * W + l];"),
    ]:
        assert right in source
        path.write_text(source.replace(right, wrong))
        with pytest.raises(AssertionError, match=r"[1-9]\d* differ"):
            check(["gcc"], [], name, tmp_path)


def test_parameters_that_no_state_can_mend_fail_every_lane(tmp_path):
    """Outside of the loop over lanes: a mass of 0, also where sines are in loops of their own."""
    for path in MODELS:
        if path.stem not in ("double_pendulum", "elastic_pendulum"):
            continue
        name = emit(path, tmp_path)
        source = (tmp_path / f"{name}.c").read_text()
        lanes = source[source.index(f"{name}_lanes_inline(size_t W") :]
        lanes = lanes[: lanes.index("\n}\n")]
        pivot = re.search(r"    if \(!\(p->([\w\[\]]+) > 0\)\)\n        return ", lanes)
        assert pivot
        (tmp_path / "fail.c").write_text(
            f'#include <stdio.h>\n#include "{name}.c"\n'
            "int main(void)\n{\n"
            f"    struct {name}_params p;\n    pk_real x[8 * {name}_N] = {{0}}, a[8 * {name}_N];\n"
            f"    {name}_defaults(&p);\n    p.{pivot[1]} = 0;\n"
            f'    printf("%llx %d\\n", {name}_lanes(&p, x, x, x, x, a),\n'
            f"           {name}_acceleration(&p, 0, x, x, x, a));\n    return 0;\n}}\n"
        )
        run("gcc", *STRICT, *FAST, "-I.", "fail.c", "-o", "fail", "-lm", cwd=tmp_path)
        assert run(tmp_path / "fail", cwd=tmp_path).split() == ["ff", "1"]


@pytest.mark.parametrize("compiler", COMPILERS)
def test_a_sine_alone_leaves_out_what_only_the_cosine_needs(compiler, tmp_path):
    (tmp_path / "half.c").write_text(
        "#include <pk/real.h>\n#include <pk/sincos.h>\n"
        "void both(double x, double *s, double *c) { pk_sincos_bounded(x, s, c); }\n"
        "void unread(double x, double *s) { double c; pk_sincos_bounded(x, s, &c); }\n"
        "void null(double x, double *s) { pk_sincos_bounded(x, s, NULL); }\n"
    )
    include = f"-I{ROOT / 'runtime' / 'include'}"
    apart = ["-fno-ipa-icf"] if compiler == "gcc" else []
    run(compiler, "-O2", *apart, include, "-S", "half.c", "-o", "half.s", cwd=tmp_path)
    bodies = re.split(r"^(\w+):.*$", (tmp_path / "half.s").read_text(), flags=re.MULTILINE)
    instructions = {
        name: len(re.findall(r"^\t[a-z]", body, re.MULTILINE))
        for name, body in zip(bodies[1::2], bodies[2::2], strict=True)
    }
    assert 0 < max(instructions["unread"], instructions["null"]) < instructions["both"]
