"""Random models with contacts, impacts, friction, values after events and samples: motions against
tests/contact_reference.py, which stops SciPy at each event."""

import math
import random
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from contact_reference import Contact, Event, Friction, Motion, System, softened

import pkgen
from conftest import long_but

LATE = ("contact", "impact", "friction", "constraint", "event", "mode", "start")
UNTIL, EVERY = 3.0, 0.05


@dataclass
class Draft:
    """A model in the language, and the same for the reference."""

    draw: random.Random
    system: System = field(default_factory=lambda: System([]))
    lines: list[str] = field(default_factory=list)
    start: dict[str, float] = field(default_factory=dict)
    kinetic: list[str] = field(default_factory=list)
    potential: list[str] = field(default_factory=list)
    forces: dict[str, list[str]] = field(default_factory=dict)
    holds: dict[str, str] = field(default_factory=dict)  # what the reference has for a text
    plain: bool = False  # no bounces, no static friction

    def number(self, low: float, high: float) -> float:
        return round(self.draw.uniform(low, high), 3)

    def chance(self, p: float) -> bool:
        return self.draw.random() < p

    def coordinate(self, name: str, at: float, rate: float) -> None:
        self.system.coordinates.append(name)
        self.start[name], self.start[f"{name}'"] = at, rate

    def push(self, name: str, force: str) -> None:
        self.forces.setdefault(name, []).append(force)

    def held(self, condition: str) -> str:
        """Returns a name that is 1 for the reference where the condition is positive, else 0."""
        self.system.switches.append(condition)
        return f"held{len(self.system.switches) - 1}"

    def kink(self, x: str) -> tuple[str, str, float]:
        """Returns a function of x with a kink, the reference's, and its value at the start."""
        a, b, c = self.number(-0.5, 0.5), self.number(-0.4, 0.4), self.number(-0.4, 0.4)
        condition = f"{x} - ({a})"
        own = f"(({b}) + ({c} - ({b}))*{self.held(condition)})*({condition})"
        at = self.start[x] - a
        value = at * (c if at > 0 else b)
        way = self.draw.choice(("if", "ends", "step"))
        if way == "if":
            return f"if({condition} > 0, ({c})*({condition}), ({b})*({condition}))", own, value
        if way == "step":
            return f"(({b}) + ({c} - ({b}))*step({condition}))*({condition})", own, value
        end = "max" if c > b else "min"
        return f"{end}(({b})*({condition}), ({c})*({condition}))", own, value

    def contact(self, gap: str, slip: str = "", own: str = "", along: str = "") -> None:
        """Adds a contact; `own` is the gap as the reference has it."""
        e = self.draw.choice((0, 0, 1, self.number(0.1, 0.9), self.number(0.1, 0.9)))
        mu = self.number(0.05, 1.2) if slip and self.chance(0.6) else None
        name = f"c{len(self.system.contacts)}"
        poisson = self.chance(0.3)
        e, poisson = (0, False) if self.plain else (e, poisson)
        self.system.contacts.append(Contact(own or gap, e, mu, slip, poisson))
        keyword = "contact"
        if self.chance(0.2):
            keyword, gap = "impact", f"{gap} falling with"
        elif self.chance(0.3):
            gap = f"{gap} >= 0"
        else:
            b = self.number(-1, 1)
            gap = f"{gap} + {b} >= {b}"
        text = f"{keyword} {name}: {gap}"
        if e or keyword == "impact" or self.chance(0.5):
            text += f" restitution {e}"
        if mu is not None:
            text += f" friction {mu}" + (f" along {along}" if along else "")
        self.lines.append(text + " poisson" * poisson)

    def friction(self, name: str, slip: str) -> None:
        force = own = self.number(0.1, 1.5)
        static = round(force * self.number(1, 1.6), 3) if self.chance(0.4) else None
        static = None if self.plain else static
        tail = f" static {static}" if static else ""
        if not static and self.chance(0.3):  # it is 0 where it would be negative
            force = f"{force} + {self.number(0, 1.5 * force)}*sin({self.number(0.5, 4)}*t)"
            own = f"({force})*{self.held(force)}"
        self.system.frictions.append(Friction(slip, str(own), str(static or "")))
        self.lines.append(f"friction {name} = {force}{tail}")

    def text(self) -> str:
        s = self.system
        lines = [
            "model m",
            "coord " + ", ".join(s.coordinates),
            *(x for x in self.lines if x.split()[0] not in LATE),
            "kinetic " + " + ".join(self.kinetic),
            "potential " + " + ".join(self.potential or ["0"]),
        ]
        lines += [f"force {q} = " + " + ".join(terms) for q, terms in self.forces.items()]
        lines += [x for x in self.lines if x.split()[0] in LATE]
        start = ", ".join(f"{k} = {v!r}" for k, v in self.start.items())
        return "\n".join([*lines, f"start {start}", ""])

    def done(self) -> System:
        s = self.system
        if s.mass:
            for k, q in enumerate("xyz"):
                terms = (f" + {self.holds.get(x, x)}" for x in self.forces.get(q, []))
                s.loads[k] += "".join(terms)
            return s
        s.kinetic, s.potential = " + ".join(self.kinetic), " + ".join(self.potential or ["0"])
        for q, terms in self.forces.items():
            s.forces[q] = " + ".join(self.holds.get(x, x) for x in terms)
        return s


