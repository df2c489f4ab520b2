"""The methods of the runtime, as much of them as the generator must know without a C compiler. The
tests compare it with what the runtime says of itself."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Method:
    """`inlined`: the family that -DPK_INLINE_ names, if its steps are compiled together with a
    model, whose kernels are inlined (see pk/inlined.h). `requires`: facts of a system."""

    inlined: str
    traits: frozenset[str]
    requires: tuple[str, ...]

    @property
    def fixed(self) -> bool:
        """Whether a run by it must be given its step."""
        return not {"adaptive", "exact"} & self.traits


SEPARABLE = "mass_constant separable"
_TABLE = (
    ("euler rk2 rk3 rk4", "ERK", "quadrature", ""),
    ("dopri5 dop853", "EMBEDDED", "adaptive quadrature", ""),
    ("symplectic_euler verlet yoshida4 suzuki4 mclachlan4", "SPLITTING", "", SEPARABLE),
    ("blanes_moan4 yoshida6 kahan_li6 blanes_moan6", "SPLITTING", "", SEPARABLE),
    ("yoshida8 kahan_li8", "SPLITTING", "", SEPARABLE),
    ("adaptive_verlet", "", "adaptive linear", f"{SEPARABLE} autonomous"),
    ("gauss", "GAUSS", "adaptive quadrature", "smooth"),
    ("gauss1 gauss2 gauss3 gauss4 gauss5 gauss6 gauss7 gauss8", "", "jacobians quadrature", ""),
    ("lobatto2 lobatto3 lobatto4 radau5 radau9", "", "jacobians quadrature", ""),
    ("radau", "", "adaptive jacobians quadrature", ""),
    ("exponential", "", "exact", "affine"),
    ("lie_midpoint lie_midpoint4 lie_midpoint6", "", "group holonomic quadrature", ""),
    ("rattle rattle4 rattle6", "", "group holonomic quadrature", ""),
    ("rkmk4 rkmk8", "", "group quadrature", ""),
    ("gsl_rkf45 gsl_rk8pd gsl_msadams", "", "adaptive", ""),
    ("gsl_msbdf", "", "adaptive linear", ""),
    ("gsl_bsimp", "", "adaptive linear no_inputs", ""),
)
METHODS = {
    name: Method(inlined, frozenset(traits.split()), tuple(requires.split()))
    for names, inlined, traits, requires in _TABLE
    for name in names.split()
}


def provides(structure: object, fact: str) -> bool:
    """Whether a run of a system has what a method requires: where switches are located each of its
    steps is one of smooth equations."""
    if fact == "smooth" and getattr(structure, "smooth_in_pieces", False):
        return True
    return bool(getattr(structure, fact, False))


def carries_quadratures(method: str) -> bool:
    """So do the default methods ("")."""
    return method not in METHODS or "quadrature" in METHODS[method].traits


def in_blocks(method: str, steps: bool) -> bool:
    """Whether members go side by side: by methods of a fixed step, or that are given one."""
    family = METHODS[method].inlined if method in METHODS else ""
    return family in ("ERK", "SPLITTING") or (family == "EMBEDDED" and steps)


def called(method: str) -> frozenset[str]:
    """The kernels that a method calls, beside those of what it integrates."""
    traits = METHODS[method].traits if method in METHODS else frozenset()
    kernels = {"acceleration", "guard", "event", "observe", "quadrature"}
    if method == "gauss":
        kernels |= {"lanes"}  # its stages
    if method in METHODS and METHODS[method].inlined == "SPLITTING":
        kernels |= {"advance"}  # of families kept as loops
    if traits & {"linear", "exact"}:
        kernels |= {"mass", "linear"}
    if "jacobians" in traits:
        kernels |= {"canonical", "mass", "jacobian"}
    if "holonomic" in traits:  # of systems with rotations or constraints: unbound and inertia
        kernels |= {"canonical", "mass", "unbound", "inertia"}
    return frozenset(kernels)


def inline_flags(methods: Iterable[str | None]) -> list[str]:
    """Flags to compile the steps of these methods with a model: others only take time."""
    families: dict[str, list[str]] = {}
    for method in dict.fromkeys(methods):
        if method in METHODS and METHODS[method].inlined:
            families.setdefault(METHODS[method].inlined, []).append(f"X({method})")
    flags = []
    for family, named in sorted(families.items()):
        flags.append(f"-DPK_INLINE_{family}")
        if family != "GAUSS":  # which has one
            flags.append(f"-DPK_{family}_METHODS(X)={' '.join(named)}")
    return flags
