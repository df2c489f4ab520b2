"""The facts about integration methods that the generator needs, read without a C compiler from the
runtime's registry, pk/methods.h and pk/gsl.h."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import pkgen_runtime

from .record import record


@record
class Method:
    """A row of the registry; `requires` has facts that a system must have, fields of Structure."""

    family: str
    traits: frozenset[str]
    requires: tuple[str, ...]

    @property
    def inlined(self) -> str:
        """Returns the method's family if its steps can be compiled together with a model, so that
        the model's kernels are inlined (-DPK_INLINE_ flags, pk/inlined.h); else ""."""
        return self.family if self.family in INLINED else ""

    @property
    def exact(self) -> bool:
        """Whether steps have no error at any step size."""
        return "exact" in self.traits

    @property
    def fixed(self) -> bool:
        """Whether a run needs a step size."""
        return not {"adaptive", "exact"} & self.traits

    @property
    def kernels(self) -> frozenset[str]:
        """Returns the kernels that a run by the method calls."""
        words = (self.family, *self.traits, *self.requires)
        return CALLED.union(*(CALLED_FOR.get(word, ()) for word in words))


@record
class Own(Method):
    """A method defined by a model or the command line: a tableau file, or weights of a composition.
    `table` is C with its coefficients; `facts` are computed properties, such as the order."""

    name: str
    order: int
    stages: int
    dense_order: int
    table: str
    doc: str
    facts: tuple[tuple[str, object], ...] = ()

    @property
    def row(self) -> str:
        """Returns the C that defines the method, by PK_DEFINE_METHOD (pk/methods.h)."""
        flags = " | ".join(f"PK_{trait.upper()}" for trait in sorted(self.traits)) or "0"
        numbers = f"{self.order}, {self.stages}, {self.dense_order}"
        text = re.sub(r'[^ -~]|["\\?]', "_", self.doc)  # doc may have any character
        return (
            f"PK_DEFINE_METHOD(PK_FAMILY_{self.family}, {self.name}, {numbers}, {flags}, "
            f'{self.name}, "{text}");'
        )


HEADERS = Path(pkgen_runtime.__file__).parent / "include" / "pk"
# kernels of every method
CALLED = frozenset(("acceleration", "singularity", "event", "noise", "observe"))
CALLED_FOR = {  # further kernels, by family, trait or required fact
    "GAUSS": ("lanes",),  # evaluates stages in SIMD lanes
    "SPLITTING": ("advance",),  # makes several steps in one call, for families kept as loops
    "linear": ("mass", "linear"),
    "exact": ("mass", "linear"),
    "fast": ("fast",),
    "jets": ("jet",),
    "jacobians": ("canonical", "mass", "jacobian"),
    # The last two kernels are for rotations or constraints.
    "holonomic": ("canonical", "mass", "unconstrained", "inertia"),
}
INLINED = ("ERK", "EMBEDDED", "SPLITTING", "GAUSS", "TAYLOR")  # families with a flag -DPK_INLINE_
_FAMILY = re.compile(r"#define PK_METHODS_(\w+)\(X, A\)((?:.*\\\n)+.*)")
_ROW = re.compile(r"X\(A, (\w+), \d+, \d+, \d+, ([\w |]+),\s*\\?\s*\w+,")
_DEFINED = re.compile(r"#define (PK_\w+)\s+\\?\s*\(?((?:PK_\w+(?: \| )?)+|0)\)?\n")


def _read(text: str) -> dict[str, Method]:
    """Returns the methods in the registry's text; expressions in it are names joined by |."""
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
    """Returns the methods by name: the runtime's and `own`."""
    return {**METHODS, **{method.name: method for method in own}}


# Maps a fact to facts that imply it. A run locates switches, so that each step integrates smooth
# equations.
STRONGER = {
    "smooth": ("smooth_in_pieces",),
    "linear_drag": ("separable",),
    "affine_rates": ("linear_drag", "separable"),
}


def provides(structure: object, fact: str) -> bool:
    """Whether a system has a fact that a method requires, or a fact that implies it."""
    return any(getattr(structure, name, False) for name in (fact, *STRONGER.get(fact, ())))


def in_lanes(method: Method | None, structure: object) -> bool:
    """Whether steps of ensemble members run in SIMD lanes."""
    family = method.inlined if method else ""
    if family == "SPLITTING":
        return provides(structure, "separable")
    return family in {"ERK", "EMBEDDED"} or (
        family == "TAYLOR" and provides(structure, "series") and getattr(structure, "smooth", False)
    )


NONE = Method("", frozenset(), ())  # a method outside the registry: GSL's without GSL


def inline_flags(methods: Iterable[str | None], own: Iterable[Own] = ()) -> list[str]:
    """Returns flags that compile the steps of these methods, and no others, with a model."""
    families: dict[str, list[str]] = {}
    all_methods = known(own)
    for method in dict.fromkeys(methods):
        if method in all_methods and all_methods[method].inlined:
            families.setdefault(all_methods[method].inlined, []).append(f"X({method})")
    flags = []
    for family, named in sorted(families.items()):
        flags.append(f"-DPK_INLINE_{family}")
        if family not in ("GAUSS", "TAYLOR"):  # these families have a single method
            flags.append(f"-DPK_{family}_METHODS(X)={' '.join(named)}")
    return flags