def wells(d: Draft, names: list[str]) -> None:
    """Springs, gravity and drag."""
    for q in names:
        if d.chance(0.5):
            d.potential.append(f"{d.number(0.3, 6)}*({q} - ({d.number(-0.6, 0.6)}))^2/2")
        if d.chance(0.2):
            d.potential.append(f"{d.number(0.1, 2)}*{q}^4")
        if d.chance(0.3):
            d.push(q, f"-{d.number(0.05, 0.5)}*{q}'")
        if d.chance(0.15):
            d.push(q, f"-{d.number(0.05, 0.3)}*{q}'*sqrt(1 + {q}'^2)")
        if d.chance(0.25):
            d.push(q, f"{d.number(0.3, 2)}*sin({d.number(0.5, 5)}*t)")
    if not d.potential:
        d.potential.append(f"{d.number(0.5, 3)}*{names[0]}^2/2")


def moved(d: Draft, size: float = 0.2) -> str:
    """A place that may move."""
    if d.chance(0.3):
        return f" - {d.number(0.02, size)}*sin({d.number(0.5, 4)}*t)"
    return ""


def jumping(d: Draft) -> tuple[str, str]:
    """The speed of a belt that may jump, and the reference's."""
    a, b = d.number(-0.7, 0.7), d.number(-0.7, 0.7)
    if d.chance(0.6):
        return f"({a})", f"({a})"
    condition = f"sin({d.number(1, 4)}*t + {d.number(0, 3)})"
    h = d.held(condition)
    return f"if({condition} > 0, {a}, {b})", f"({a}*{h} + ({b})*(1 - {h}))"


def points(d: Draft) -> None:
    """Point masses in a plane, walls, circles, and contacts between them."""
    count = d.draw.choice((1, 1, 2))
    for k in range(1, count + 1):
        x, y, m = f"x{k}", f"y{k}", d.number(0.3, 3)
        d.coordinate(x, d.number(-0.3, 0.3) + 1.2 * (k - 1), d.number(-2, 2))
        d.coordinate(y, d.number(0.2, 1), d.number(-2, 2))
        d.kinetic.append(f"{m}*({x}'^2 + {y}'^2)/2")
        d.potential.append(f"{m}*{d.number(2, 10)}*{y}")
        wells(d, [x, y])
        d.lines.append(f"let P{k} = [{x}, {y}, 0]")
        kind = d.draw.choice(("floor", "slanted", "bowl", "ball", "parabola", "bent", "bent"))
        if kind == "floor":
            d.contact(f"{y}{moved(d)}", f"{x}'")
            if d.chance(0.3):  # it begins there
                d.start[y], d.start[f"{y}'"] = 0.0, d.draw.choice((0.0, d.start[f"{y}'"]))
        elif kind == "bent":
            text, own, value = d.kink(x)
            if d.chance(0.3):
                d.start[y], d.start[f"{y}'"] = value, d.draw.choice((0.0, d.start[f"{y}'"]))
            d.lines.append(f"let s{k} = {x}'")
            d.contact(f"{y} - {text}", f"{x}'", f"{y} - {own}", f"s{k}")
        elif kind == "slanted":
            s = d.number(-0.4, 0.4)
            d.contact(f"{y} - ({s})*{x} + 0.5", f"({x}' + ({s})*{y}')")
        elif kind == "parabola":
            s = d.number(0.1, 0.5)
            d.contact(f"{y} - {s}*{x}^2 + 0.5", f"({x}' + 2*{s}*{x}*{y}')")
        else:
            a, b, R = d.number(-0.3, 0.3) + 1.2 * (k - 1), d.number(-1, -0.2), d.number(0.3, 0.6)
            inside = kind == "bowl"
            if inside:
                a, b, R = a, 0.3, d.number(1.6, 2.4)
            r = f"sqrt(({x} - ({a}))^2 + ({y} - ({b}))^2)"
            n = f"norm(P{k} - [{a}, {b}, 0])"
            slip = f"(({y} - ({b}))*{x}' - ({x} - ({a}))*{y}')/{r}"
            d.contact(
                *(f"{R} - {n}" if inside else f"{n} - {R}",),
                slip,
                f"{R} - {r}" if inside else f"{r} - {R}",
            )
        if d.chance(0.5):
            d.contact(f"{d.number(1.6, 2.4)} + {x}{moved(d)}", f"{y}'")
        if d.chance(0.2):
            d.friction(x, f"{x}'")
    if count == 2 and d.chance(0.7):
        r, R = "sqrt((x2 - x1)^2 + (y2 - y1)^2)", d.number(0.2, 0.5)
        d.lines.append("let D = [x2 - x1, y2 - y1, 0]")
        slip = f"((y2 - y1)*(x2' - x1') - (x2 - x1)*(y2' - y1'))/{r}"
        d.contact(f"norm(D) - {R}", slip, f"{r} - {R}")
    elif count == 2:
        d.potential.append(f"{d.number(0.5, 4)}*((x2 - x1)^2 + (y2 - y1)^2 - 1)^2/4")


