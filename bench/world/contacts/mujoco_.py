"""MuJoCo: soft contacts; a stiffness and a damping per unit mass stand for restitution."""

from __future__ import annotations

import math

import mujoco

from ..mujoco_ import VERSION  # noqa: F401
from .cases import LESS, MU, OVER, SLENDER, SPEED, TILT, TIMES


def bounce(e, k):
    """solref of a spring and damper whose push ends after a bounce with e."""
    low, high = 0.0, 0.999
    for _ in range(60):
        z = (low + high) / 2
        r = math.sqrt(1 - z * z)
        much = math.exp(-z / r * math.atan2(2 * z * r, 2 * z * z - 1)) > e
        low, high = (z, high) if much else (low, z)
    return f"{-k} {-2 * z * math.sqrt(k)}"


def ball(k):
    touch = f'solref="{bounce(0.8, k)}" solimp="1 1"'
    return f"""<mujoco><worldbody><geom type="plane" size="9 9 1" {touch}/>
      <body pos="0 0 0.1"><joint type="slide"/><geom size="0.1" mass="1" {touch}/></body>
    </worldbody></mujoco>"""


def cradle(k):
    one = """<body pos="{} 0 0"><joint type="slide" axis="1 0 0" stiffness="3.27"/>
      <geom size="0.025" mass="0.1" solref="{} 0" solimp="1 1"/></body>"""
    balls = "".join(one.format(i * (0.05 + 1e-6), -k) for i in range(5))
    return f'<mujoco><option gravity="0 0 0"/><worldbody>{balls}</worldbody></mujoco>'


PLANAR = """<joint type="slide" axis="1 0 0"/><joint type="slide"/><joint axis="0 -1 0"/>"""


def rock(k):
    a, b = math.sin(SLENDER), math.cos(SLENDER)
    return f"""<mujoco><worldbody><geom type="plane" size="9 9 1" friction="3"/>
      <body pos="0 0 {b}">{PLANAR}<geom type="box" size="{a} 0.2 {b}" mass="1" friction="3"/></body>
    </worldbody></mujoco>"""


def box(k, over):
    slope = math.atan(MU + over)
    return f"""<mujoco><option gravity="{9.81 * math.sin(slope)} 0 {-9.81 * math.cos(slope)}"/>
      <worldbody>
      <geom type="plane" size="9 9 1" friction="0.5"/>
      <body pos="0 0 0.2">{PLANAR}
        <geom type="box" size="0.3 0.2 0.2" mass="2" friction="0.5"/></body>
    </worldbody></mujoco>"""


def belt(k):
    return """<mujoco><option gravity="0 0 0"/><worldbody>
      <body><joint name="belt" type="slide" axis="1 0 0"/><geom size="0.1" mass="1e6"/>
        <body pos="0 0 1"><joint name="slip" type="slide" axis="1 0 0" frictionloss="1.5"/>
          <geom size="0.1" mass="1"/></body></body></worldbody>
      <tendon><fixed stiffness="1" springlength="0">
        <joint joint="belt" coef="1"/><joint joint="slip" coef="1"/></fixed></tendon></mujoco>"""


def graze(k, stop):
    return f"""<mujoco><option gravity="0 0 0"/><worldbody><body>
      <joint type="slide" axis="1 0 0" stiffness="1" limited="true" range="-9 {stop}"
        solreflimit="{bounce(0.5, k)}" solimplimit="1 1"/><geom size="0.1" mass="1"/>
    </body></worldbody></mujoco>"""


def static_or_not(model, data, steps):
    """One number is both frictions: the user's loop tells them apart, above the creep."""
    creep = 1e-6 if model.opt.noslip_iterations else 2e-3
    for _ in range(steps):
        model.dof_frictionloss[1] = 1.5 if abs(data.qvel[1]) < creep else 1
        mujoco.mj_step(model, data)


def tilted():
    a, b, c, s = math.sin(SLENDER), math.cos(SLENDER), math.cos(TILT), math.sin(TILT)
    return [a * c - b * s, a * s + b * c - b, TILT]


def accurate(name, model, step):
    model.opt.timestep = step
    if name in ("rock", "box", "belt"):
        model.opt.cone, model.opt.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 1e4
    if name == "belt":
        model.opt.noslip_iterations = 20
    if name in ("rock", "belt"):  # the box has a steady load: stiffer contacts shake it loose
        model.geom_solref[:] = model.dof_solref[:] = 2 * step, 1  # the stiffest that it allows


def _case(build, q, v, step, k, means: str, says: str, pick=list, runs=((),), loop=mujoco.mj_step):
    """k is the stiffness of contacts with restitution, per unit mass."""
    name = build.__name__

    def prepare(way: str):
        texts = [build(1e4 if way == "default" else k, *x) for x in runs]
        models = [mujoco.MjModel.from_xml_string(text) for text in texts]
        for model in models if way == "best" else ():
            accurate(name, model, step)

        def go():
            end = []
            for model in models:
                data, done = mujoco.MjData(model), 0
                data.qpos[:], data.qvel[:] = q, v
                for t in TIMES[name]:
                    steps = round(t / model.opt.timestep)
                    loop(model, data, steps - done)
                    done = steps
                    end += [*pick(data.qpos), *pick(data.qvel)]
            return end

        return go

    return prepare, (build, loop) if name == "belt" else (build,), means, says


def first(x):
    return x[:1]


LOSS, XML = "XML, frictionloss, own loop", "XML, solref for e"
STOPS, SLOPES = ((1 - LESS,), (1 + LESS,)), ((-OVER,), (OVER,))
HANGS, TILTED, SLIDES = [-0.1, *[0] * 4], tilted(), [SPEED, 0, 0]
CASES = {
    "ball": _case(ball, 0, 5, 1e-5, 1e7, XML, "soft: no impact; rests, no time told"),
    "cradle": _case(cradle, HANGS, [0] * 5, 5e-7, 4e11, XML, "soft: all balls move at once"),
    "rock": _case(rock, TILTED, [0] * 3, 1e-4, 0, "XML", "rests, no time told", lambda x: x[2:]),
    "box": _case(
        box,
        [0] * 3,
        SLIDES,
        1e-4,
        0,
        "XML",
        "slides on both / stops, creeps; slides on",
        first,
        SLOPES,
    ),
    "belt": _case(
        belt,
        [0, 0],
        [0.1, 0],
        1e-4,
        0,
        LOSS,
        "creeps; own switch to slip",
        lambda x: [sum(x)],
        loop=static_or_not,
    ),
    "graze": _case(graze, 0, 1, 1e-5, 1e9, "XML, limit of a joint", "soft: no impact", list, STOPS),
}
