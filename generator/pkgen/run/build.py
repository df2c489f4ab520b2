"""Builds libraries and programs from generated C, with the C compiler, the runtime and the cache.

A model is compiled once for each text and set of inlined methods. The library is cached in
`PKGEN_CACHE`, else `$XDG_CACHE_HOME/pkgen`, else `~/.cache/pkgen`.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..back.c.render import is_portable
from ..methods import METHODS, NONE, Own, inline_flags, known
from ..own import in_c
from ..system.cache import cached
from ..system.files import scratch
from ..system.toolchain import NATIVE, RUNTIME, Toolchain, compile_c, find_gsl, find_toolchain
from .library import load
from .runtime import SHARED, WHOLE, needed, part_of, runtime_library, runtime_links, runtime_name

# C file that defines the struct pk_run_model. No model can have this name.
CHOICE_FILE = "which-model.c"
CHOICE = """#include <pk/gsl.h>
#include <pk/methods.h>
#include <pk/run.h>
#define ADDRESS(A, name, ...) &pk_method_##name,
{own}{rows}extern const struct pk_system {name}_system;
{blocks}static const struct pk_method *const methods[] = {{{methods}}};
extern const struct pk_run_model {of};
const struct pk_run_model {of} = {{&{name}_system, {given}, {count}, methods, {n_own},
    sizeof methods / sizeof *methods, {diagnose}, {ensemble}}};
"""
# Exported symbols of a library: the documented functions and the model's own.
EXPORTS_FILE = "exports"
EXPORTS = "{{ global: pk_model; pk_run_*; pk_stability_*; {name}_*; local: *; }};\n"

Blocks = Sequence[tuple[str, Sequence[int]]]  # for each block: its name, indices of its coordinates


def _choice(
    of: str,
    name: str,
    blocks: Blocks,
    own: Sequence[Own] = (),
    parts: Sequence[str] = WHOLE,
    gsl: bool = True,
) -> str:
    """Returns the text of CHOICE_FILE, a C file that defines the struct pk_run_model of the model
    `name`. `of` is the C name of this struct."""
    families = [
        family
        for family in dict.fromkeys(method.family for method in METHODS.values())
        if part_of(family) in parts and (gsl or family != "GSL")
    ]
    text = ""
    for k, (block, coordinates) in enumerate(blocks):
        text += f"extern const struct pk_system {block}_system;\n"
        text += f"static const size_t block{k}[] = {{{', '.join(map(str, coordinates))}}};\n"
    if blocks:
        rows = ", ".join(f"{{&{block}_system, block{k}}}" for k, (block, _) in enumerate(blocks))
        text += f"static const struct pk_part blocks[] = {{{rows}}};\n"
    methods = [f"&pk_method_{method.name}," for method in own]
    methods += [f"PK_METHODS_{family}(ADDRESS, )" for family in families]
    return CHOICE.format(
        of=of,
        name=name,
        own=in_c.definitions(own),
        rows="PK_METHODS_GSL(PK_DECLARE_METHOD, )\n" if "GSL" in families else "",
        blocks=text,
        given="blocks" if blocks else "0",
        count=len(blocks),
        methods=" ".join(methods),
        n_own=len(own),
        **{part: f"&pk_run_{part}" if part in parts else "0" for part in ("diagnose", "ensemble")},
    )


def _portable(tools: Toolchain, files: dict[str, str]) -> Toolchain:
    """Returns `tools`, with the flag for a portable runtime if the model is portable."""
    return replace(tools, flags=(*tools.flags, "-DPK_PORTABLE")) if is_portable(files) else tools


def _linked(
    tools: Toolchain,
    files: dict[str, str],
    name: str,
    blocks: Blocks,
    arguments: list[str],
    folder: Path,
    form: Sequence[str] = (),
    own: Sequence[Own] = (),
) -> None:
    """Compiles the C files of a model with the compiler flags `form`, and links them with the
    linker arguments `arguments`. The steps of methods are inlined in the C code of the model or, if
    the model has blocks of coordinates, in the C code of the blocks."""
    form = [*form, *in_c.flags(own)]
    files = {**files, in_c.FILE: in_c.tables(own)} if own else files
    for file_name, text in files.items():
        (folder / file_name).write_text(text, encoding="utf-8")
    sources = [CHOICE_FILE, *([f"{block}.c" for block, _ in blocks] or [f"{name}.c"])]
    if blocks:
        compile_c(tools, [*form, "-DPK_RUNTIME", "-c", f"{name}.c"], folder)
        sources.append(f"{name}.o")
    compile_c(tools, [*form, "-DPK_RUNTIME", *sources, *arguments], folder)


def build_library(
    files: dict[str, str],
    name: str,
    *methods: str | None,
    ensemble: bool = False,
    diagnose: bool = False,
    able: Sequence[str] = (),
    tools: Toolchain | None = None,
    parts: Blocks = (),
    own: Sequence[Own] = (),
) -> Path:
    """Returns the path of a shared library that integrates the model `name`, built from its files.

    The steps of `methods` are inlined. The library contains the method families of `methods` and
    `able`, or all methods if both are empty. With `ensemble` it can integrate ensembles; with
    `diagnose` it has diagnostics and the functions of pk/stability.h. `parts` are blocks of
    coordinates that are integrated separately; if there are any, the C code of the model itself
    only computes outputs. Raises BuildError with the compiler's messages."""
    tools = _portable(tools or find_toolchain(), files)
    inlined = _inlined(tools, methods, own, ensemble)
    every, names = known(own), [name for name in (*methods, *able) if name]
    asked = {"ensemble": ensemble, "diagnose": diagnose}
    taken = [every.get(name, NONE) for name in names]
    linked = needed(taken, [part for part, is_ in asked.items() if is_]) if names else WHOLE
    choice = _choice("pk_model", name, parts, own, linked, tools.has_gsl)
    made_of = (runtime_name(tools), inlined, choice, in_c.tables(own), sorted(files.items()))
    digest = hashlib.sha256(repr(made_of).encode()).hexdigest()[:24]

    def make(new: Path) -> None:
        library = runtime_library(tools, linked)
        texts = {**files, CHOICE_FILE: choice, EXPORTS_FILE: EXPORTS.format(name=name)}
        flags = [*inlined, "-shared", f"-Wl,--version-script={EXPORTS_FILE}", "-o", "model.so"]
        flags += ["-Wl,-z,defs", "-Wl,--whole-archive", str(library / "librun.a")]
        flags += ["-Wl,--no-whole-archive", *runtime_links(tools, library)]
        _linked(tools, texts, name, parts, flags, new, SHARED, own)

    return cached("models", f"{name[:40]}-{digest}", make) / "model.so"


