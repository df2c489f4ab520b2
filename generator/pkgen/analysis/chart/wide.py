"""Libraries of a model in a type wider than double, for reference runs."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from ...run.build import build_library
from ...system.exits import BuildError
from ...system.files import scratch
from ...system.toolchain import Toolchain, compile_c, find_toolchain

# For each type, the widest first: its macro in pk/real.h, the libraries it needs, and a header and
# a function to test whether it exists.
TYPES = {
    "__float128": ("-DPK_FLOAT128", ("-lquadmath",), "<quadmath.h>", "sqrtq"),
    "long double": ("-DPK_LONG_DOUBLE", ("-lm",), "<math.h>", "sqrtl"),
}
PROBE = "#include {}\nint main(int n, char **x) {{ return x && {}(n) < 0; }}\n"


def precise_tools(scalar: str) -> Toolchain | None:
    """Returns a C compiler that supports the scalar type, with its flags; None if no installed
    compiler supports the type."""
    macro, libraries, header, function = TYPES[scalar]
    flags = ("-O2", "-ffp-contract=off", "-std=gnu11", macro)
    own = replace(find_toolchain(), flags=flags, gsl_cflags=None, gsl_libs=libraries)
    gcc = replace(own, cc=("gcc",), version="gcc")
    for tools in [own] if "gcc" in own.cc[0] or not shutil.which("gcc") else [own, gcc]:
        with scratch() as folder:
            (folder / "probe.c").write_text(PROBE.format(header, function), encoding="utf-8")
            try:
                compile_c(tools, ["probe.c", "-o", "probe", *libraries], folder)
            except BuildError:
                continue
            return tools
    return None


def library(
    files: dict[str, str], name: str, able: Sequence[str], types: Iterable[str] = TYPES
) -> tuple[Path, str] | None:
    """Compiles a model and the methods `able` in the first of `types` that a C compiler supports.
    Returns the path of the library and the type, or None if no type is supported. Raises BuildError
    if the model fails to compile or link."""
    for scalar in types:
        if tools := precise_tools(scalar):
            return build_library(files, name, able=able, tools=tools), scalar
    return None
