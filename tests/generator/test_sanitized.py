"""Clang's sanitizers over emitted C: straight lines, loops, members, lanes; see `make asan`."""

import subprocess

import pytest

from conftest import ROOT, ran

MODELS = [
    "models/double_pendulum.lag",
    "models/chains/fput.lag",
    "models/chains/fput_beta.lag",
    "models/coupled_oscillators.lag",
    "models/heavy_top.lag",
    "models/particles/n_body.lag",
]
FLAGS = "-O0 -g -std=c11 -fsanitize=address,undefined -fno-sanitize-recover=all"
pytestmark = pytest.mark.long


def has_sanitizers() -> bool:
    command = ["clang", "-fsanitize=address", "-x", "c", "-", "-o", "/dev/null"]
    try:
        return not subprocess.run(command, input=b"int main(void) { return 0; }\n").returncode
    except FileNotFoundError:
        return False


@pytest.fixture(scope="module")
def library():
    if not has_sanitizers():
        pytest.skip("clang has no sanitizers here (libclang-rt-dev)")
    subprocess.run(["make", "-s", "fuzz-library"], cwd=ROOT, check=True)
    return ROOT / "build/runtime-fuzz/libpk.a"


@pytest.mark.parametrize("model", MODELS)
def test_no_undefined_behaviour(library, tmp_path, model):
    done = ran(ROOT / model, "--runtime", "-o", tmp_path)
    (source,) = (path for path in tmp_path.glob("*.c") if not path.stem.endswith("_system"))
    includes = [f"-I{ROOT}/runtime/include", f"-I{tmp_path}"]
    inline = [f"-DPK_INLINE_{x}" for x in ("SPLITTING", "ENSEMBLE")]
    harness = [ROOT / "tests/fuzz/emitted.c", f"-DMODEL={source.stem}_system"]
    program = tmp_path / "program"
    command = ["clang", *FLAGS.split(), "-DPK_RUNTIME", *inline, *includes, *harness, source]
    subprocess.run([*command, library, "-lm", "-o", program], check=True)
    env = {"ASAN_OPTIONS": "detect_leaks=0"}
    done = subprocess.run([program], capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split(":")[1].split()[0]) > 30
