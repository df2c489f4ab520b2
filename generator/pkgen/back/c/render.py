"""Turns a Program into the text of C files; computes the variables of the templates."""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pkgen_runtime

from ...equations import Quantity
from ...middle.derive.sensitivity import JACOBIANS
from ...middle.report import Report
from ...middle.structure import Structure
from ...model import Definition, Model, Table
from ...system.cache import cached
from ...system.exits import BuildError
from ...version import __version__
from .. import jet
from ..facts import facts, invariants
from ..kernels import KERNELS, OF_FLIGHT
from ..kernels import kernel as spec_of
from ..templates import environment
from . import parameter_code, tables
from .ctext import comment, fold, fold_call, paragraph, string
from .describe import entries, labelled, operations_rows
from .helpers import helpers
from .jet_kernel import signature
from .kernel_code import KernelCode
from .lane_code import LANE_ARGUMENTS, LaneCode
from .program import FamilyProgram, Kernel, Program, operations_text

if TYPE_CHECKING:
    import jinja2

# The fields of Structure that have a bit in enum pk_fact, in the order of the enum.
FACTS = """
    mass_constant mass_diagonal quadratic separable autonomous conservative variational smooth
    affine switched linear_drag affine_rates fast series
"""

# Kernel -> member of struct pk_system, or of a part of that struct.
_IN_CORE = """
    acceleration mass force canonical gradient jacobian energy kinetic potential observe conserve
    linear unconstrained inertia fast
"""
SYSTEM_KERNELS = {
    **{name: name for name in _IN_CORE.split()},
    "constraint": "constraints.values",
    "constraint_jacobian": "constraints.jacobian",
    "residual_scale": "constraints.scale",
    "multipliers": "constraints.multipliers",
    "redundant": "constraints.redundant",
    "singularity": "singularities.values",
    "event": "events.values",
    "switching": "switches.values",
    "corner": "switches.slopes",
    "marking": "marks.values",
    "particles": "particles.at",
    "sampling": "samples.start",
    "meeting": "contacts.values",
    "noise": "noise.values",
}

# Files that connect a model's header and source to the runtime, and their templates.
GLUE = {"_system.h": "glue.h.j2", "_system.c": "glue.c.j2"}

_TESTED = """
    acceleration mass force canonical momenta gradient jacobian energy lagrangian
"""


def render(
    program: Program, *, self_test: bool = False, report: Report | None = None
) -> dict[str, str]:
    """Returns the C files of a model: NAME.h, NAME.c, and the files that connect these to the
    runtime, which embedded C lacks. With `self_test` it adds NAME_selftest.c, which tests the
    kernels. `report`: the simplifications made to a scene; the header lists these."""
    lines = report.lines if report else ()
    context = _context(program) | {"reductions": [str(line) for line in lines]}
    templates = {".h": "header.h.j2", ".c": "source.c.j2"} | ({} if program.plain else GLUE)
    if self_test:
        e, known = program.equations, {kernel.name for kernel in program.kernels}
        missing = [n for n in _TESTED.split() if KERNELS[n].exists(e) and n not in known]
        if missing:
            raise ValueError(f"a self-test needs the kernels {', '.join(missing)} too")
        templates["_selftest.c"] = "selftest.c.j2"
    return _files(program.equations.model.name, context, templates)


def render_families(program: FamilyProgram) -> dict[str, str]:
    """Returns the C files of a model whose families are loops."""
    context = program.context
    templates = {".h": "family_header.h.j2", ".c": "family_source.c.j2"}
    return _files(
        program.equations.model.name, context, templates if context["plain"] else templates | GLUE
    )


def _files(name: str, context: dict[str, Any], templates: dict[str, str]) -> dict[str, str]:
    files = {
        f"{name}{end}": _environment().get_template(template).render(context)
        for end, template in templates.items()
    }
    for pattern, by in _EMBEDDED if context["embedded"] else ():
        files = {name: re.sub(pattern, by, text) for name, text in files.items()}
    return files


