"""MuJoCo: a model in XML, fixed steps; the user's functions are called at each stage of a step."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline

from .cases import UNTIL, road

VERSION = f"MuJoCo {mujoco.__version__}"


def wind():
    text = """<mujoco><worldbody>
      <body name="upper"><joint name="hip" axis="0 -1 0"/>
        <inertial pos="0 0 -0.5" mass="1" diaginertia="0.09 0.09 0.01"/>
        <body name="lower" pos="0 0 -1"><joint name="knee" axis="0 -1 0"/>
          <inertial pos="0 0 -0.4" mass="0.5" diaginertia="0.03 0.03 0.005"/>
          <site name="tip" pos="0 0 -0.8"/></body></body>
    </worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = 1.2, -0.5
    J = np.zeros((3, 2))

    def drag(m, d):
        mujoco.mj_jacSite(m, d, J, None, 0)
        d.qfrc_passive[:] += J.T @ (0.2 * (np.array([4, 0, 0]) - J @ d.qvel))

    mujoco.set_mjcb_passive(drag)
    return model, data


def springs():
    text = """<mujoco><option gravity="0 0 0"/><worldbody>
      <body><joint name="x" type="slide" axis="1 0 0" stiffness="4"/>
        <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody>
      <tendon><fixed stiffness="21" springlength="0 1000">
        <joint joint="x" coef="1"/></fixed></tendon>
    </mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = 0.3
    return model, data


def car():
    text = """<mujoco><option gravity="0 0 0"/><worldbody>
      <body><joint name="z" type="slide"/>
        <inertial pos="0 0 0" mass="300" diaginertia="1 1 1"/></body>
      <body><joint name="w" type="slide"/>
        <inertial pos="0 0 0" mass="40" diaginertia="1 1 1"/></body></worldbody>
      <tendon><fixed stiffness="20e3" damping="1500" springlength="0">
        <joint joint="z" coef="1"/><joint joint="w" coef="-1"/></fixed></tendon>
      <actuator><position joint="w" kp="180e3"/></actuator>
    </mujoco>"""
    height = CubicSpline(*road())

    def tyre(m, d):
        d.ctrl[0] = height(15 * d.time)

    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.set_mjcb_control(tyre)
    return model, data


def arm():
    text = """<mujoco><worldbody>
      <body><joint name="a" axis="0 -1 0"/>
        <inertial pos="0 0 -0.5" mass="2" diaginertia="1e-15 1e-15 1e-15"/>
        <body pos="0 0 -0.5"><joint name="b" axis="0 -1 0"/>
          <inertial pos="0 0 -0.4" mass="1.5" diaginertia="1e-15 1e-15 1e-15"/></body></body>
      </worldbody>
      <actuator><motor joint="a" ctrlrange="-45 45"/>
        <motor joint="b" ctrlrange="-20 20"/></actuator>
    </mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = -0.5, 0.3
    return model, data


def pid_loop(model, data, until, T=0.01):
    kp, ki, kd = np.array([150, 90]), np.array([200, 120]), np.array([25, 12])
    most, to, s = np.array([45, 20]), np.array([1, 0.5]), np.zeros(2)
    steps = round(T / model.opt.timestep)
    for _ in range(round(until / T)):
        error = to - data.qpos
        data.ctrl[:] = kp * error + ki * s - kd * data.qvel  # clamped by ctrlrange
        s += np.where(abs(data.ctrl) < most, T * error, 0)
        mujoco.mj_step(model, data, steps)


def motors():
    motor = """<mujoco><option gravity="0 0 0"/><worldbody>
      <body><joint name="phi" damping="0.01"/>
        <inertial pos="0 0 0" mass="1" diaginertia="{J} {J} {J}"/></body></worldbody>
      <actuator><general name="coil" joint="phi" gainprm="{gain}" biastype="affine"
        biasprm="0 0 {back}"/></actuator></mujoco>"""
    both = mujoco.MjSpec()
    both.option.gravity = 0, 0, 0
    for name, J, R in (("left.", 0.02, 1.5), ("right.", 0.3, 4)):
        part = motor.format(J=J, gain=0.3 / R, back=-(0.3**2) / R)
        frame = both.worldbody.add_frame()
        both.attach(mujoco.MjSpec.from_string(part), prefix=name, frame=frame)
    gear = both.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1="left.phi", name2="right.phi")
    gear.objtype = mujoco.mjtObj.mjOBJ_JOINT
    gear.data[:2] = 0, 3
    model = both.compile()
    data = mujoco.MjData(model)
    data.qvel[:], data.ctrl[:] = (3, 1), (12, 0)
    return model, data


def _case(name: str, build, step: float, means: str, kink: str = "–", loop=None) -> tuple:
    def prepare(way: str):
        mujoco.set_mjcb_passive(None)
        mujoco.set_mjcb_control(None)
        model, data = build()
        q, v, u = data.qpos.copy(), data.qvel.copy(), data.ctrl.copy()
        if way == "best":
            model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
            model.opt.timestep = step
            model.eq_solref[:] = 2 * step, 1  # the stiffest that it allows

        def go():
            mujoco.mj_resetData(model, data)
            data.qpos[:], data.qvel[:], data.ctrl[:] = q, v, u
            if loop:
                loop(model, data, UNTIL[name])
            else:
                mujoco.mj_step(model, data, round(UNTIL[name] / model.opt.timestep))
            return [*data.qpos, *data.qvel]

        return go

    return prepare, (build, loop) if loop else (build,), means, kink


CASES = {
    "wind": _case("wind", wind, 1e-3, "XML, callback"),
    "springs": _case("springs", springs, 1e-4, "XML, tendon's dead band", "smeared silently"),
    "road": _case("road", car, 2e-4, "XML, CubicSpline, callback", "crossed silently"),
    "arm": _case("arm", arm, 1e-3, "XML, own loop", "own whole steps", pid_loop),
    "motors": _case("motors", motors, 1e-4, "attach twice, soft equality"),
}