def _inlined(
    tools: Toolchain, methods: Sequence[str | None], own: Sequence[Own], ensemble: bool
) -> list[str]:
    """Returns the C compiler flags by which steps of the methods are inlined. Without optimization
    inlining saves no time, and [] is returned."""
    flags = [] if {"-O0", "-O1"} & set(tools.flags) else inline_flags(methods, own)
    return [*flags, "-DPK_INLINE_ENSEMBLE"] if flags and ensemble else flags


def build_program(
    files: dict[str, str],
    name: str,
    settings: str,
    output: Path,
    *methods: str | None,
    parts: Blocks = (),
    static: bool = False,
    native: bool = False,
    gsl: bool = False,
    own: Sequence[Own] = (),
    ensemble: bool = False,
) -> None:
    """Builds a standalone program `output`; `settings` is C that defines its settings. With
    `ensemble`, its steps are inlined for blocks of members. Links GSL, which is under the GPL, only
    with `gsl`. The program runs on any processor of the architecture unless `native`. Raises
    BuildError."""
    tools = find_toolchain()
    if not gsl:
        tools = replace(tools, gsl_cflags=None, gsl_libs=())
    if not native:
        tools = replace(tools, flags=tuple(f for f in tools.flags if (f,) not in NATIVE))
    tools = _portable(tools, files)
    library = runtime_library(tools)
    declared = "extern const struct pk_run_settings program_settings;\n"
    choice = _choice("program_model", name, parts, own, gsl=tools.has_gsl) + declared + settings
    inlined = _inlined(tools, methods, own, ensemble)
    linked = [*inlined, *map(str, sorted((RUNTIME / "program").glob("*.c")))]
    linked += ["-o", "program", str(library / "librun.a"), *(["-static"] if static else [])]
    linked += runtime_links(tools, library)
    with scratch() as folder:
        _linked(tools, {**files, CHOICE_FILE: choice}, name, parts, linked, folder, own=own)
        output.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(folder / "program", output)


# A model without equations, linked with the runtime only to list its methods.
NO_MODEL = """#include <pk/system.h>
extern const struct pk_system no_model_system;
const struct pk_system no_model_system = {
    .abi = PK_ABI, .size = sizeof(struct pk_system), .name = "no_model"};
"""


def own_methods(own: Sequence[Own]) -> list[dict[str, object]]:
    """Returns descriptions, made by the runtime, of methods that the user defines for the model."""
    if not own:
        return []
    return load(build_library({"no_model.c": NO_MODEL}, "no_model", own=own)).methods(own=True)


LISTED = RUNTIME / "methods.json"  # a stored list: to compute stability limits takes seconds


def runtime_methods() -> list[dict[str, object]]:
    """Returns descriptions of the runtime's methods; GSL's only if GSL is installed."""
    listed: list[dict[str, object]] = json.loads(LISTED.read_text(encoding="utf-8"))
    if {str(m["name"]) for m in listed} != METHODS.keys():  # `listed` is outdated
        listed = described_methods()
    gsl = find_gsl()[0] is not None
    return [m for m in listed if gsl or METHODS[str(m["name"])].family != "GSL"]


def described_methods() -> list[dict[str, object]]:
    """Compiles the runtime. Returns the descriptions of its methods, which it computes itself."""
    return load(build_library({"no_model.c": NO_MODEL}, "no_model")).methods()