# Replacements (pattern, text) that make lean C, which needs no header of the runtime: functions by
# their names in <tgmath.h>, failures as plain numbers.
_EMBEDDED = (
    (r"PK_F\((\w+)\)", r"\1"),
    (r"PK_RESTRICT ", ""),
    (r"PK_INLINE static|static PK_INLINE|PK_INLINE\nstatic", "static inline"),
    (r"PK_FAILED\(PK_FAILURE_DERIVED, 0\)", "-1"),
    (r"PK_FAILED\(PK_FAILURE_SIZE, 0\)", "-2"),
    (r"PK_FAILED\(PK_FAILURE_CONSTRAINT, (\d+)\)", lambda m: f"{-1 - int(m[1])}"),
    (r"PK_FAILED\(PK_FAILURE_CONSTRAINT, (\w+)\)", r"-1 - \1"),
    (r"PK_FAILED\(PK_FAILURE_\w+, (\d+)\)", lambda m: f"{1 + int(m[1])}"),
    (r"PK_FAILED\(PK_FAILURE_\w+, (\w+)\)", r"1 + \1"),
)


PORTABLE = "#define PK_PORTABLE 1 /* no fused multiply-add: the same bits with and without */\n"


@cache
def _order() -> list[str]:
    """Returns the members of struct pk_system, and of its parts, such as "events.table", in the
    order of declaration."""
    headers = sorted(Path(pkgen_runtime.__file__).parent.glob("include/pk/system*.h"))
    text = "".join(path.read_text(encoding="utf-8") for path in headers)
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    members = {}
    for struct, body in re.findall(r"struct (pk_\w+) \{(.*?)\n\};", text, re.DOTALL):
        members[struct] = [
            (declared.split()[1], name)  # (type: for a struct its name; name of the member)
            for declared in body.split(";")[:-1]
            for name in re.findall(r"\(\*(\w+)\)", declared)
            or re.findall(r"(\w+)(?=,|$)", declared)
        ]
    return [
        f"{name}.{inner}" if inner else name
        for of, name in members["pk_system"]
        for _, inner in ([("", "")] + members[of] if of.startswith("pk_part_") else [("", "")])
    ]


def in_order(text: str) -> str:
    """Returns the initializers of struct pk_system, such as `.events.n = 1,`, in the order of
    declaration, as C++ requires. The initializers of a part such as `events` are put in braces."""
    found = dict(re.findall(r"^ {4}\.([\w.]+) = (.*?),$(?=\n {4}\.|\s*\Z)", text, re.DOTALL | re.M))
    assert len(found) == len(re.findall(r"^ {4}\.", text, re.M)), text
    order = {name: k for k, name in enumerate(_order())}
    entries: dict[str, list[str]] = {}
    for name in sorted(found, key=order.__getitem__):
        part, _, member = name.rpartition(".")
        value = " ".join(found[name].split())
        entries.setdefault(part or name, []).append(f".{member} = {value}")
    lines = []
    for name, values in entries.items():
        whole = values[0] if name in found else f".{name} = {{{', '.join(values)}}}"
        lines.append(fold(f"{whole},", 4))
    return "\n".join(lines) + "\n"


def portable(files: dict[str, str]) -> dict[str, str]:
    """Returns the files with fused multiply-add switched off, as if compiled with -DPK_PORTABLE."""
    return {
        name: text.replace("#include ", f"{PORTABLE}#include ", name.endswith(".c"))
        for name, text in files.items()
    }


def is_portable(files: dict[str, str]) -> bool:
    return any(PORTABLE in text for text in files.values())


TEMPLATES = Path(__file__).parent / "templates"


@cache
def _environment() -> jinja2.Environment:
    import jinja2

    made = environment(TEMPLATES)
    made.filters |= {
        "comment": comment,
        "string": string,
        "paragraph": paragraph,
        "fold": fold,
        "fold_call": fold_call,
        "in_order": in_order,
    }
    texts = [path.read_bytes() for path in sorted(TEMPLATES.iterdir())]
    made_by = repr((texts, jinja2.__version__, sys.version_info[:2]))

    def translate(folder: Path) -> None:
        made.bytecode_cache = jinja2.FileSystemBytecodeCache(str(folder))
        for name in made.list_templates():
            made.get_template(name)

    # The templates' bytecode is cached: translating them takes longer than a short run.
    with suppress(BuildError):
        folder = cached("templates", hashlib.sha256(made_by.encode()).hexdigest()[:24], translate)
        made.bytecode_cache = jinja2.FileSystemBytecodeCache(str(folder))
    return made


