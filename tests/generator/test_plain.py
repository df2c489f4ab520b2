"""C to be embedded, beside that for the runtime: the same values, less text, no double in float."""

import ctypes
import random
import re
import subprocess
from pathlib import Path

import pytest
from c_harness import ROOT, STRICT, run

from pkgen.back.kernels import PLAIN
from pkgen.compiler import compile_model
from pkgen.front.read import from_text, read

PATHS = sorted((ROOT / "models").rglob("*.lag"))
QUICK = {"double_pendulum", "heavy_top", "rattleback", "kepler", "free_body", "coupled_oscillators"}
DOUBLES = re.compile(r"\b(cvtss2sd|addsd|subsd|mulsd|divsd|sqrtsd|call\s+(sin|cos|sqrt|pow|exp)@)")


class Loaded:
    """Kernels in double, of either form."""

    def __init__(self, path: Path, folder: Path, plain: bool):
        how = {"plain": True, "kernels": PLAIN} if plain else {}
        made = compile_model(read(path), unroll=None, **how)
        self.name = made.model.name
        self.n = int(re.search(r"_N = (\d+)", made.files[f"{self.name}.h"])[1])
        self.inputs = len(made.equations.inputs)
        folder.mkdir()
        for file, content in made.files.items():
            (folder / file).write_text(content, encoding="utf-8")
        flags = (
            *["-O1", "-ffp-contract=off", "-shared", "-fPIC"],
            f"{self.name}.c",
            "-o",
            "m.so",
            "-lm",
        )
        run("gcc", *STRICT, *flags, cwd=folder)
        self.c = ctypes.CDLL(str(folder / "m.so"))
        self.params = (ctypes.c_double * 100_000)()
        self.call("defaults")

    def call(self, kernel: str, *state, out: int = 0):
        function = getattr(self.c, f"{self.name}_{kernel}")
        function.restype = ctypes.c_double if kernel == "energy" else ctypes.c_int
        place = (ctypes.c_double * max(1, out))()
        result = function(self.params, *state, *([place] if out else []))
        return [result] if kernel == "energy" else list(place)

    def values(self, t: float, q, v, u) -> dict[str, list[float]]:
        state = ctypes.c_double(t), q, v, u
        sizes = {"acceleration": self.n, "mass": self.n**2, "force": self.n, "energy": 0}
        there = {k: size for k, size in sizes.items() if hasattr(self.c, f"{self.name}_{k}")}
        return {kernel: self.call(kernel, *state, out=size) for kernel, size in there.items()}


@pytest.mark.parametrize("path", PATHS, ids=lambda p: p.stem)
def test_values_are_those_of_the_runtimes_kernels(path, tmp_path):
    text = path.read_text()
    if path.parent.name == "chains" and "size" in text and path.stem != "beats":
        pytest.skip("hundreds of members")
    forms = [Loaded(path, tmp_path / form, form == "plain") for form in ("plain", "whole")]
    n, draw = forms[0].n, random.Random(path.stem)
    vector = ctypes.c_double * max(1, n)
    start = [(vector(), vector()) for _ in forms]
    for form, (q, v) in zip(forms, start, strict=True):
        form.call("start", q, v)
    assert [list(x) for x in start[0]] == [list(x) for x in start[1]]
    u = (ctypes.c_double * max(1, forms[0].inputs))(
        *(draw.uniform(-1, 1) for _ in range(forms[0].inputs))
    )
    for _ in range(3):
        q = vector(*(x + draw.uniform(-0.1, 0.1) for x in start[0][0]))
        v = vector(*(x + draw.uniform(-0.1, 0.1) for x in start[0][1]))
        plain, whole = (form.values(0.3, q, v, u) for form in forms)
        assert plain.keys() <= whole.keys() and "acceleration" in plain
        for kernel, found in plain.items():
            largest = max(map(abs, whole[kernel]))
            assert found == pytest.approx(whole[kernel], rel=1e-11, abs=1e-12 * largest), kernel


@pytest.mark.parametrize("path", PATHS, ids=lambda p: p.stem)
def test_in_float_there_is_no_operation_of_double(pkgen, path, tmp_path):
    assert pkgen(path, "-o", tmp_path).returncode == 0
    for source in tmp_path.glob("*.c"):
        if "that float cannot hold" in source.with_suffix(".h").read_text():
            continue
        flags = ["-std=c99", "-O1", "-DPK_FLOAT", "-S", "-o", "-"]
        done = subprocess.run(["gcc", *flags, source], capture_output=True, text=True, check=True)
        assert not DOUBLES.search(done.stdout)


def test_it_is_short(pkgen, tmp_path):
    for model, lines, size in (
        ("double_pendulum", 350, 14_000),
        ("coupled_oscillators", 330, 12_000),
    ):
        folder = tmp_path / model
        assert pkgen(ROOT / f"models/{model}.lag", "-o", folder).returncode == 0
        texts = [path.read_text() for path in folder.iterdir()]
        assert len(texts) == 2 and sum(map(len, texts)) <= size
        assert sum(text.count("\n") for text in texts) <= lines


def test_a_failure_says_which(tmp_path):
    """1 + the parameter or pivot, -1 - the row of the constraints, -1 of a derived constant."""
    text = "model m\nparam m = 1 in (0, inf)\nparam k = 2 in [0, 5]\ncoord x, y\n"
    text += "kinetic m*x'^2/2 + x^2*y'^2/2\npotential k*x^2/m + y\nstart x = 1\n"
    path = tmp_path / "m.lag"
    path.write_text(text)
    model = Loaded(path, tmp_path / "c", True)
    prepare = model.c.m_prepare
    for m, k, code in ((1, 2, 0), (0, 2, 1), (1, 6, 2), (1, float("nan"), 2), (1e-309, 2, -1)):
        model.params[0], model.params[1] = m, k
        assert prepare(model.params) == code
    two, a = ctypes.c_double * 2, (ctypes.c_double * 2)()
    model.params[0], model.params[1] = 1, 2
    assert prepare(model.params) == 0
    assert model.c.m_acceleration(model.params, ctypes.c_double(0), two(), two(), None, a) == 2


def test_a_large_acceleration_is_a_loop():
    text = "model m\nsize N = 20\nparam l = 1 in (0, inf)\ncoord a[1..N]\n"
    text += "let x[i = 0..N] = sum(l*sin(a[k]), k = 1..i)\n"
    text += "let y[i = 0..N] = sum(l*cos(a[k]), k = 1..i)\n"
    text += "kinetic sum((x[i]'^2 + y[i]'^2)/2, i = 1..N)\npotential -9.81*sum(y[i], i = 1..N)\n"
    made = compile_model(from_text("m.lag", text), unroll=None, plain=True, kernels=PLAIN)
    assert "m_solved(" in made.files["m.c"]
    assert sum(map(len, made.files.values())) < 42_000
