"""pkgen itself, as a Python program runs it, whose runtime has been compiled before."""

from __future__ import annotations

import atexit
import os
import tempfile

import pkgen

from .cases import ROOT, UNTIL

VERSION = "pkgen"
BEST = {"rtol": 1e-12}


def ready() -> None:
    """A cache that has the compiled runtime and none of the models."""
    cache = tempfile.TemporaryDirectory(prefix="bench_world_")
    atexit.register(cache.cleanup)
    os.environ["PKGEN_CACHE"] = cache.name
    pkgen.load(ROOT / "models/particles/thrown_stone.lag").run(1)


def _case(name: str, files: list[str], coordinates: str, means: str, kink: str = "–") -> tuple:
    columns = [*coordinates.split(), *(f"{x}'" for x in coordinates.split())]

    def prepare(way: str):
        m, until = pkgen.load(ROOT / files[0]), UNTIL[name]
        options = {} if way == "default" else BEST

        def go():
            rows = m.run(until, every=until, record=columns, **options)
            go.seconds = rows.report["seconds"]  # without the call around it
            return [rows[c][-1] for c in columns]

        return go

    return prepare, [ROOT / file for file in files], means, kink


PARTS = ["models/parts/two_motors.lag", "models/parts/motor.lag"]
SPRINGS, CAR = "models/particles/bilinear_spring.lag", "models/bodies/quarter_car.lag"
ARM, WIND = "models/controlled/two_joint_pid.lag", "bench/lag/world/wind.lag"
CASES = {
    "wind": _case("wind", [WIND], "hip knee", "body, force at a point"),
    "springs": _case("springs", [SPRINGS], "x", "if", "located by itself"),
    "road": _case("road", [CAR], "z w", "table spline", "stops by itself"),
    "arm": _case("arm", [ARM], "a b", "sample block", "stops by itself"),
    "motors": _case("motors", PARTS, "left.phi right.phi", "use twice, constraint"),
}