def source_of(header: str) -> str:
    path = Path(pkgen_runtime.__file__).parent / "include" / "pk" / header
    return path.read_text(encoding="utf-8")


def pasted(header: str) -> str:
    """Returns the text of a header in runtime/include/pk, without those that it includes."""
    return re.sub(r"#include <pk/.*>\n+", "", source_of(header))


# The licence of a header.
PASTED = """
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */"""


def unguarded(header: str) -> str:
    """Returns the text of pasted(header) without its licence and its include guard, for a file that
    states the licence and has the text once."""
    head, _, rest = pasted(header).replace(PASTED, " */").partition("#ifndef ")
    return head + rest.partition("\n\n")[2].rpartition("\n#endif")[0]


def _lookup(model: Model) -> str:
    """Returns the functions that read tables; those of no table of the model are left out, since
    compilers warn of unused functions."""
    text, variables = pasted("lookup.h"), {len(table.units) - 1 for table in model.tables}
    for count, name in ((1, "pk_lookup"), (2, "pk_lookup2")):
        if count not in variables:
            function = rf"/\*[^/]*\*/\nstatic inline pk_real {name}\(.*?\n}}\n\n"
            text = re.sub(function, "", text, flags=re.DOTALL)
    return text


def frame(
    model: Model,
    proved: Structure,
    kernels: set[str],
    parameters: list[dict[str, Any]],
    names: dict[str, Sequence[Quantity | Definition]],
    fields: Sequence[tuple[str, Table]],
) -> dict[str, Any]:
    """Returns the template variables that all models have. `kernels` are the model's kernels,
    `proved` its facts, `names` the tables of quantities, `fields` the tables of data."""
    return {
        "version": __version__,
        "name": model.name,
        "description": model.description,
        "source_name": model.source.path.replace("\\", "/").rsplit("/", 1)[-1],
        "source_hash": model.sha256,
        "real_header": pasted("real.h"),
        "plain": False,
        "embedded": False,
        "table_header": pasted("table.h") if model.tables else "",
        "lookup_header": _lookup(model) if model.tables else "",
        "data": tables.data(model.name, fields),
        "table_fields": fields,
        "parameters": parameters,
        "tables": names,
        "n_parameters": len(parameters),
        "n_inputs": len(names["inputs"]),
        "samples": model.samples,
        "resetting": model.resetting,
        **dict.fromkeys(("held", "reset_events", "meetings", "row_modes"), ()),
        "n_observed": len(names["observed"]),
        "n_conserved": len(names["conserved"]),
        "facts": [f"PK_{field.upper()}" for field in FACTS.split() if getattr(proved, field)],
        "system_kernels": [
            {"name": kernel, "field": field}
            for kernel, field in SYSTEM_KERNELS.items()
            if kernel in kernels
        ],
        "jacobian_names": [*JACOBIANS],
    }


