"""Names that mean something in C: whatever they name in a model, the C compiles, or pkgen says why
it cannot be. What there is, is asked of the compilers and headers at hand."""

import random
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest

from conftest import ROOT
from pkgen.back.c.names import FIELD_RESERVED, LOCAL_RESERVED, Names
from pkgen.compiler import check_model, compile_model
from pkgen.front.read import from_text
from pkgen.front.words import reserved
from pkgen.source import ModelError

_HEADERS = """
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal
    stdarg stdalign stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string threads
    time uchar wchar wctype aio dirent dlfcn fcntl ftw glob langinfo libgen malloc omp poll
    pthread quadmath regex sched search semaphore spawn strings syslog termios unistd utime
    net/if netdb netinet/in sys/ioctl sys/msg sys/mman sys/param sys/resource sys/shm
    sys/socket sys/stat sys/time sys/types sys/wait gsl/gsl_odeiv2 gsl/gsl_eigen
    gsl/gsl_multiroots
"""
HEADERS = _HEADERS.split()
COMPILERS = [c for c in ("gcc", "clang") if shutil.which(c)]
_STRICT = """
    -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror -Wno-psabi
    -Wno-unknown-warning-option -fsyntax-only
"""
STRICT = _STRICT.split()
RUNTIME = ["-DPK_RUNTIME", f"-I{ROOT / 'runtime/include'}"]
# Met, feared, or used by the C that is emitted.
_FEARED = """
    PK_REAL PK_C pk_real Pk_x pK_REAL DBL_DIG I J j0 y1 yn gamma lgamma signgam linux unix
    stdin NAN complex imaginary errno min max step_ MIN RAND_MAX EOF GM B50 IN OUT I_ I__
    NULL_ index time sinf sinl sinq fabsf expf memcpy size_t ptrdiff_t uint64_t int32_t
    double_ run_model choice c_ side_ factors_ inverse_ block_ w sc bad pass given out lo hi
    n k m M f u v q pdot momenta t1 t2 x_dot c_0 D_0 M_0_1 zoo_N zoo_H zoo_step zoo_min
    zoo_APART zoo_quantity zoo_params zoo_acceleration zoo_q_x zoo uniform P W row flux base
    total own sum1 first steps h g l r s isnan assert offsetof va_start signbit restrict_
    alignas_ bool_ and_ printf main_ abs_ sin_x lambda_out residual phi_out J_out a p p2 pk
    PK pk_system pk_integrator unused inline_
"""
FEARED = _FEARED.split()
KINDS = ["param", "param family", "coord", "coord family", "state", "input", "let", "observe",
         "event", "conserve"]  # fmt: skip