def pendulums(d: Draft) -> None:
    count = d.draw.choice((1, 2))
    x, y = "0", "0"
    for k in range(1, count + 1):
        a, length, m = f"a{k}", d.number(0.5, 1.2), d.number(0.3, 2)
        d.coordinate(a, d.number(-0.5, 0.5), d.number(-2, 2))
        x, y = f"{x} + {length}*sin({a})", f"{y} - {length}*cos({a})"
        vx = " + ".join(f"{q[0]}*cos({q[1]})*{q[1]}'" for q in _arms(x))
        vy = " + ".join(f"{q[0]}*sin({q[1]})*{q[1]}'" for q in _arms(x))
        d.kinetic.append(f"{m}*(({vx})^2 + ({vy})^2)/2")
        d.potential.append(f"{m}*{d.number(3, 10)}*({y})")
        d.lines.append(f"let P{k} = [{x}, {y}, 0]")
        if d.chance(0.3):
            d.push(a, f"-{d.number(0.02, 0.4)}*{a}'")
        if d.chance(0.3):
            d.friction(a, f"{a}'")
    d.contact(f"{d.number(0.7, 1.1)} + ({x}){moved(d, 0.1)}", f"({vy})" if count == 2 else "")
    if count == 2 and d.chance(0.5):
        d.contact(f"{d.number(1.6, 1.9)} - ({x})", f"({vy})")
    if count == 2 and d.chance(0.4):  # a stop of the joint
        d.contact(f"{d.number(0.7, 1.5)} + a2 - a1")
    if count == 1 and d.chance(0.4):
        d.contact(f"{d.number(0.8, 1.3)} - a1")


def _arms(x: str) -> list[tuple[str, str]]:
    parts = x.split(" + ")[1:]
    return [(p.split("*")[0], p.split("(")[1].rstrip(")")) for p in parts]


def body(d: Draft) -> None:
    """A rigid body in a plane with corners."""
    m, inertia = d.number(0.5, 2), d.number(0.05, 0.4)
    d.coordinate("x", d.number(-0.2, 0.2), d.number(-1.5, 1.5))
    d.coordinate("y", d.number(0.9, 1.3), d.number(-1.5, 1))
    d.coordinate("th", d.number(-0.6, 0.6), d.number(-2, 2))
    d.kinetic.append(f"{m}*(x'^2 + y'^2)/2 + {inertia}*th'^2/2")
    d.potential.append(f"{m}*{d.number(3, 10)}*y")
    if d.chance(0.4):
        wells(d, ["x"])
    w, h = d.number(0.2, 0.5), d.number(0.15, 0.4)
    corners = [(-w, -h), (w, -h), (w, h), (-w, h)]
    for k, (a, b) in enumerate(corners[: d.draw.choice((1, 2, 2, 3, 4))]):
        px, py = f"x + ({a})*cos(th) - ({b})*sin(th)", f"y + ({a})*sin(th) + ({b})*cos(th)"
        vx = f"(x' - (({a})*sin(th) + ({b})*cos(th))*th')"
        vy = f"(y' + (({a})*cos(th) - ({b})*sin(th))*th')"
        d.lines.append(f"let R{k} = [{px}, {py}, 0]")
        d.contact(f"R{k}.y", vx, py)
        if d.chance(0.15) and len(d.system.contacts) < 4:
            d.contact(f"R{k}.x + 1.2", vy, f"{px} + 1.2")
    if d.chance(0.2):
        d.friction("x", "x'")


