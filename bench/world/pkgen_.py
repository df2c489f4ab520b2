"""pkgen itself, as a Python program runs it, whose runtime has been compiled before."""

from __future__ import annotations

import os
import tempfile

import pkgen

from .cases import ROOT, UNTIL

VERSION = "pkgen"
FILES = {
    "wind": "bench/lag/world/wind.lag",
    "springs": "models/particles/bilinear_spring.lag",
    "road": "models/bodies/quarter_car.lag",
    "arm": "models/controlled/two_joint_pid.lag",
    "motors": "models/parts/two_motors.lag",
}
BEST = {"rtol": 1e-12}
COLUMNS = {
    "wind": ("hip", "knee"),
    "springs": ("x",),
    "road": ("z", "w"),
    "arm": ("a", "b"),
    "motors": ("left.phi", "right.phi"),
}


def _compiled_runtime() -> None:
    """In an empty cache, so that no model of these is in it."""
    os.environ["PKGEN_CACHE"] = tempfile.mkdtemp(prefix="bench_world_")
    pkgen.load(ROOT / "models/particles/thrown_stone.lag").run(1)


def _prepared(model: str):
    def prepare(way: str):
        m = pkgen.load(ROOT / FILES[model])
        columns = [*COLUMNS[model], *(f"{x}'" for x in COLUMNS[model])]
        options = {} if way == "default" else BEST

        def go():
            until = UNTIL[model]
            rows = m.run(until, every=until, record=columns, **options)
            go.seconds = rows.report["seconds"]  # without the call around it
            return [rows[c][-1] for c in columns]

        return go

    return prepare


_compiled_runtime()
MODELS = {model: _prepared(model) for model in FILES}
WAYS = dict.fromkeys(FILES, ("default", "best"))
COUNTED = {model: (ROOT / path,) for model, path in FILES.items()}
COUNTED["motors"] += (ROOT / "models/parts/motor.lag",)
SAYS = {
    "wind": ("body, joint, force at a point", "–"),
    "springs": ("if", "located by itself"),
    "road": ("table spline", "stops at knots by itself"),
    "arm": ("sample block", "stops at samples by itself"),
    "motors": ("use twice, constraint", "–"),
}