@cache
def preprocessed(compiler: str, *flags: str) -> str:
    text = "".join(f"#if __has_include(<{h}.h>)\n#include <{h}.h>\n#endif\n" for h in HEADERS)
    command = [compiler, "-std=gnu17", "-D_GNU_SOURCE", *flags, *RUNTIME, "-E", "-xc", "-"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


@cache
def macros() -> frozenset[str]:
    """Those without arguments."""
    found = set()
    for compiler in COMPILERS:
        found |= set(re.findall(r"#define (\w+)(?: |$)", preprocessed(compiler, "-dM"), re.M))
    assert len(found) > 3000 and {"DBL_DIG", "stdin", "linux", "PRIx64", "si_pid"} <= found
    return frozenset(found)


def test_no_name_in_c_is_a_macro() -> None:
    for reserved_there in (FIELD_RESERVED, LOCAL_RESERVED):
        changed = 0
        for name in sorted(macros()):
            taken = Names(reserved_there, (), "zoo_").take(name)
            changed += taken != name
            assert taken not in macros() and not taken.startswith("_")
        assert changed == len(macros())


def declared(kind: str, name: str) -> str:
    """A statement that declares NAME, and the part of the model that uses it."""
    return {
        "param": f"param {name} = 1\nobserve use_{name} = {name}*X'",
        "param family": f"param {name}[loop_ = 1..2] = loop_\nobserve use_{name} = {name}[2]*X",
        "coord": f"coord {name}\nkinetic {name}'^2/2\npotential cos({name})",
        "coord family": f"coord {name}[1..2]\nkinetic {name}[1]'^2/2 + {name}[2]'^2/2",
        "state": f"state {name}\nrate {name} = -sin({name})",
        "input": f"input {name}\nobserve use_{name} = {name}*X",
        "let": f"let {name} = sin(X)*X'\nobserve use_{name} = {name}^2 + exp({name})",
        "observe": f"observe {name} = X + cos(X)",
        "event": f"event {name}: X - 0.5 rising",
        "conserve": f"conserve {name} = 3",
    }[kind]


def model(kind: str, names: list[str]) -> str:
    text = "model zoo\ncoord X\nkinetic X'^2/2\npotential max(X, 0)*abs(X)\n"
    return text + "\n".join(declared(kind, name) for name in names) + "\n"


def compiles(files: dict[str, str], tmp_path: Path) -> None:
    name = next(iter(files))[:-2]
    for file, text in files.items():
        (tmp_path / file).write_text(text)
    before = "".join(f"#if __has_include(<{h}.h>)\n#include <{h}.h>\n#endif\n" for h in HEADERS)
    (tmp_path / "before.h").write_text(before)
    for compiler in COMPILERS:
        for more in (["-std=c99"], ["-std=gnu17", "-D_GNU_SOURCE", "-include", "before.h"]):
            done = subprocess.run(
                [compiler, *more, *STRICT, *RUNTIME, f"{name}.c"],
                cwd=tmp_path,
                capture_output=True,
                text=True,
            )
            assert done.returncode == 0, done.stderr[:4000]


@pytest.mark.parametrize("kind", KINDS)
def test_any_name_compiles_or_is_refused(kind: str, tmp_path: Path) -> None:
    draw = random.Random(kind)
    spelt = set(re.findall(r"[A-Za-z_]\w*", preprocessed("gcc")))
    odd = {x for x in macros() if not x.isupper() and len(x) < 60}
    names = set(FEARED) | set(draw.sample(sorted(macros() | spelt), 120))
    names |= set(draw.sample(sorted(odd), 30)) | set(draw.sample(sorted(LOCAL_RESERVED), 60))
    names = {x for x in names if x != "X" and not x.startswith(("use_", "p_"))}
    good = []
    for name in sorted(names):
        if not reserved(name):
            good.append(name)
            continue
        with pytest.raises(ModelError, match="error:") as said:
            check_model(from_text("zoo.lag", model(kind, [name])))
        assert f"'{name}'" in said.value.text() and "^" in said.value.text()
    assert len(good) > 150 and {"DBL_DIG", "PK_REAL", "gamma", "stdin"} <= set(good)
    used = good[:: {"coord": 3, "coord family": 6}.get(kind, 1)]  # the others give no names to rows
    files = compile_model(from_text("zoo.lag", model(kind, used)), unroll=None).files
    compiles(files, tmp_path)


def test_any_name_of_a_model_compiles_or_is_refused(tmp_path: Path) -> None:
    """What begins with it and goes on as symbols of a model do must not be another's."""
    text = "model {}\ncoord X\nkinetic X'^2/2\npotential max(X, 0)\nevent e: X rising\n"
    files = compile_model(from_text("zoo.lag", text.format("zoo"))).files
    looped = (ROOT / "tests/golden/fput.h").read_text() + (ROOT / "tests/golden/fput.c").read_text()
    endings = set(re.findall(r"\bzoo(_\w+)", files["zoo.h"] + files["zoo.c"]))
    endings |= set(re.findall(r"\bfput(_[A-Za-z]\w*)", looped))
    assert len(endings) > 80 and {"_start", "_H", "_step_q", "_max"} & endings
    functions = set(re.findall(r"\b(\w+) ?\(", preprocessed("gcc") + preprocessed("gcc", "-dM")))
    known = {x for x in macros() | functions if not x.startswith("_")}
    mine = set()
    for name in known:
        mine |= {name[: -len(e)] for e in endings if name.endswith(e) and name != e}
    assert {"va", "QUADMATH"} <= mine
    for name in sorted(mine | {"PK_REAL", "pk", "INT8", "gsl", "omp_get", "stdio", "NAN", "int"}):
        with pytest.raises(ModelError) as said:
            check_model(from_text("zoo.lag", text.format(name)))
        assert f"'{name}" in said.value.text() and "^" in said.value.text()
    for name in ("DBL", "I", "linux", "y1", "stdin", "E"):
        files = compile_model(from_text("zoo.lag", text.format(name))).files
        compiles(files, tmp_path)