def sliders(d: Draft) -> None:
    """Blocks in a row between walls, on rough floors and belts."""
    count = d.draw.choice((1, 2, 3))
    width = d.number(0.1, 0.3)
    for k in range(1, count + 1):
        x = f"x{k}"
        still = d.chance(0.2)
        rate = 0.0 if still else d.number(-2, 2)
        d.coordinate(x, 0.7 * (k - 1) + d.number(-0.1, 0.1), rate)
        d.kinetic.append(f"{d.number(0.4, 3)}*{x}'^2/2")
        wells(d, [x])
        kind = d.draw.choice(("no", "floor", "belt", "between"))
        if kind == "floor":
            d.friction(x, f"{x}'")
        elif kind == "belt":
            text, own = jumping(d)
            d.lines.append(f"let s{k} = {x}' - {text}")
            d.friction(f"s{k}", f"{x}' - {own}")
        elif kind == "between" and k > 1:
            d.lines.append(f"let s{k} = {x} - x{k - 1}")
            d.friction(f"s{k}", f"{x}' - x{k - 1}'")
        if k > 1:
            if d.chance(0.6):
                d.contact(f"{x} - x{k - 1} - {width}")
            if d.chance(0.5):
                d.potential.append(f"{d.number(1, 9)}*({x} - x{k - 1} - 0.6)^2/2")
    d.contact(f"x1 + {d.number(0.3, 0.8)}{moved(d, 0.1)}")
    if count == 1 or d.chance(0.5):
        d.contact(f"{0.7 * (count - 1) + d.number(0.2, 0.8)} - x{count}")


def rods(d: Draft) -> None:
    """Pendulums in x and y, held by rods."""
    count, x0, y0 = d.draw.choice((1, 2)), 0.0, 0.0
    for k in range(1, count + 1):
        length, angle, rate = d.number(0.5, 1.1), d.number(-0.6, 0.6), d.number(-2, 2)
        x, y, m = f"x{k}", f"y{k}", d.number(0.4, 2)
        dx, dy = length * math.sin(angle), -length * math.cos(angle)
        before = d.start.get(f"x{k - 1}'", 0.0), d.start.get(f"y{k - 1}'", 0.0)
        d.coordinate(x, x0 + dx, before[0] - rate * dy)
        d.coordinate(y, y0 + dy, before[1] + rate * dx)
        x0, y0 = x0 + dx, y0 + dy
        d.kinetic.append(f"{m}*({x}'^2 + {y}'^2)/2")
        d.potential.append(f"{m}*{d.number(3, 10)}*{y}")
        ax, ay = (f"({x} - x{k - 1})", f"({y} - y{k - 1})") if k > 1 else (x, y)
        d.lines.append(f"constraint rod{k}: {ax}^2 + {ay}^2 = {length}^2")
        d.system.constraints.append(f"({ax}^2 + {ay}^2 - {length}^2)")
        if d.chance(0.3):
            d.push(x, f"-{d.number(0.05, 0.4)}*{x}'")
        if d.chance(0.3):
            d.push(x, f"{d.number(0.3, 2)}*sin({d.number(0.5, 4)}*t)")
    d.lines.append(f"let P = [x{count}, y{count}, 0]")
    d.lines.append("let s = x1*y1' - y1*x1'")
    if d.chance(0.5):
        d.friction("s", "x1*y1' - y1*x1'")
    d.contact(f"x{count} + {d.number(0.7, 1)}{moved(d, 0.1)}", f"y{count}'" if count == 2 else "")
    if d.chance(0.5):
        d.contact(f"{d.number(1.0, 1.4)} - x{count}", f"y{count}'" if count == 2 else "")


