"""Methods whose steps are compiled together with a model, its kernels inlined; see pk/inlined.h."""

from __future__ import annotations

from collections.abc import Iterable

# By the family that -DPK_INLINE_ names.
INLINED = {
    method: family
    for family, methods in {
        "ERK": "euler rk2 rk3 rk4",
        "EMBEDDED": "dopri5 dop853",
        "SPLITTING": "symplectic_euler verlet yoshida4 suzuki4 mclachlan4 blanes_moan4 "
        "yoshida6 kahan_li6 blanes_moan6 yoshida8 kahan_li8",
        "GAUSS": "gauss",
    }.items()
    for method in methods.split()
}


def inline_flags(methods: Iterable[str | None]) -> list[str]:
    """Flags to compile the steps of these methods alone: others only take time."""
    families: dict[str, list[str]] = {}
    for method in dict.fromkeys(methods):
        if method in INLINED:
            families.setdefault(INLINED[method], []).append(f"X({method})")
    flags = []
    for family, named in sorted(families.items()):
        flags.append(f"-DPK_INLINE_{family}")
        if family != "GAUSS":  # which has one
            flags.append(f"-DPK_{family}_METHODS(X)={' '.join(named)}")
    return flags
