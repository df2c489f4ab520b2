"""pkgen's methods on each form of a motion, compiled as `pkgen run` does it, with their counts."""

from __future__ import annotations

import subprocess
from functools import cache, partial
from pathlib import Path

from ..builds import (
    AS_RUN,
    OUTPUT,
    ROOT,
    RUNTIME,
    SOURCES,
    Broken,
    Build,
    compile_program,
    runtime_library,
)
from ..contender import HALVINGS, Contender, Program, Session
from ..rotation_cases import ADAPTIVE, Case, Form
from .own import pkgen_python

INLINED = {
    "PK_INLINE_GAUSS": "",
    "PK_INLINE_EMBEDDED": "",
    "PK_EMBEDDED_METHODS(X)": "X(dop853)",
}
EXPLICIT = ("rkmk4", "rkmk8")
_COMPILE = """
import sys
from pathlib import Path
from pkgen import __main__ as command
from pkgen.compiler import compile_model
from pkgen.front.read import read
from pkgen.scenes import use as scene_use
from pkgen.scenes.lengths import UNROLL
model, folder, *words = sys.argv[1:]
use = scene_use.of_run(command.parser_of("run").parse_args([model, *words]))
for name, text in compile_model(read(model), unroll=UNROLL, use=use).files.items():
    Path(folder, name).write_text(text)
"""


@cache
def generated(form: Form) -> tuple[Path, str]:
    """The folder, and the model's name."""
    stem = form.path.rpartition("/")[2].removesuffix(".lag")
    folder = OUTPUT / "generated" / "forms" / f"{stem}-{'-'.join(form.name.split(', '))}"
    folder.mkdir(parents=True, exist_ok=True)
    command = [pkgen_python(), "-c", _COMPILE, str(ROOT / form.path), str(folder), *form.words]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    if done.returncode:
        said = done.stderr.strip().splitlines() or ["?"]
        raise Broken(f"pkgen refused {form.path}: {said[-1][:200]}")
    return folder, stem


class Seen:
    """A session that is given the start of a case, and whose end is what all forms have; what it
    took at a setting is kept: steps, evaluations."""

    def __init__(self, session: Session, given, seen, extra: int = 0):
        self.flags = session.flags
        self.took: dict[float, tuple[float, float]] = {}
        self._session, self._given, self._seen, self._extra = session, given, seen, extra

    def integrate(self, setting, y0, t_end, seconds):
        start = [*self._given(y0), *[0.0] * self._extra]
        spent, state = self._session.integrate(setting, start, t_end, seconds)
        *state, steps, evaluations = state
        self.took.setdefault(setting, (steps, evaluations))
        return spent, self._seen(state)

    def close(self) -> None:
        self._session.close()


def opened(form: Form, method: str, _case: Case, _: tuple[Build, ...]) -> list[Seen]:
    """`extra`: the program's own counts stand behind the state, in what it is given too."""
    folder, name = generated(form)
    defines = {
        "PK_RUNTIME": "",
        "BENCH_SYSTEM": f"{name}_system",
        "BENCH_N": str(form.n),
        "BENCH_Z": str(form.quadratures),
        "BENCH_P": str(len(form.parameters)),
        **INLINED,
    }
    sources = [SOURCES / "counted_methods.c", SOURCES / "harness.c", folder / f"{name}.c"]
    flags = ("-std=c11", f"-I{RUNTIME / 'include'}", f"-I{folder}")
    build = AS_RUN[0]
    path = compile_program(build, sources, defines, flags, (str(runtime_library(build)),))
    program = Program(path, [method, *form.parameters], str(build))
    return [Seen(program, form.given, form.seen, 2)]


def contenders(case: Case) -> list[Contender]:
    found = []
    for form in case.forms:
        for method in form.methods:
            named = f"{form.name}: {method}"
            how = partial(opened, form, method)
            if method in ADAPTIVE:
                found.append(Contender(named, "pkgen", False, how))
            else:
                slow = method not in EXPLICIT
                group = "steps" if slow else "pkgen"
                found.append(Contender(named, group, True, how, ladder=HALVINGS, slow=slow))
    return found
