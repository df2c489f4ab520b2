"""Random systems made of parts, and the same systems in one file, which the test writes: they have
the same accelerations, mass matrix, energy, starts, outputs and events."""

import random
import re

import numpy as np
import pytest

import pkgen
from pkgen.scenes import lengths

# Files of parts. In one file, `@` becomes the name of the part with an underscore.
SPRING = """
param @m = {m} [kg] in (0, inf)
param @k = 3*@m*{c} [1/s^2]                 # follows m
param @c = {c} [kg/s]
input @F [N], @G [N]
coord @x [m]
let @s = @x - {a} [m]
let @y = @F + 2*@G
kinetic @m/2*@x'^2
potential @k/2*@s^2
force @x = @y - @c*@x'
observe @p = 2*@p_x
event @through: @s rising
state @z [m]
rate @z = @s*(1 [1/s]) - @z*{c} [1/s]
start @x = {a}, @x' = {c}
draw bob [@x, 0, 0] radius 0.1
"""
PENDULUM = """
param @m = {m} [kg]
param @l = {c} [m]
const @g = 9.81 [m/s^2]
input @F [N], @G [N]
coord @x [m], @theta [rad]
let @T = @l*cos(@theta)
let @r = [@x + @l*sin(@theta), -@T, 0]
kinetic @m/2*dot(@r', @r') + {a} [kg]*@x'^2
potential @m*@g*@r.y
dissipation {c} [kg/s]/2*@x'^2
force @r = [@F, @G, 0]
force @wind at @r = -{a} [kg/s]*@r'
observe @place = @r
observe @power = power(@wind)
constraint @track: @x*cos(@theta/7)*{a} = 0.1 [m]*@theta
observe @tension = @lambda_track
start @theta = {a}, @x = 0.1*{a}/cos({a}/7)/{a}
event @top: @theta' falling
scene @quick
  set @m = 2
  until 1
end
"""
BODIES = """
param @m = {m} [kg]
input @F [N], @G [N*m]
gravity [0, {a} [m/s^2], -9.81 [m/s^2]]
body @upper mass @m inertia [{a}, {m}, {c}] at [0, 0, -{c}]
body @lower mass 1 [kg] inertia [{c}, {c}, {a}] at [0, 0, -{a}]
joint @pivot: ground to @upper revolute [0, {c}, 1]
joint @knee: @upper to @lower spherical at [0, {a} [m], -{c}]
let @x = dot(@lower.point([0, 0, {a} [m]]), [1, 0, 0])
force @lower.com = [@F, 0, 0]
torque @upper = [0, @G, {a} [N*m]]
observe @w = @lower.omega
start @pivot = {a}, omega(@knee) = [{a}, 1, {c}]
"""
CHAIN = """
size @N = 3
param @k = {m} [N/m]
param @ms[i = 1..@N] = {c} [kg]*i
input @F [N], @G [N]
coord @qs[1..@N] [m]
free @qs[0]
fixed @qs[@N+1] = {a} [m]
let @x = sum(@qs[i], i = 1..@N)/@N
kinetic sum(@ms[i]*@qs[i]'^2/2, i = 1..@N)
potential sum(@k*(@qs[i+1] - @qs[i])^2/2, i = 0..@N)
force @qs[i = 2..@N] = @F + i*@G
observe @third = @qs[3] + @p_qs[2]*(1 [s/kg])
start @qs[i = 1..@N] = {a}*i
"""
TURNING = """
param @J = {m} [kg*m^2]
input @F [N*m], @G [N*m]
rotation @R
let @w = omega(@R)
let @x = (@R*[0, 0, {a} [m]]).x
kinetic @J/2*dot(@w, @w) + {c} [kg*m^2]*@w.z^2
potential {a} [J]*(@R*[1, 0, 0]).z
force @R = [@F, 0, @G]
observe @turn = @R*[0, 1, 0]
observe @L = @p_R
start @R = rot([1, {a}, 0], {c}), omega(@R) = [0, {a}, 1]
"""
FILES = {
    "spring": SPRING,
    "pendulum": PENDULUM,
    "bodies": BODIES,
    "chain": CHAIN,
    "turning": TURNING,
    "pair": "",
}
# A part with parts: what stands in it of its own.
PAIR = """
param @stiff = {m} [N/m]
input @F [N], @G [N]
let @twice = 2*@F
use "spring0.lag" as @a with m = 2*@stiff*(1 [kg*m/N])
use "pendulum1.lag" as @b
set @a.F = @twice
let @x = @b.x - @a.x
potential @stiff/2*@x^2
set @b.G = @a.x*({c} [N/m]) + @G
observe @of_a = @a.p_x
"""
# Where units differ, the value of an input in the part.
UNIT = {"bodies": ("N", "N*m"), "turning": ("N*m", "N*m")}


