"""The right-hand side alone: nanoseconds of the double pendulum's accelerations, peers' and own."""

from __future__ import annotations

import shlex
import shutil
import statistics
import subprocess
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from . import codegen
from .builds import (
    RUNTIME,
    SOURCES,
    Build,
    Refused,
    Unavailable,
    compile_program,
    each_build,
    run,
    written,
)
from .measure import Effort
from .models import Model, equations, model
from .peers.own import kernel_header

FOLDER = SOURCES / "kernels"


@dataclass(frozen=True)
class Kernel:
    name: str
    title: str
    file: str
    header: object  # () -> the path, quoted for -D, of what the file includes
    libraries: tuple[str, ...] = ()


@dataclass(frozen=True)
class Timing:
    """Nanoseconds of a kernel in each round, in its fastest build, and all builds' medians."""

    kernel: Kernel
    build: str
    rounds: list[float]
    builds: dict[str, float]


def measure(effort: Effort, say) -> tuple[dict[str, Timing], Refused]:
    """Of the kernels that can be had; and why not the others."""
    kernels, refused = [], {}
    pendulum = model("double_pendulum")
    for kernel in _kernels(pendulum):
        try:
            kernel.header()
            kernels.append(kernel)
        except Unavailable as reason:
            refused[kernel.title] = reason
    programs = each_build(effort.builds, partial(_program, kernels))
    rounds, turns = (20, 3) if effort.starts > 2 else (5, 3)
    found: dict[str, dict[str, list[float]]] = {k.name: {} for k in kernels}
    for _ in range(turns):
        for build, program in zip(effort.builds, programs, strict=True):
            for name, times in _run(program, rounds).items():
                found[name].setdefault(str(build), []).extend(times)
    say(f"kernels: {len(kernels)} measured in {len(programs)} builds")
    timings = {}
    for kernel in kernels:
        medians = {b: statistics.median(t) for b, t in found[kernel.name].items()}
        best = min(medians, key=medians.get)
        timings[kernel.name] = Timing(kernel, best, found[kernel.name][best], medians)
    return timings, refused


def _run(program: Path, rounds: int) -> dict[str, list[float]]:
    command = [program, str(rounds), "0.001"]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    times, values = {}, {}
    for line in said.splitlines():
        if line.startswith("="):
            _, name, *numbers = line.split()
            values[name] = [float(x) for x in numbers]
        else:
            name, *numbers = line.split()
            times[name] = [float(x) for x in numbers]
    _must_agree(values)
    return times


def _must_agree(values: dict[str, list[float]]) -> None:
    expected = values["closed"]
    for name, a in values.items():
        far = max(abs(x - y) / abs(y) for x, y in zip(a, expected, strict=True))
        if name != "floor" and not far < 1e-12:
            raise SystemExit(f"bench: kernel {name} gives {a}, the textbook's {expected}")


def _program(kernels: list[Kernel], build: Build) -> Path:
    objects = [str(_object(k, build)) for k in kernels]
    libraries = tuple(dict.fromkeys(x for k in kernels for x in k.libraries))
    listed = " ".join(f"X({k.name})" for k in kernels)
    return compile_program(
        build,
        [FOLDER / "main.c"],
        {"KERNELS": listed},
        ("-std=c11", *objects),
        libraries,
    )


def _object(kernel: Kernel, build: Build) -> Path:
    """Its own two symbols stay visible, so that models and helpers can be in it twice."""
    compiled = compile_program(
        build,
        [FOLDER / kernel.file],
        {"KERNEL": f"kernel_{kernel.name}", "BENCH_EQUATIONS": kernel.header()},
        ("-std=gnu11", "-c", f"-I{FOLDER}", f"-I{RUNTIME / 'include'}"),
    )
    made = compiled.with_suffix(".o")
    if not made.exists():
        kept = [f"--keep-global-symbol=kernel_{kernel.name}{end}" for end in ("", "_width")]
        run(["objcopy", *kept, str(compiled), str(made)])
    return made


def _kernels(pendulum: Model) -> list[Kernel]:
    nothing = partial(_quoted, "kernels/nothing.h", "")
    closed = partial(_quoted, "kernels/closed.h", codegen.acceleration(pendulum))
    matrices = partial(_quoted, "kernels/matrices.h", codegen.mass_and_force(pendulum))
    own = partial(kernel_header, pendulum)
    return [
        Kernel("floor", "two libm sincos + a division", "floor.c", nothing),
        Kernel("closed", "textbook form", "closed.c", closed),
        Kernel("ldl", "SymPy cse of M, f + unrolled L D Lᵀ", "ldl.c", matrices),
        Kernel("cholesky", "M, f + GSL Cholesky", "cholesky.c", matrices, _gsl()),
        Kernel("pydy", "PyDy's C for M, f + unrolled L D Lᵀ", "pydy.c", partial(_pydy, pendulum)),
        Kernel("own", "pkgen", "own.c", own),
        Kernel("own_libm", "pkgen --libm", "own.c", partial(own, "--libm")),
        Kernel("own_lanes", "pkgen, lane kernel, a state", "own_lanes.c", partial(own, lanes=True)),
    ]


def _quoted(name: str, text: str) -> str:
    return f'"{written(name, text)}"'


def _gsl() -> tuple[str, ...]:
    config = shutil.which("gsl-config")
    if not config:
        return ("-lgsl", "-lgslcblas")
    said = subprocess.run([config, "--libs"], capture_output=True, text=True, check=True)
    return tuple(shlex.split(said.stdout))


def _pydy(pendulum: Model) -> str:
    try:
        from pydy.codegen.c_code import CMatrixGenerator
    except ImportError:
        raise Unavailable("pydy is not installed") from None
    derived = equations(pendulum.name)
    arguments = (list(pendulum.q), list(pendulum.v), list(pendulum.parameters))
    header, source = CMatrixGenerator(arguments, (derived.mass, derived.force)).doprint("pydy")
    written("kernels/pydy.h", header)
    return _quoted("kernels/pydy_generated.h", codegen.parameters(pendulum) + source)
