"""Robots of others for `bench arms`: URDF files of the wheel `example-robot-data`.

pkgen has them by `pkgen import`, the others as Pinocchio reads them: two readers of one file, whose
accelerations, M and f have to agree. What Pinocchio leaves out, pkgen leaves out too: damping."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from .arm_models import Link
from .builds import OUTPUT, Broken, Unavailable
from .peers.dynamics import folder_of
from .peers.own import pkgen_python

SHARED = Path("share", "example-robot-data", "robots")
ROBOTS = {
    "UR5": "ur_description/urdf/ur5_robot.urdf",
    "Panda": "panda_description/urdf/panda.urdf",
    "G1": "g1_description/urdf/g1_29dof_rev_1_0.urdf",
}


def file_of(name: str) -> Path:
    """The folder of wheels that share one prefix has Pinocchio and the robots."""
    path = folder_of("pinocchio", "pin").parents[3] / SHARED / ROBOTS[name]
    if not path.exists():
        raise Unavailable("example-robot-data is not installed")
    return path


def lag(name: str) -> str:
    """What `pkgen import` writes, by the model's name `robot_NAME`."""
    target = OUTPUT / "generated" / "arms" / f"{name}_imported.lag"
    target.parent.mkdir(parents=True, exist_ok=True)
    command = [pkgen_python(), "-m", "pkgen", "import", file_of(name), "-o", target]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise Broken(f"pkgen import of {name}: {(done.stderr.splitlines() or ['?'])[-1]}")
    lines = [line for line in target.read_text().splitlines() if "dissipation" not in line]
    return "\n".join([f"model robot_{name.lower()}", *lines[1:]]) + "\n"


def tree(name: str, text: str) -> list[Link]:
    """As Pinocchio reads the file, its joints in the order that they have in `text`."""
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(file_of(name)))
    found: list[Link] = []
    numbers = {0: -1}
    for joint in re.findall(
        r"^joint (\w+): \w+ to \w+  (?:revolute|prismatic) ", text, re.MULTILINE
    ):
        k = next(k for k, n in enumerate(model.names) if re.sub(r"\W", "_", n) == joint)
        numbers[k] = len(found)
        kind, axis = _motion(model.joints[k])
        place, body = model.jointPlacements[k], model.inertias[k]
        found.append(
            Link(
                numbers[model.parents[k]],
                kind,
                axis,
                tuple(place.translation),
                tuple(map(tuple, place.rotation)),
                body.mass,
                tuple(body.lever),
                tuple(map(tuple, body.inertia)),
            )
        )
    if len(found) != model.nv or model.nv != model.nq:
        raise Broken(f"{name}: Pinocchio has {model.nv} freedoms, pkgen {len(found)}")
    return found


def _motion(joint) -> tuple[str, tuple[float, ...]]:
    """Its kind and its axis, by the name of its class, JointModelRX and so on."""
    name = joint.shortname().removeprefix("JointModel")
    kind = "prismatic" if name.startswith("P") else "revolute"
    if name.endswith("Unaligned"):
        return kind, tuple(joint.extract().axis)
    return kind, tuple(float(name[-1] == axis) for axis in "XYZ")