def numbers(draw):
    return {k: f"{draw.uniform(0.4, 1.6):.3f}" for k in "amc"}


class System:
    """The texts of the files, and of all in one file: first what declares, then the rest."""

    def __init__(self, draw):
        self.files, self.first, self.rest, self.last = {}, [], [], []
        parts = [(f"p{k}", draw.choice([*FILES])) for k in range(draw.randint(1, 3))]
        own, k0 = [], f"{draw.uniform(1, 2):.3f}"
        use = [f"param k0 = {k0}"]
        self.first.append(use[0])
        for name, kind in parts:
            given = {}
            if kind in ("spring", "pendulum", "bodies") and draw.random() < 0.6:
                given["m"] = f"{draw.uniform(1, 2):.3f}*k0 [kg]"
            if kind == "chain" and draw.random() < 0.6:
                given["N"] = "4"
            file = f"{kind}{draw.randrange(2)}.lag"
            self._add(name, FILES[kind], file, given)
            said = ", ".join(f"{k} = {v}" for k, v in given.items())
            use.append(f'use "{file}" as {name}' + f" with {said}" * bool(said))
        before = []
        for name, kind in parts:
            units = UNIT.get(kind, ("N", "N"))
            for which, unit in zip("FG", units, strict=True):
                if draw.random() < 0.7:
                    a, b = (f"{draw.uniform(-1, 1):.3f}" for _ in "ab")
                    terms = [f"{a} [{unit}]*sin(3 [1/s]*t)"]
                    terms += [f"{b} [{unit}/m]*{n}.x" for n in before if draw.random() < 0.5]
                    use.append(f"set {name}.{which} = {' + '.join(terms)}")
                    self._drive(f"{name}.{which}", " + ".join(terms))
            before.append(name)
        own.append("coord y [m]\nkinetic (k0 [kg])*y'^2\nstart y = 0.2")
        for name, _ in parts:
            own.append(f"potential (2.5 [N/m])*(y - {name}.x)^2")
        own.append(f"let mean = ({' + '.join(f'{n}.x' for n, _ in parts)})/{len(parts)}")
        own.append("observe gap = mean - y\nevent meet: y - mean")
        self.rest += [self.plain(text) for text in own]
        draw.shuffle(use[1:])
        self.files["whole.lag"] = "\n".join(["model whole", *use, *own]) + "\n"

    def _add(self, name, text, file, given):
        text = (text or PAIR).format(**numbers(random.Random(file)))
        self.files[file] = f"model {file[:-4]}\n" + text.replace("@", "")
        plain = re.sub(r"@((?:[ab]\.)?)((?:p_|lambda_)?)(\w+)", rf"\g<2>{name}_\1\3", text)
        for statement in re.sub(r"_([ab])\.", r"_\1_", plain).split("\n"):
            if used := re.match(r'use "((\w+)\d.lag)" as (\w+)(?: with m = (.*))?', statement):
                own, kind, sub, mass = used.groups()
                self._add(sub, FILES[kind], own, {"m": mass} if mass else {})
                continue
            if driven := re.match(r"set (\w+_[FG]) = (.*)", statement):
                self._drive(*driven.groups())
                continue
            if statement.startswith("gravity"):  # It acts on the bodies of its own file.
                field = f"dot({statement[8:]}, {name}"
                self.last.append(
                    f"potential -{name}_m*{field}_upper.com) - (1 [kg])*{field}_lower.com)"
                )
                continue
            word, _, after = statement.partition(" ")
            left = re.match(rf"{name}_(\w+) = ", after)
            if word in ("param", "size") and left and left[1] in given:
                bounds = " in (0, inf)" if " in " in after else ""
                statement = f"{word} {name}_{left[1]} = {given[left[1]]}{bounds}"
            declares = ("param", "size", "coord", "state", "rotation", "input", "const")
            if word not in ("scene", "set", "until", "end", ""):
                (self.first if word in declares else self.rest).append(statement)

    def _drive(self, name, value):
        flat = self.plain(name)
        for k, line in enumerate(self.first):
            if line.startswith("input ") and re.search(rf"\b{flat}\b", line):
                items = [n for n in re.findall(r"(\w+) \[", line) if n != flat]
                units = dict(re.findall(r"(\w+) (\[[^]]*\])", line))
                self.first[k] = "input " + ", ".join(f"{n} {units[n]}" for n in items)
                if not items:
                    self.first[k] = ""
        at = next(k for k, line in enumerate(self.rest) if re.search(rf"\b{flat}\b", line))
        self.rest.insert(at, f"let {flat} = {self.plain(value)}")

    @staticmethod
    def plain(text):
        return re.sub(r"\b(p\d)\.", r"\1_", text)

    def write(self, folder):
        for name, text in self.files.items():
            (folder / name).write_text(text)
        (folder / "flat.lag").write_text(
            "\n".join(["model flat", *self.first, *self.rest, *self.last]) + "\n"
        )


