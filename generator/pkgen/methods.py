"""The methods of the runtime, as much of them as the generator must know without a C compiler, read
in the runtime's own registry.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import pkgen_runtime

from .record import record


@record
class Method:
    """`requires`: facts of a system."""

    family: str
    traits: frozenset[str]
    requires: tuple[str, ...]

    @property
    def inlined(self) -> str:
        """The family that -DPK_INLINE_ names, if its steps are compiled with a model, whose kernels
        are inlined then (see pk/inlined.h)."""
        return self.family if self.family in INLINED else ""

    @property
    def exact(self) -> bool:
        """Its steps are exact, whatever their length."""
        return "exact" in self.traits

    @property
    def fixed(self) -> bool:
        """Whether a run by it must be given its step."""
        return not {"adaptive", "exact"} & self.traits


@record
class Own(Method):
    """A method that a model or the command line brings: a table of a family of the runtime, with
    the C of its coefficients. `facts`: what its coefficients were found to be."""

    name: str
    order: int
    stages: int
    dense_order: int
    table: str
    doc: str
    facts: tuple[tuple[str, object], ...] = ()

    @property
    def row(self) -> str:
        """In C, as one of pk/methods.h."""
        flags = " | ".join(f"PK_{trait.upper()}" for trait in sorted(self.traits)) or "0"
        numbers = f"{self.order}, {self.stages}, {self.dense_order}"
        text = re.sub(r'[^ -~]|["\\?]', "_", self.doc)  # names a file, which may be called anything
        return (
            f"PK_DEFINE_METHOD(PK_FAMILY_{self.family}, {self.name}, {numbers}, {flags}, "
            f'{self.name}, "{text}");'
        )


HEADERS = Path(pkgen_runtime.__file__).parent / "include" / "pk"
INLINED = ("ERK", "EMBEDDED", "SPLITTING", "GAUSS")  # families that -DPK_INLINE_ names
_FAMILY = re.compile(r"#define PK_METHODS_(\w+)\(X, A\)((?:.*\\\n)+.*)")
_ROW = re.compile(r"X\(A, (\w+), \d+, \d+, \d+, ([\w |]+),\s*\\?\s*\w+,")
_DEFINED = re.compile(r"#define (PK_\w+)\s+\\?\s*\(?((?:PK_\w+(?: \| )?)+|0)\)?\n")


def _read(text: str) -> dict[str, Method]:
    """The rows of pk/methods.h, whose expressions are names joined by |."""
    defined = dict(_DEFINED.findall(text))

    def words(expression: str) -> list[str]:
        found = []
        for name in expression.strip("() ").split(" | "):
            within = words(defined[name]) if name in defined else [name[3:].lower()]
            found += [word for word in within if word]
        return found

    return {
        name: Method(family, frozenset(words(traits)), tuple(words(f"PK_NEEDS_{family}")))
        for family, rows in _FAMILY.findall(text)
        for name, traits in _ROW.findall(rows)
    }


METHODS = _read("".join((HEADERS / name).read_text("utf-8") for name in ("methods.h", "gsl.h")))


def known(own: Iterable[Own] = ()) -> dict[str, Method]:
    """The runtime's methods and those that a model brings."""
    return {**METHODS, **{method.name: method for method in own}}


# What includes a fact: where switches are located each step is one of smooth equations.
STRONGER = {
    "smooth": ("smooth_in_pieces",),
    "linear_drag": ("separable",),
    "affine_rates": ("linear_drag", "separable"),
}


def provides(structure: object, fact: str) -> bool:
    """Whether a run of a system has what a method requires."""
    return any(getattr(structure, name, False) for name in (fact, *STRONGER.get(fact, ())))


def in_lanes(method: Method | None, structure: object) -> bool:
    """Whether steps of an ensemble's members are made side by side."""
    family = method.inlined if method else ""
    if family == "SPLITTING":
        return provides(structure, "separable")
    return family in {"ERK", "EMBEDDED"}


NONE = Method("", frozenset(), ())  # what the generator knows of GSL's methods with no GSL


def called(of: str | Method) -> frozenset[str]:
    """The kernels that a method calls, beside those of what it integrates."""
    method = METHODS.get(of, NONE) if isinstance(of, str) else of
    traits = method.traits
    kernels = {"acceleration", "singularity", "event", "observe"}
    if method.family == "GAUSS":
        kernels |= {"lanes"}  # its stages
    if method.inlined == "SPLITTING":
        kernels |= {"advance"}  # of families kept as loops
    if traits & {"linear", "exact"}:
        kernels |= {"mass", "linear"}
    if "fast" in method.requires:
        kernels |= {"fast"}
    if "jacobians" in traits:
        kernels |= {"canonical", "mass", "jacobian"}
    if "holonomic" in traits:  # of systems with rotations or constraints: unconstrained and inertia
        kernels |= {"canonical", "mass", "unconstrained", "inertia"}
    return frozenset(kernels)


def inline_flags(methods: Iterable[str | None], own: Iterable[Own] = ()) -> list[str]:
    """Flags to compile the steps of these methods with a model: others only take time."""
    families: dict[str, list[str]] = {}
    all_methods = known(own)
    for method in dict.fromkeys(methods):
        if method in all_methods and all_methods[method].inlined:
            families.setdefault(all_methods[method].inlined, []).append(f"X({method})")
    flags = []
    for family, named in sorted(families.items()):
        flags.append(f"-DPK_INLINE_{family}")
        if family != "GAUSS":  # which has one
            flags.append(f"-DPK_{family}_METHODS(X)={' '.join(named)}")
    return flags
