"""Kinds of random models with contacts, each written into a draft: points, pendulums, bodies,
sliders, rods, rotations; and switches, tables, samples and latches for all of them."""

import math
import random
from pathlib import Path

import numpy as np
from contact_drafts import Draft, jumping, moved, wells
from contact_mechanics import Event, System


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