def flat_name(name):
    """p0.p_x of the parts is p_p0_x in one file."""
    name = re.sub(r"\b(p\d)\.((?:[ab]\.)?)((?:p_|lambda_)?)", r"\3\1_\2", name)
    return re.sub(r"_([ab])\.", r"_\1_", name)


@pytest.mark.parametrize("seed", range(30))
def test_parts_are_the_same_as_one_file(seed, tmp_path, monkeypatch):
    monkeypatch.setattr(lengths, "UNROLL", 100)  # M of families kept as loops is no array
    draw = random.Random(f"parts {seed}")
    System(draw).write(tmp_path)
    whole, flat = pkgen.load(tmp_path / "whole.lag"), pkgen.load(tmp_path / "flat.lag")
    assert sorted(map(flat_name, whole.coordinates)) == sorted(flat.coordinates)
    q_at = [flat.coordinates.index(flat_name(name)) for name in whole.coordinates]
    v_at = [flat.rates.index(flat_name(name)) for name in whole.rates]
    inputs = {name: draw.uniform(-1, 1) for name in whole.inputs} or None
    flat_inputs = inputs and {flat_name(name): value for name, value in inputs.items()}
    assert {*(flat_inputs or ())} == {*flat.inputs}
    np.testing.assert_allclose(
        whole.start, np.concatenate([flat.start[: len(q_at)][q_at], flat.start[len(q_at) :][v_at]])
    )
    rng = np.random.default_rng(seed)
    q = whole.start[: len(q_at)] + 0.1 * rng.standard_normal((20, len(q_at)))
    v, t = rng.standard_normal((20, len(v_at))), rng.uniform(0, 5, 20)
    qf, vf = np.empty_like(q), np.empty_like(v)
    qf[:, q_at], vf[:, v_at] = q, v
    for what in ("acceleration", "energy", "f"):
        mine = getattr(whole, what)(q, v, t, inputs)
        theirs = getattr(flat, what)(qf, vf, t, flat_inputs)
        theirs = theirs if what == "energy" else theirs[:, v_at]
        np.testing.assert_allclose(mine, theirs, rtol=1e-9, atol=1e-9, err_msg=what)
    mass, other = whole.M(q, v, t), flat.M(qf, vf, t)
    at = v_at[: mass.shape[-1]]
    np.testing.assert_allclose(mass, other[:, at][:, :, at], rtol=1e-12, atol=1e-12)
    if seed % 4:
        return
    options = dict(until=2.0, method="gauss", rtol=1e-12, every=0.25, at="meet")
    ours = whole.run(**options, inputs=inputs)
    others = flat.run(**options, inputs=flat_inputs)
    names = [name for name in ours.columns if name != "t"]
    assert any(name.startswith("p0.") for name in names) and "gap" in names
    for name in names:
        np.testing.assert_allclose(
            ours[name], others[flat_name(name)], rtol=1e-7, atol=1e-8, err_msg=name
        )
    assert "meet" in {event.name for event in whole.compilation.model.events}
    assert len(ours["t"]) == len(others["t"])
