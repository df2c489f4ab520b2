"""Converts a robot file to the text of a model."""

from __future__ import annotations

import os

from pkgen.front.read import read_text

from . import mjcf, urdf
from .robot import Robot, text
from .xml import tree

FORMATS = {"robot": urdf.robot, "mujoco": mjcf.robot}


def imported(path: str | os.PathLike[str], base: str = "fixed") -> tuple[str, Robot]:
    """Returns the text of a .lag file and the Robot from which it is made. Raises ModelError with
    the position of an error in the file."""
    source = read_text(path, "a URDF or MJCF file")
    root = tree(source)
    if root.tag not in FORMATS:
        help = "URDF begins with <robot>, MJCF with <mujoco>"
        raise root.wrong(f"<{root.tag}> is neither URDF nor MJCF", help)
    robot = FORMATS[root.tag](root, base)
    if all(joint.kind == "fixed" for joint in robot.joints):
        raise root.wrong("nothing moves: every joint is fixed", "--base free lets the root go")
    return text(robot, os.path.basename(source.path)), robot
