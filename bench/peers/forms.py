"""pkgen's methods on each form of a motion, compiled as `pkgen run` does it, with their counts."""

from __future__ import annotations

from functools import cache, partial
from pathlib import Path

from ..builds import (
    AS_RUN,
    OUTPUT,
    ROOT,
    RUNTIME,
    SOURCES,
    Build,
    compile_program,
    runtime_library,
)
from ..contender import HALVINGS, Contender, Program, Session
from ..rotation_cases import ADAPTIVE, Case, Form
from .own import emit

INLINED = {
    "PK_INLINE_GAUSS": "",
    "PK_INLINE_EMBEDDED": "",
    "PK_EMBEDDED_METHODS(X)": "X(dop853)",
}
EXPLICIT = ("rkmk4", "rkmk8")


@cache
def generated(form: Form) -> tuple[Path, str]:
    """The folder, and the model's name."""
    stem = form.path.rpartition("/")[2].removesuffix(".lag")
    folder = OUTPUT / "generated" / "forms" / f"{stem}-{'-'.join(form.name.split(', '))}"
    emit(ROOT / form.path, folder, *form.words)
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
