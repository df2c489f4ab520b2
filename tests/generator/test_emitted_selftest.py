"""The emitted self-test: it passes, and notices a wrong factor in any kernel."""

import re

import pytest
from c_harness import BUILDS, MODELS, TYPES, read_model, read_text, run, texts, write


@pytest.fixture(scope="module", params=texts(), ids=lambda p: p[0])
def model(request):
    return read_text(request.param[1], request.param[0] + ".lag")


@pytest.mark.parametrize(("compiler", "scalar"), BUILDS)
def test_self_test_passes(model, compiler, scalar, tmp_path):
    _, program = model
    files = [f for f in write(program, tmp_path, self_test=True) if f.endswith(".c")]
    run(compiler, "-std=c99", *TYPES[scalar], *files, "-o", "x", "-lm", cwd=tmp_path)
    passed = re.fullmatch(r"(\d+) passed, 0 failed\n", run(tmp_path / "x", cwd=tmp_path))
    assert passed and int(passed[1]) > 200


# A wrong sign in a kernel; every one must be noticed.
BROKEN = ["acceleration", "mass", "force", "canonical", "momenta", "gradient", "jacobian"]
BROKEN += ["linear", "energy", "lagrangian", "kinetic", "potential"]


@pytest.mark.parametrize("kernel", BROKEN)
def test_self_test_notices_a_broken_kernel(kernel, tmp_path):
    _, program = read_model(next(p for p in MODELS if p.stem == "double_pendulum"))
    write(program, tmp_path, self_test=True)
    path = tmp_path / "double_pendulum.c"
    source = path.read_text()
    function = kernel + "_pass" if kernel == "acceleration" else kernel
    start = source.index(f"double_pendulum_{function}(", source.index("_start("))
    end = source.index("\n}\n", start)
    wrong = re.sub(
        r"(return |\] = )(?!0)(?=.*(sin|cos|theta|t\d))",
        r"\1PK_C(1.001) * ",
        source[start:end],
        count=1,
    )
    assert wrong != source[start:end]
    path.write_text(source[:start] + wrong + source[end:])
    run("gcc", "-std=c99", path.name, "double_pendulum_selftest.c", "-o", "x", "-lm", cwd=tmp_path)
    with pytest.raises(AssertionError, match=r"(?s)expected .*[1-9]\d* failed"):
        run(tmp_path / "x", cwd=tmp_path)