def spins(d: Draft) -> None:
    """A body in space that a point of it meets the floor."""
    m, A, B, C, g = (
        d.number(a, b) for a, b in ((0.5, 2), (0.1, 0.4), (0.1, 0.4), (0.1, 0.4), (3, 9))
    )
    r = [d.number(-0.4, 0.4) for _ in range(3)]
    s = d.system
    for name, at in zip("xyz", (0.0, 0.0, d.number(0.8, 1.2)), strict=True):
        d.coordinate(name, at, d.number(-1, 1))
    w = [d.number(-3, 3) for _ in range(3)]
    d.lines.append("rotation R")
    d.lines += ["let w = omega(R)", "let s = x' + y'"]
    rows = [(r, "0")]
    if d.chance(0.5):
        rows.append(([d.number(-0.4, 0.4) for _ in range(3)], "0"))
    d.kinetic.append(f"{m}*(x'^2 + y'^2 + z'^2)/2 + ({A}*w.x^2 + {B}*w.y^2 + {C}*w.z^2)/2")
    d.potential.append(f"{m}*{g}*z")
    for a, _ in rows:
        rz = (
            f"(2*(Q1*Q3 - Q0*Q2)*({a[0]}) + 2*(Q2*Q3 + Q0*Q1)*({a[1]})"
            f" + (Q0^2 - Q1^2 - Q2^2 + Q3^2)*({a[2]}))"
        )
        d.contact(f"z + (R*[{a[0]}, {a[1]}, {a[2]}]).z", "x' + y'", f"z + {rz}", "s")
    s.coordinates = ["x", "y", "z", "Q0", "Q1", "Q2", "Q3"]
    s.rates = ["x'", "y'", "z'", "w1", "w2", "w3"]
    s.moves = [
        "x'",
        "y'",
        "z'",
        "(-Q1*w1 - Q2*w2 - Q3*w3)/2",
        "(Q0*w1 + Q2*w3 - Q3*w2)/2",
        "(Q0*w2 + Q3*w1 - Q1*w3)/2",
        "(Q0*w3 + Q1*w2 - Q2*w1)/2",
    ]
    inertia = [m, m, m, A, B, C]
    s.mass = [[str(inertia[i]) if i == j else "0" for j in range(6)] for i in range(6)]
    s.loads = [
        "0",
        "0",
        f"-{m}*{g}",
        f"({B} - {C})*w2*w3",
        f"({C} - {A})*w3*w1",
        f"({A} - {B})*w1*w2",
    ]
    d.lines.append(f"start omega(R) = [{w[0]}, {w[1]}, {w[2]}]")
    d.own = w


def switched(d: Draft, folder: Path) -> None:
    """Adds an `if`, a table, values after events, and samples."""
    s, names = d.system, [x for x in d.start if "'" not in x]
    q, at = d.draw.choice(names), d.draw.choice(names)

    if d.chance(0.25):
        condition = d.draw.choice(
            (
                f"{at} - ({d.number(-0.5, 0.5)})",
                f"{at}' + ({d.number(-0.5, 0.5)})",
                f"sin({d.number(1, 4)}*t + 1)",
            )
        )
        a, b = d.number(-2, 2), d.number(-2, 2)
        text = f"if({condition} > 0, {a}, {b})"
        d.push(q, text)
        h = d.held(condition)
        d.holds[text] = f"({a}*{h} + ({b})*(1 - {h}))"
    if d.chance(0.2):
        xs = np.round(np.cumsum([-0.6, *(d.number(0.2, 0.6) for _ in range(3))]), 3)
        ys = [d.number(-2, 2) for _ in xs]
        (folder / "f.csv").write_text(
            "".join(f"{a!r},{b!r}\n" for a, b in zip(xs.tolist(), ys, strict=False))
        )
        d.lines.insert(0, 'table f = "f.csv" x, y linear linear')
        text = f"f({at})"
        d.push(q, text)
        slopes = (np.diff(ys) / np.diff(xs)).tolist()
        own = f"({ys[0]} + ({slopes[0]!r})*({at} - ({xs[0]})))"
        for k in range(1, len(slopes)):
            more, beyond = slopes[k] - slopes[k - 1], f"{at} - ({xs[k]})"
            own += f" + ({more!r})*({beyond})*{d.held(beyond)}"
        d.holds[text] = own
    cell = d.chance(0.25)
    if cell:
        T = d.draw.choice((0.37, 0.61, 0.83))
        b = d.number(0.2, 0.9)
        value = f"1 - {b}*c - 0.3*{at}"
        s.cells["c"], s.period = (0.5, value), T
        d.lines += [f"sample block every {T}", "  memory c = 0.5", f"  set c = {value}", "end"]
        d.push(q, f"{d.number(-2, 2)}*c")
    if d.chance(0.3):
        kind = d.draw.choice(("time", "time", "place", "rate"))
        place = d.number(-0.4, 0.4)
        condition = {
            "time": f"sin({d.number(1, 5)}*t + {d.number(0, 3)})",
            "place": f"{at} - ({place})",
            "rate": f"{at}' - ({place})",
        }[kind]
        then = {}
        what = d.draw.choice(("turn", "jump", "all", *(["cell"] * cell)))
        if what == "turn":
            then[f"{at}'"] = f"-{at}'"
        elif what == "jump" and kind == "time" and not s.constraints:
            then[at] = f"{at} + ({d.number(-0.2, 0.2)})"
        elif what == "cell":
            then["c"] = f"{d.number(-1, 1)} - c*{d.number(0, 1)}"
        else:
            for name in names:
                then[f"{name}'"] = f"{d.number(-0.9, 0.9)}*{name}' + ({d.number(-0.3, 0.3)})"
        falling = d.chance(0.6)
        s.events.append(Event(condition, falling, then))
        values = ", ".join(f"{k} = {v}" for k, v in then.items())
        d.lines.append(f"event jolt: {condition}{' falling' * falling} then {values}")
    if d.chance(0.3):
        hook = f"{q if q != at and d.chance(0.5) else 0} - {at} - ({d.number(-0.4, 0.4)})"
        if d.chance(0.3) and not s.constraints:  # it begins on
            hook, d.start[f"{at}'"] = f"{d.start[at]} - {at}", 0.0
            s.on, d.start["latch"] = True, 1
        off = f"sin({d.number(1, 5)}*t + {d.number(0, 3)})"
        falls = [" falling" * d.chance(0.6) for _ in range(2)]
        s.latches.append(hook)
        s.events += [Event(hook, falls[0] > "", {}, on=0), Event(off, falls[1] > "", {}, off=0)]
        d.lines += [
            f"constraint hook: {hook} = 0",
            f"event meets: {hook}{falls[0]}",
            f"event tired: {off}{falls[1]}",
            "mode latch: constraint hook on at meets off at tired",
        ]


