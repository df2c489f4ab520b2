"""The option `pkgen run --diagnose`: names of diagnostics, and the models to which they apply.

Names and required kernels are read from runtime/run/diagnose/diagnostics.h. docs/diagnostics.md
explains the keys of results; `diagnostics_text.py` formats them.
"""

from __future__ import annotations

import re

from ..compiler import Compilation
from ..middle.motion import LINEAR_OF_FEW, PARTICLES
from ..middle.refused import refuse_diagnostics
from ..source import Diagnostic
from ..system.exits import UsageError
from ..system.near import near
from ..system.toolchain import RUNTIME

TABLE = RUNTIME / "run" / "diagnose" / "diagnostics.h"
_ROW = re.compile(r"X\((\w+), (\w+), (\w+)\)")


def _named(column: int, word: str) -> tuple[str, ...]:
    return tuple(row[0] for row in _ROWS if row[column] == word)


_ROWS = _ROW.findall(TABLE.read_text(encoding="utf-8").partition("#define")[2])
OF_MEMBERS = _named(1, "MEMBERS")
OF_REDUCED = _named(1, "REDUCED")  # diagnostics for which a scene may be reduced
NAMES = tuple(name for name, *_ in _ROWS if name not in OF_MEMBERS)
OF_PARTICLES = frozenset(("all", *_named(2, "PARTICLES")))
LINEARISED = frozenset(("all", *_named(2, "LINEAR")))  # diagnostics that need the kernel `linear`
OF_ALL_KERNELS = frozenset(_named(2, "EVERY"))


def asked(text: str | None, ensemble: str | None = None) -> tuple[str, ...]:
    """Parses `--diagnose lyapunov,spectrum`: returns each name once, or ("all",). Raises
    UsageError."""
    if text is None:
        return ()
    names = [name.strip() for name in text.split(",")]
    if ensemble is not None:
        refuse_several(tuple(names), "for --ensemble")
    if names == ["all"]:
        return ("all",)
    for name in names:
        if name not in (*NAMES, *OF_MEMBERS):
            known = [*NAMES, *OF_MEMBERS, "all"]
            raise UsageError(
                f"--diagnose {text}: there is no '{name}'; {near(name, known, 'diagnostic')}"
            )
    return tuple(name for name in (*NAMES, *OF_MEMBERS) if name in names)


def refuse_several(names: tuple[str, ...], what: str) -> None:
    """Raises UsageError if a diagnostic that needs a single trajectory is requested for an
    ensemble."""
    if set(names) != set(OF_MEMBERS):
        raise UsageError(f"--diagnose is for one trajectory, not {what}, which has 'area' alone")


def kernels(names: tuple[str, ...]) -> frozenset[str] | None:
    """Returns the kernels that the diagnostics need, or None if the default kernels are enough.

    The kernel `linear` of a large model, and the kernel PARTICLES, are included only if requested.
    """
    from ..back.kernels import all_but

    wanted = all_but() | ({PARTICLES} if OF_PARTICLES.intersection(names) else set())
    if not LINEARISED.intersection(names):
        wanted = wanted - {"linear"} | {LINEAR_OF_FEW}
    return wanted if {"linear", PARTICLES} & wanted or OF_ALL_KERNELS.intersection(names) else None


def refuse(names: tuple[str, ...], compilation: Compilation, several: bool) -> None:
    """Raises UsageError for diagnostics of particles if the model has none, and for diagnostics of
    ensembles if there is one trajectory."""
    refuse_diagnostics(compilation.declared, names)
    if not several and set(OF_MEMBERS).intersection(names):
        raise UsageError(
            "--diagnose area is of a closed loop of starts: of a scene with a swarm, or --ensemble"
        )
    particles = compilation.equations.particles if PARTICLES in (kernels(names) or ()) else None
    if particles is None or "all" in names:
        return
    of = next(name for name in names if name in OF_PARTICLES)
    if not compilation.model.coordinates:
        raise UsageError(f"--diagnose {of} is of particles, and the model has states alone")
    from ..middle.particles.bodies import listed
    from ..middle.particles.particles import HELP

    if not particles.masses:
        said = f"--diagnose {of} is of particles, and of this model none are seen: {particles.why}"
        found = Diagnostic(said, particles.span, HELP)
        raise UsageError(found.text(compilation.model.source))
    if "lrl" in names and len(particles.masses) > 2:
        raise UsageError(
            f"--diagnose lrl is of one particle, or of two about each other; "
            f"'{compilation.model.name}' has {len(particles.masses)}: {listed(particles.names)}"
        )


def name_places(report: dict, compilation: Compilation) -> None:
    """Adds to diagnostics of particles the names of the particles' positions, and a text on those
    terms of the Lagrangian that belong to no particle."""
    for name, found in report.get("diagnostics", {}).items():
        if name in OF_PARTICLES and found["status"] == "PK_DONE":
            particles = compilation.equations.particles
            found["places"] = list(particles.names)
            found["beyond"] = particles.beyond or None


def of_whole(text: str | None) -> bool:
    """Whether `text`, the value of --diagnose, names a diagnostic that needs the whole model,
    without reductions by the scene."""
    return text is not None and not {*asked(text)} <= {*OF_REDUCED}
