"""`pkgen import`: what it writes moves as the robot that was read."""

from __future__ import annotations

import importlib
import random
import sys
from argparse import Namespace
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from random_states import state_of
from robot_files import heavy, joint, link, text_of
from trees_of_bodies import Link, Motion, turn
from trees_of_bodies import of_quaternion as quaternion

from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.middle.derive.derive import derive
from pkgen.source import Diagnostic, ModelError, Source, Span
from pkgen_robots.read import imported
from pkgen_robots.turns import matrix as matrix_of
from pkgen_robots.turns import of_quaternion, of_roll_pitch_yaw

ARM = """<robot name="two-link">
<link name="base"/>
<link name="upper arm"><visual><geometry><mesh filename="package://x/upper.stl"/></geometry></visual>
<inertial><origin xyz="0 0.1 -0.25" rpy="0.1 0.3 0.4"/><mass value="1.5"/>
<inertia ixx="0.03" iyy="0.03" izz="0.002" ixy="0.001" ixz="0" iyz="0"/></inertial></link>
<link name="fore"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
<inertia ixx="0.02" iyy="0.02" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="int"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper arm"/>
<origin xyz="0 0 1" rpy="0.3 0.2 0.5"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="5"/>
<dynamics damping="0.3" friction="0.1"/></joint>
<joint name="elbow" type="continuous"><parent link="upper arm"/><child link="fore"/>
<origin xyz="0.1 0 -0.5" rpy="1.5707963267948966 0 0"/><calibration rising="0"/></joint>
<joint name="fore" type="fixed"><parent link="fore"/><child link="int"/></joint>
<transmission name="t"/>
</robot>"""
MIMIC = '<mimic joint="{}" multiplier="{}" offset="{}"/>'
G = np.array([0, 0, -9.81])


def roll_pitch_yaw(r: float, p: float, y: float) -> list:
    return [((0, 0, 1), y), ((0, 1, 0), p), ((1, 0, 0), r)]


def matrix(turns) -> np.ndarray:
    found = np.eye(3)
    for axis, angle in turns:
        found = found @ turn(axis, angle)
    return found