KINDS = (points, points, pendulums, body, sliders, sliders, rods, spins)


def drafted(seed: int, folder: Path) -> tuple[str, Draft, System]:
    draw = random.Random(seed)
    d = Draft(draw)
    kind = draw.choice(KINDS)
    kind(d)
    switched(d, folder)
    names = d.system.coordinates
    at, rates = ([d.start[n + end] for n in names if n in d.start] for end in ("", "'"))
    d.own = at + rates if kind is not spins else [*at, 1.0, 0.0, 0.0, 0.0, *rates, *d.own]
    d.system.coordinates = [n for n in names if n in d.start]
    text = d.text()
    d.system.coordinates = names
    return text, d, d.done()


def names_of(s: System) -> list[str]:
    if s.mass:
        return ["x", "y", "z", "x'", "y'", "z'"]
    return [*s.coordinates, *(f"{q}'" for q in s.coordinates)]


def compared(seed: int, folder: Path) -> dict:
    """Compares a drawn model; returns what happened."""
    text, d, system = drafted(seed, folder)
    (folder / "m.lag").write_text(text)
    motion = Motion(system)
    times = np.linspace(0, UNTIL, round(UNTIL / EVERY) + 1)
    rows, end, why, log = motion.run(d.own, UNTIL, times)
    lost = list(motion.lost)
    found = {
        "end": end,
        "why": why,
        "log": log,
        "text": text,
        "error": "",
        "worst": 0.0,
        "lost": 0.0,
        "each": 0.0,
        "tolerance": 1.0,
        "hits": [],
        "wanted": [],
    }
    until = end if not why else end - 1e-5
    if until <= EVERY:
        return found
    method = d.draw.choice((None, "gauss", "gauss", "dop853", "dop853", "radau", "rk4"))
    accuracy = {"step": 1e-3} if method == "rk4" else {"rtol": 1e-12}
    m = pkgen.load(str(folder / "m.lag"))
    run = m.run(until=until, every=EVERY, method=method, max_steps=20000, **accuracy)
    names = names_of(system)
    pick = range(len(d.own)) if not system.mass else [0, 1, 2, 7, 8, 9]
    worst, first, tolerance = 0.0, None, 1e-6 if method == "rk4" else 1e-8
    for i, state in rows:
        if times[i] > until or i >= len(run.t):
            continue
        off = max(abs(run[n][i] - state[k]) for n, k in zip(names, pick, strict=True))
        off /= max(1.0, abs(state).max())
        if not off <= worst:
            worst = off
        if not off <= tolerance and first is None:
            first = float(times[i])
    found |= {
        "worst": worst,
        "first": first,
        "method": method,
        "rows": len(rows),
        "tolerance": tolerance,
    }
    if not why:
        mine = [x["lost"] for x in run.report["contacts"] if x["name"].startswith("c")][: len(lost)]
        counts = [sum(x[1:] == ("hits", k) for x in log) for k in range(len(lost))]
        found["wanted"], found["hits"] = (
            counts,
            [len(run.events[f"c{k}"]) for k in range(len(lost))],
        )
        found["lost"] = abs(sum(mine) - sum(lost)) / max(1.0, sum(map(abs, lost)))
        each = max(abs(a - b) for a, b in zip(mine, lost, strict=True))
        found["each"] = each / max(1.0, sum(map(abs, lost)))
    return found


