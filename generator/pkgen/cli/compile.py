"""`pkgen MODEL.lag`: writes C for a model or one of its scenes."""

from __future__ import annotations

import argparse
import json
import re
import shlex
import sys
from pathlib import Path

from ..back.jet import WITHOUT
from ..back.kernels import CANONICAL, KERNELS, PLAIN
from ..compiler import STAGES, Compilation
from ..front.read import READ, read
from ..scenes import check as scene_check
from ..scenes import compile_plan as scene_use
from ..scenes import lengths, scene
from ..scenes import run_settings as parsing
from ..system.exits import UsageError
from ..system.files import STANDARD, replace
from . import arguments as shared
from .compilation import compile_within_limits, within_limits
from .messages import refuse_both

EXAMPLES = """
pkgen models/double_pendulum.lag -o generated
pkgen models/heavy_top.lag --scene nutation -o -
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.directory(parser, "here; -: both on standard output")
    parser.add_argument("--scene", metavar="NAME", help="compile one scene of the model")
    shared.no_reduce(parser)
    parser.add_argument("--kernels", metavar="LIST", help="more: momenta,jacobian, or all")
    help_ = "what pkgen's runtime takes: lanes, its table, the inline sine and cosine"
    parser.add_argument("--runtime", action="store_true", help=help_)
    shared.sincos(parser)
    shared.canonical(parser)
    shared.unrolling(parser)
    parser.add_argument("--self-test", action="store_true", help="a program that tests the kernels")
    help_ = "for make: the C files depend on these"
    parser.add_argument("--depfile", metavar="FILE", help=help_)
    parser.add_argument(
        "--dump", choices=STAGES, metavar="STAGE", help="show a stage's result as text"
    )


def run(options: argparse.Namespace) -> None:
    """Compile a model to C: DIR/NAME.h and DIR/NAME.c."""
    refuse_both(options, options.directory)
    source = read(options.model)
    kernels = _kernels(options)
    if options.dump:
        from ..explain.dump import dump

        with within_limits(options):
            text = dump(options.dump, source, lengths.given(options.size), kernels, options.libm)
        print(text)
        return
    compilation = compile_within_limits(
        options,
        source,
        kernels=kernels,
        self_test=options.self_test,
        canonical=options.canonical or bool(kernels and kernels & CANONICAL),
        unroll=lengths.unroll(options),
        libm=options.libm,
        portable=options.portable,
        plain=not (options.runtime or options.self_test),
        use=scene_use.of_compile(options),
        symmetric=True,
    )
    if kernels and "jet" in kernels and not compilation.program.jet:
        raise UsageError(f"--kernels jet: {WITHOUT}")
    if chosen := scene.of(options, compilation.declared):
        scene_check.refuse_method(compilation, chosen)
    if options.directory == "-":
        if options.depfile:
            raise UsageError("-o - makes no file that others could depend on; --depfile needs one")
        replace({STANDARD: _as_one(compilation)})
        return
    directory = parsing.directory(options.directory)
    directory.mkdir(parents=True, exist_ok=True)
    files = {directory / name: text for name, text in compilation.files.items()}
    if options.depfile:
        first = directory / f"{compilation.model.name}.c"
        files[Path(options.depfile)] = _depends([first, *(f for f in files if f != first)])
    replace(files)
    if options.json:
        files = [str(directory / name) for name in compilation.files]
        warnings = [w.record(source) for w in compilation.warnings]
        print(json.dumps({"files": files, "warnings": warnings}))
    elif sys.stdout.isatty():
        print(_made(compilation, directory, options))


def _made(compilation: Compilation, directory: Path, options: argparse.Namespace) -> str:
    """Returns a message: the written files, their size, and a command that compiles them."""
    files, name = compilation.files, compilation.model.name
    size = f"{sum(text.count(chr(10)) for text in files.values()):,} lines, "
    size += f"{sum(len(text.encode()) for text in files.values()) / 1000:.3g} kB"
    runtime = " -DPK_RUNTIME -I pkgen/runtime/include" if options.runtime else ""
    source = shlex.quote(str(directory / f"{name}.c"))
    names = ", ".join(str(directory / file) for file in files)
    return f"{names}: {size}\nnext: cc -std=c99 -O2{runtime} -c {source}"


def _kernels(options: argparse.Namespace) -> frozenset[str] | None:
    """Returns the kernels to write: those in PLAIN and in --kernels. None means all kernels."""
    if options.kernels == "all" or options.runtime or options.self_test:
        return None
    canonical = CANONICAL | {"canonical"} if options.canonical else frozenset()
    return PLAIN | canonical | (parsing.kernels(options.kernels, KERNELS) or frozenset())


def _depends(made: list[Path]) -> str:
    """Returns a rule for make: the written files `made` depend on all files that pkgen has read.
    ninja heeds only the first of the files `made`."""
    left, right = (
        " ".join(re.sub(r"([ #\\])", r"\\\1", str(path)).replace("$", "$$") for path in paths)
        for paths in (made, READ)
    )
    return f"{left}: {right}\n"


def _as_one(compilation: Compilation) -> str:
    """Returns the headers and the C file as one text that compiles alone. Raises UsageError."""
    if len(files := compilation.files) > 2:
        raise UsageError(f"-o -: several files are written: {', '.join(files)}; give a directory")
    files = sorted(compilation.files.items(), key=lambda file: not file[0].endswith(".h"))
    names = "|".join(map(re.escape, compilation.files))
    own = re.compile(f'^#include "({names})"\n', re.MULTILINE)
    return "".join(own.sub("", text) for _, text in files)