def _context(program: Program) -> dict[str, Any]:
    equations = program.equations
    present = {kernel.name for kernel in program.kernels}
    parameters, names = tables.parameters(program), tables.tables(program)
    return {
        **frame(equations.model, program.structure, present, parameters, names, program.tables),
        "sincos_header": pasted("sincos.h") if program.has_sincos else "",
        "jet": signature(program.equations.model.name) if program.jet else "",
        "jet_wide": program.jet.wide if program.jet else "",
        "jet_fast": program.jet.fast if program.jet else 0,
        "jet_says": jet.SAYS.replace("NAME", program.equations.model.name),
        "plain": program.plain,
        **(EMBEDDED if program.plain else {}),
        "sizes": [],
        "n": len(equations.coordinates),
        "n_first_order": equations.n_first_order,
        "states": [q.name for q in equations.rates[equations.own :]],
        # Whether p = dL/dv and the energy is v.p - L, so that the self-test can check this.
        "has_lagrangian": int("lagrangian" in present and not equations.inertia),
        "n_rotations": sum(bool(a.numbers) for a in equations.attitudes),
        "entries": tables.system_entries(program),
        "events": tables.events(equations) if tables.has(program, "events") else [],
        "marks": [mark.quantity.name for mark in equations.marks],
        "switches": [switch.quantity.name for switch in equations.switches],
        "counted": equations.counted,
        "impulses": [x.impulse for x in equations.switches] if equations.impulsive else [],
        "constants": program.constants,
        "factored": program.factored,
        "counts": tables.counts(program),
        "indices": tables.indices(program),
        "fields": tables.fields(program),
        "any_follows": any(p.follows for p in equations.parameters),
        "kernels": [_kernel(program, kernel) for kernel in program.kernels],
        "operations": operations_rows(program),
        "proved": labelled(facts(equations, program.structure)),
        "constant": labelled(invariants(equations, program.structure)),
        "apart": int(any(len(kernel.blocks) > 1 for kernel in program.all_kernels)),
        "helpers": helpers(program.helpers),
        "float_too": program.float_too,
        "singularities": tables.singularities(program),
        "cyclic": [int(flag) for flag in program.structure.cyclic],
        "has_linear": int("linear" in present),
        "has_parts": int({"kinetic", "potential"} <= present),
        "input_rates": tables.input_rates(equations.inputs),
        "noises": equations.noise.names if equations.noise else (),
        "held": tables.held(equations),
        "reset_events": tables.reset_events(equations),
        "meetings": tables.meetings(equations),
        "row_modes": tables.row_modes(equations),
        "functions": _functions(program),
        "forms": list(program.lanes),
        "lane_arguments": LANE_ARGUMENTS,
    }


REAL = """\
/* Numbers are double, or with -DPK_FLOAT float, with -DPK_LONG_DOUBLE long double. */
#ifndef PK_REAL_H
#define PK_REAL_H
#if defined PK_FLOAT
typedef float pk_real;
#define PK_C(x) x##F
#define PK_EPSILON FLT_EPSILON
#elif defined PK_LONG_DOUBLE
typedef long double pk_real;
#define PK_C(x) x##L
#define PK_EPSILON LDBL_EPSILON
#else
typedef double pk_real;
#define PK_C(x) x
#define PK_EPSILON DBL_EPSILON
#endif
#define PK_PI PK_C(3.14159265358979323846264338327950288)
#define PK_INFINITY ((pk_real)INFINITY)
#define PK_PIVOT_MIN (16 * PK_EPSILON) /* a smaller pivot of M, beside its diagonal, is rounding */
#endif
"""


# Embedded C contains the definition REAL in place of the header real.h.
EMBEDDED = {"embedded": True, "real_header": REAL}


def _functions(program: Program) -> str:
    """Returns all C functions of the file, separated by blank lines."""
    names = {"name": program.equations.model.name, "n": len(program.equations.coordinates)}
    dense = _environment().get_template("dense.j2").make_module(names)
    solve = str(dense.acceleration(program.factored))
    found = list(parameter_code.functions(program))
    if any(kernel.solves for kernel in program.kernels):
        found.insert(0, str(dense.functions()))
    modes = tables.modes(program.equations)
    for kernel in program.kernels:
        free = " && ".join(f"!(u[{k}] < 0 || u[{k}] > 0)" for k in modes)
        of_flight = kernel.name in OF_FLIGHT
        code = KernelCode(program.equations.model.name, kernel, free if of_flight else "")
        if kernel.name == "acceleration" and not program.plain:
            found += LaneCode(program, code).functions(solve)
        else:
            found += [*code.parts(), code.definition(solve)]
    found += [program.jet.one] if program.jet else []
    return "\n".join(x if isinstance(x, str) else x.text for x in found)


def _kernel(program: Program, kernel: Kernel) -> dict[str, Any]:
    spec, code = spec_of(kernel.name), KernelCode(program.equations.model.name, kernel)
    return {
        "name": kernel.name,
        "result": kernel.result,
        "given": list(spec.given),
        "declaration": code.declaration(),
        "outputs": [{"name": o.name, "n": o.rows, "columns": o.columns} for o in kernel.outputs],
        "says": spec.says,
        "entries": entries(program, kernel),
        "operations": operations_text(kernel.operations),
    }