QUICK = range(3)
CHUNKS = [QUICK, *(range(k, k + 25) for k in range(3, 528, 25))]


@pytest.mark.filterwarnings("ignore:.*never used")
@pytest.mark.parametrize("seeds", long_but([QUICK], CHUNKS), ids=lambda x: f"{x[0]}-{x[-1]}")
def test_motions_are_those_of_scipy_stopped_at_each_event(seeds: range, tmp_path: Path) -> None:
    for seed in seeds:
        (folder := tmp_path / str(seed)).mkdir()
        found = compared(seed, folder)
        most = max(found["worst"], found["lost"], found["each"])
        assert most <= found["tolerance"], (seed, found)
        assert found["hits"] == found["wanted"], (seed, found)


# models that meet something, and in which all is determined
SOFT = (2, 4, 5, 6, 8, 9, 10, 14, 16, 24, 25, 28, 30, 32, 34, 35, 36, 45, 47, 48)


@pytest.mark.filterwarnings("ignore:.*never used")
@pytest.mark.parametrize("seed", long_but([32], SOFT))
def test_motions_are_limits_of_stiff_smooth_ones(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    d = Draft(draw, plain=True)
    draw.choice((points, pendulums, body, sliders))(d)
    names = d.system.coordinates
    start = [d.start[n + end] for end in ("", "'") for n in names]
    (tmp_path / "m.lag").write_text(d.text())
    run = pkgen.load(str(tmp_path / "m.lag")).run(until=1.2, every=0.1, rtol=1e-10)
    mine = np.array([run[n] for n in names]).T
    motion, errors = Motion(d.done()), []
    for eps in (8e-3, 2e-3, 5e-4):
        states = softened(motion, eps, start, run.t)
        errors.append(abs(states[:, : len(names)] - mine).max())
    assert errors[0] > 2.4 * errors[1] > 2.4**2 * errors[2], errors
    assert errors[2] < 0.03, errors


def ran(folder: Path, text: str, until: float, method: str, **options):
    (folder / "m.lag").write_text(f"model m\n{text}\n")
    return pkgen.load(str(folder / "m.lag")).run(
        until=until, method=method, rtol=1e-12, max_steps=1000, **options
    )


METHODS = pytest.mark.parametrize("method", ["gauss", "dop853"])


@METHODS
def test_an_event_that_turns_the_motion_back_is_met_once(method: str, tmp_path: Path) -> None:
    text = "coord x\nkinetic x'^2/2\nevent a: x - 1 then x' = -0.8*x'\n"
    r = ran(tmp_path, text + "event b: x + 1 then x' = -0.8*x'\nstart x' = 1", 10, method, every=1)
    assert r.events["a"] == pytest.approx([1, 6.625]) and r.events["b"] == pytest.approx([3.5])
    assert r["x"][-1] == pytest.approx(1 - 0.512 * 3.375, abs=1e-12)


@METHODS
def test_a_gap_opens_from_rest_where_all_is_zero(method: str, tmp_path: Path) -> None:
    text = "coord y\nkinetic y'^2/2\npotential 9.81*y\ncontact c: 0 >= y"
    assert ran(tmp_path, text, 2, method, every=2)["y"][-1] == pytest.approx(-19.62, rel=1e-10)


@METHODS
@pytest.mark.parametrize("x", [-0.019, 0.45, 0.5])
def test_what_sticks_from_the_start_stays(x: float, method: str, tmp_path: Path) -> None:
    text = f"""coord x
kinetic 0.414*x'^2/2
potential 0.49*(x + 0.429)^2/2
force x = 1.204*sin(0.533*t)
contact c: x + 3 >= 0
friction x = 1.18 static 1.626
start x = {x}"""
    assert ran(tmp_path, text, 3, method, every=3)["x"][-1] == pytest.approx(x, abs=1e-12)


def test_a_body_that_an_event_lifts_is_not_put_back(tmp_path: Path) -> None:
    text = "coord y\nkinetic y'^2/2\npotential y\ncontact c: y >= 0\n"
    r = ran(tmp_path, text + "event e: 1 - t falling then y = y + 2", 2, "gauss", every=1)
    assert r["y"][-1] == pytest.approx(1.5, abs=1e-12)


def test_a_gap_may_be_the_least_of_several(tmp_path: Path) -> None:
    text = """coord x, y
kinetic (x'^2 + y'^2)/2
potential 9.81*y
contact c: min(y + x, y - x) >= 0 restitution 0.9
start y = 1, x = 0.1, x' = 0.2"""
    r = ran(tmp_path, text, 3, "gauss", every=0.01)
    assert (r["y"] - abs(r["x"])).min() > -1e-12 and len(r.events["c"]) == 8


ON_X = "coord x\nkinetic x'^2/2\n"
ON_FLOOR = "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential 10*y\n"
COUNTS = f"{ON_X}sample block every 1\n  memory c = 0\n  set c = c + 1\nend\n"
LATCHED = """constraint h: x + 0.3 = 0
event meets: x + 0.3 falling
event tired: 0.5 - t falling
mode latch: constraint h on at meets off at tired
start x' = -1, x = -0.2"""


@pytest.mark.parametrize(
    ("text", "until", "x"),
    [
        (f"{ON_FLOOR}contact f: y - max(0, x - 1) >= 0\nstart x' = 5", 1, 1.4),
        (f"{ON_FLOOR}contact f: y - min(0, 1 - x) >= 0\nstart x' = 1", 2, 4),
        (f"{ON_FLOOR}contact f: y - min(0, -x) >= 0\nstart x' = -1", 1, -1),
        (f"{ON_FLOOR}contact f: y - max(0, x) >= 0\nstart x' = 1", 0.5, -0.15),
        (f"{ON_X}potential 10*x\ncontact f: x - max(0, t - 1) >= 0", 2, 1),
        (f"{ON_X}let s = x' - if(t > 1, 1, 0)\nfriction s = 1", 2, 0.5),
        (f"{ON_X}let s = x' - if(t > 1, 2, -1)\nfriction s = 1\nstart x' = 2", 2, 3),
        (f"{ON_X}let s = x' - t + 1\nfriction x = 0.5\nfriction s = 2\nstart x' = -1", 2, 0),
        (f"{ON_X}friction x = cos(t)\nstart x' = 3", 4, 7 + math.pi / 2),
        (f"{ON_FLOOR}contact f: y >= 0 friction cos(t)/10\nstart x' = 3", 4, 7 + math.pi / 2),
        (f"{COUNTS}contact f: x >= 0\npotential 10*x\nforce x = 8*c", 2, 3),
        (f"{COUNTS}event e: c - 1.5 rising then x' = -2\nforce x = 0*c\nstart x' = 1", 3, -3),
        (f"{ON_X}potential 2*(x - 0.3)^2\n{LATCHED}", 1.5, 0.3 - 0.6 * math.cos(2)),
    ],
    ids=str.split(
        "bends_up bends_down begins_on_a_roof begins_in_a_valley wall_starts belt_starts belt_turns"
        " two_frictions_part bound_below_0 mu_below_0 sample_opens"
        " sample_gives_values latch_at_rest"
    ),
)
def test_what_changes_at_once(text: str, until: float, x: float, tmp_path: Path) -> None:
    """At kinks and jumps of gaps, slips and bounds, at samples, and where a latch lets go."""
    found = ran(tmp_path, text, until, "radau", every=until)["x"][-1]
    assert found == pytest.approx(x, abs=1e-9)


def test_friction_is_of_the_force_whatever_the_scale_of_the_gap(tmp_path: Path) -> None:
    a = math.atan(0.5)
    text = "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential 10*y\n"
    text += "contact c: 7*(y + x/2) >= 0 friction 0.2"
    r = ran(tmp_path, text, 1, "gauss", every=1)
    along = 10 * (math.sin(a) - 0.2 * math.cos(a)) / 2
    assert math.hypot(r["x"][-1], r["y"][-1]) == pytest.approx(along, rel=1e-10)


@pytest.mark.parametrize("contact", ["", "contact c: x + 9 >= 0\n"])
def test_a_value_that_breaks_a_constraint_ends_the_run(contact: str, tmp_path: Path) -> None:
    text = "coord x, y\nkinetic (x'^2 + y'^2)/2\nconstraint h: y = x\n"
    with pytest.raises(Exception, match="breaks a constraint: h by"):
        ran(tmp_path, f"{text}{contact}event e: t - 1 then y = y + 1", 2, "gauss", every=1)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("restitution e", "the restitution of c is 2: it is from 0 to 1"),
        ("friction -e along x'", "is -2: it is at least 0"),
    ],
)
def test_numbers_of_parameters_are_judged_by_the_run(line: str, words: str, tmp_path) -> None:
    text = "param e = 2\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential y\n"
    with pytest.raises(Exception, match=words):
        ran(tmp_path, f"{text}contact c: y >= 0 {line}\nstart y = 1", 2, "gauss", every=1)
