"""Robots as text of URDF, and what is written of a file."""

from __future__ import annotations

from pathlib import Path

from pkgen_robots.read import imported


def text_of(tmp_path: Path, xml: str, base: str = "fixed") -> str:
    file = tmp_path / "robot.xml"
    file.write_text(xml, encoding="utf-8")
    return imported(file, base)[0]


def link(name: str = "a", inside: str = "") -> str:
    return f'<link name="{name}">{inside}</link>'


def joint(name: str, parent: str, child: str, kind: str = "revolute", inside: str = "") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


def heavy(mass: str, ixx: str = "1") -> str:
    others = 'iyy="1" izz="1"'
    return f'<inertial><mass value="{mass}"/><inertia ixx="{ixx}" {others}/></inertial>'