def accelerations(text: str, links: list[Link], seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    model = check_text(Source("robot.lag", text))[0]
    e = derive(model)
    symbols, values, rates = state_of(model, random.Random(seed))
    motion = Motion(links, values, rates, G)
    names = [c.name for c in model.coordinates]
    turns = {r.name: r.turns for r in model.rotations}
    order = [
        names.index(w if isinstance(w, str) else turns[b.rotation][w]) for b, w in motion.speeds
    ]
    found = np.array(evaluate(e.graph, e.acceleration[: len(names)], symbols))[order]
    return found, motion.accelerations()


def test_a_urdf_moves_as_it_says(tmp_path):
    xml = ARM.replace('damping="0.3"', 'damping="0"')
    c = matrix(roll_pitch_yaw(0.1, 0.3, 0.4))
    own = np.array([[0.03, 0.001, 0], [0.001, 0.03, 0], [0, 0, 0.002]])
    upper = (np.array([0, 0, 1]), roll_pitch_yaw(0.3, 0.2, 0.5), 1.5, np.array([0, 0.1, -0.25]))
    fore = (np.array([0.1, 0, -0.5]), roll_pitch_yaw(np.pi / 2, 0, 0), 1, np.array([0, 0, -0.2]))
    tensor = np.diag([0.02, 0.02, 0.001])
    links = [
        Link("upper", -1, "revolute", np.array([0, 1, 0]), *upper, c @ own @ c.T, ["shoulder"]),
        Link("fore", 0, "revolute", np.array([1, 0, 0]), *fore, tensor, ["elbow"]),
    ]
    found, wanted = accelerations(text_of(tmp_path, xml), links)
    assert abs(found - wanted).max() < 1e-10 * abs(wanted).max()
    assert abs(wanted).min() > 0.1


def test_what_it_writes(tmp_path):
    text = text_of(tmp_path, ARM)
    left = "# left out: <transmission> (1), <calibration> of <joint> (1), friction of a joint (1)"
    assert left in text and "# mesh package://x/upper.stl" in text
    assert "limits [-2.0, 2.0]  # limits: effort 5.0" in text
    assert "dissipation (0.3 [N*m*s])/2*shoulder'^2" in text
    assert "joint fore_joint: fore to x_int" in text or "joint fore_joint: fore to int_2" in text
    model, warnings = check_text(Source("arm.lag", text))
    assert not warnings and [c.name for c in model.coordinates] == ["shoulder", "elbow"]
    free = check_text(Source("arm.lag", text_of(tmp_path, ARM, "free").replace("base mass 0.0",
        "base mass 1")))[0]  # fmt: skip
    assert len(free.coordinates) == 8 and len(free.rotations) == 1


MJCF = """<mujoco model="m"><compiler angle="radian"/><option gravity="0 0 -9.81"/>
<worldbody><geom type="plane"/><body name="a" pos="0.1 0.2 0.3" quat="0.8 0.6 0 0">
<inertial pos="0.1 0 0.2" mass="1.2" diaginertia="0.3 0.2 0.1" quat="0.6 0 0.8 0"/>
<joint name="h" type="hinge" axis="0 1 0" pos="0 0 0.1" range="-1 1"/>
<joint name="s" type="slide" axis="1 0 0" pos="0.2 0 0"/><geom size="1"/>
<body name="b" pos="0 0 0.5" euler="0.1 0.2 0.3"><inertial pos="0 0.1 0" mass="0.7"
 fullinertia="0.2 0.3 0.4 0.01 0.02 0.03"/><joint name="r" type="ball" pos="0.1 0 0"/></body>
</body></worldbody><actuator/></mujoco>"""


def test_mjcf_moves_as_it_says(tmp_path):
    """Frames of the language are at the joints, those of MJCF are not."""
    q = np.array([[1, 0, 0], [0, 0.28, -0.96], [0, 0.96, 0.28]])  # of 0.8, 0.6, 0, 0
    own = matrix([((0, 1, 0), 2 * np.arctan2(0.8, 0.6))])
    zero, full = np.zeros(3), np.array([[0.2, 0.01, 0.02], [0.01, 0.3, 0.03], [0.02, 0.03, 0.4]])
    about_x = [((1, 0, 0), 2 * np.arctan2(0.6, 0.8))]
    at = np.array([0.1, 0.2, 0.3]) + q @ [0, 0, 0.1]
    links = [
        Link("h", -1, "revolute", np.eye(3)[1], at, about_x, 0, zero, 0 * full, ["h"]),
        Link("s", 0, "prismatic", np.eye(3)[0], np.array([0.2, 0, -0.1]), [], 1.2,
             np.array([-0.1, 0, 0.2]), own @ np.diag([0.3, 0.2, 0.1]) @ own.T, ["s"]),
    ]  # fmt: skip
    euler = [((1, 0, 0), 0.1), ((0, 1, 0), 0.2), ((0, 0, 1), 0.3)]
    at = np.array([-0.2, 0, 0.5]) + matrix(euler) @ [0.1, 0, 0]
    com = np.array([-0.1, 0.1, 0])
    links.append(Link("b", 1, "spherical", zero, at, euler, 0.7, com, full, [], "r"))
    found, wanted = accelerations(text_of(tmp_path, MJCF), links)
    assert abs(found - wanted).max() < 1e-10 * abs(wanted).max()
    assert abs(wanted).min() > 1e-2


@pytest.mark.parametrize("seed", range(20))
def test_turns(seed):
    draw = random.Random(seed)
    angles = [draw.choice((draw.uniform(-4, 4), np.pi / 2, -np.pi, 0)) for _ in range(3)]
    wanted = matrix(roll_pitch_yaw(*angles))
    assert abs(np.array(matrix_of(of_roll_pitch_yaw(angles))) - wanted).max() < 1e-14
    q = np.array([draw.gauss(0, 1) for _ in range(4)])
    found = np.array(matrix_of(of_quaternion(tuple(3 * q))))
    assert abs(found - quaternion(q / np.linalg.norm(q))).max() < 1e-14


def test_right_angles_are_exact(tmp_path):
    """Sines and cosines are 0 and 1 in the C too; of what is written with fewer digits they are
    what is written."""
    assert "turned rot([1, 0, 0], pi/2)" in text_of(tmp_path, ARM)
    short = text_of(tmp_path, ARM.replace("1.5707963267948966", "1.5707963268"))
    assert "rot([1, 0, 0], 1.5707963268)" in short


LIMITS = {
    "both": ("revolute", 'lower="-1.5707963267948966" upper="2"', "limits [-pi/2, 2.0]", ""),
    "way": ("prismatic", 'lower="0" upper="0.04"', "limits [0.0, 0.04] [m]", ""),
    "beyond 0": ("revolute", 'lower="1" upper="2"', "limits [1.0, 2.0]", "start j = 1.5  #"),
    "none": ("revolute", 'effort="1"', "# limits: effort 1.0", ""),
    "swapped": (
        "revolute",
        'lower="2" upper="1"',
        "",
        "# limits of 'j' left out: 2.0 is not below",
    ),
    "continuous": ("continuous", 'lower="2" upper="3"', "", ""),
}


@pytest.mark.parametrize("case", LIMITS)
def test_limits_are_those_of_the_file(tmp_path, case):
    kind, limit, on_joint, elsewhere = LIMITS[case]
    links = link() + link("b", heavy("1"))
    xml = f"<robot name='r'>{links}{joint('j', 'a', 'b', kind, f'<limit {limit}/>')}</robot>"
    text = text_of(tmp_path, xml)
    (line,) = (line for line in text.split("\n") if line.startswith("joint j"))
    assert on_joint in line and elsewhere in text
    assert ("limits [" in line) == on_joint.startswith("limits")
    check_text(Source("r.lag", text))


def test_what_carries_no_mass_is_fixed_and_said_to_be(tmp_path):
    links = link() + link("b", heavy("1")) + link("c") + link("d")
    joints = joint("j", "a", "b") + joint("k", "b", "c") + joint("l", "c", "d", "prismatic")
    text = text_of(tmp_path, f"<robot name='r'>{links}{joints}</robot>")
    assert "# left out: joints that carry no mass: fixed (2)" in text
    model, warnings = check_text(Source("r.lag", text))
    assert [c.name for c in model.coordinates] == ["j"] and not warnings


def test_the_command(pkgen, tmp_path):
    robot = tmp_path / "arm.urdf"
    robot.write_text(ARM)
    done = pkgen("import", robot, "-o", tmp_path / "arm.lag")
    assert done.returncode == 0 and "<calibration> of <joint> (1)" in done.stderr
    ran = pkgen("run", tmp_path / "arm.lag", "--until", "0.1", "--start", "shoulder=1")
    assert ran.returncode == 0 and "elbow" in ran.stdout
    robot.write_text("<robot><link/></robot>")
    done = pkgen("import", robot)
    assert done.returncode == 1 and "arm.urdf:1:8: error" in done.stderr and not done.stdout
    assert pkgen("import", tmp_path / "none.urdf").returncode == 2


def test_places_on_the_command_line_and_on_pages(pkgen, tmp_path):
    """--record takes a body's places; pages show bodies as they are written."""
    (tmp_path / "arm.urdf").write_text(ARM)
    model = tmp_path / "arm.lag"
    assert pkgen("import", tmp_path / "arm.urdf", "-o", model).returncode == 0
    columns = "fore.com,upper_arm.omega,fore.com.x'"
    ran = pkgen("run", model, "--until", "0.1", "--every", "0.1", "--record", columns)
    vectors = [f"{name}.{axis}" for name in ("fore.com", "upper_arm.omega") for axis in "xyz"]
    assert ran.stdout.splitlines()[0].split(",")[:7] == ["t", *vectors], ran.stderr
    if find_spec("pkgen_pages") is None:
        return  # the page is of another add-on
    page = tmp_path / "arm.html"
    assert pkgen("explain", model, "--html", page).returncode == 0
    assert "joint shoulder: base to upper_arm revolute" in page.read_text()


SHARED = "cmeel.prefix/share/example-robot-data/robots"
ROBOTS = ("ur_description/urdf/ur5_robot", "panda_description/urdf/panda")


@pytest.mark.parametrize("robot", ROBOTS)
def test_robots_of_others_as_pinocchio_has_them(robot):
    """Where `pip install pin example-robot-data` was done."""
    pinocchio = pytest.importorskip("pinocchio")
    found = [p for folder in sys.path if (p := Path(folder) / SHARED / f"{robot}.urdf").is_file()]
    if not found:
        pytest.skip("no robots here")
    own = pinocchio.buildModelFromUrdf(str(found[0]))
    text = "\n".join(s for s in imported(found[0])[0].split("\n") if "dissipation" not in s)
    model = check_text(Source("robot.lag", text))[0]
    names = [c.name for c in model.coordinates]
    e = derive(model)
    symbols, values, rates = state_of(model, random.Random(robot))
    order = [own.joints[own.getJointId(name)].idx_v for name in names]
    q, v = np.zeros(own.nq), np.zeros(own.nv)
    for name, k in zip(names, order, strict=True):
        q[k], v[k] = values[name], rates[name]
    wanted = pinocchio.aba(own, own.createData(), q, v, np.zeros(own.nv))[order]
    found = np.array(evaluate(e.graph, e.acceleration, symbols))
    assert abs(found - wanted).max() < 1e-12 * abs(wanted).max()


def test_a_mimic_is_a_constraint(pkgen, tmp_path):
    """Of a turn a turn or a slide; of a mimic a mimic; of what is fixed nothing."""
    links = link("base") + "".join(link(x, heavy("1")) for x in "abc")
    joints = joint("j", "base", "a", "revolute", '<axis xyz="0 1 0"/>')
    joints += joint("k", "a", "b", "prismatic", MIMIC.format("j", "2", "0.5"))
    joints += joint("l", "b", "c", "revolute", '<axis xyz="0 1 0"/>' + MIMIC.format("k", "-3", "0"))
    text = text_of(tmp_path, f"<robot name='r'>{links}{joints}</robot>")
    assert "constraint k_mimic: k = (2.0 [m])*j + (0.5 [m])" in text
    assert "constraint l_mimic: l = (-3.0 [1/m])*k" in text
    assert "start k = 0.5 [m]" in text and "start l = -1.5  #" in text
    (tmp_path / "r.lag").write_text(text)
    done = pkgen(
        "run", tmp_path / "r.lag", "--until", "0.5", "--every", "0.25", "--record", "j,k,l"
    )
    rows = [[float(x) for x in row.split(",")] for row in done.stdout.splitlines()[1:]]
    assert len(rows) == 3 and abs(rows[-1][1]) > 0.01
    for _, j, k, m in rows:
        assert abs(k - 2 * j - 0.5) < 1e-9 and abs(m + 3 * k) < 1e-9
    for of, why in (("l", "go round in a circle"), ("x", "there is no joint 'x'")):
        wrong = joints.replace(MIMIC.format("j", "2", "0.5"), MIMIC.format(of, "2", "0.5"))
        with pytest.raises(ModelError) as error:
            text_of(tmp_path, f"<robot name='r'>{links}{wrong}</robot>")
        assert why in error.value.text()


@pytest.mark.parametrize("seed", range(8))
def test_whatever_is_not_read_is_named(seed, tmp_path):
    """Unknown children and attributes at any places."""
    rng = random.Random(seed)
    root = ElementTree.fromstring(ARM)
    places = [e for e in root.iter() if e.tag not in ("transmission", "calibration")]
    wanted = []
    for k in range(6):
        parent = rng.choice(places)
        if rng.random() < 0.5:
            parent.set(f"extra{k}", "1")
            wanted.append(f"'extra{k}' of <{parent.tag}>")
        else:
            parent.insert(rng.randrange(len(parent) + 1), ElementTree.Element(f"extra{k}"))
            wanted.append(f"<extra{k}>" + f" of <{parent.tag}>" * (parent is not root))
    (tmp_path / "r.urdf").write_text(ElementTree.tostring(root, "unicode"))
    notes = imported(tmp_path / "r.urdf")[1].notes()
    assert [what for what in wanted if what not in notes[0]] == []


def test_a_model_that_is_refused_is_not_written(tmp_path, monkeypatch):
    command, made = importlib.import_module("pkgen_robots.command"), tmp_path / "r.lag"

    def refuse(source: Source) -> None:
        raise ModelError(source, [Diagnostic("no", Span(0, 1))])

    monkeypatch.setattr(command, "check_model", refuse)
    (tmp_path / "r.urdf").write_text(ARM)
    options = Namespace(model=tmp_path / "r.urdf", base="fixed", json=False, output=str(made))
    with pytest.raises(ModelError) as error:
        command.run(options)
    assert error.value.text().startswith(f"{made}:1:1: error: no") and not made.exists()
