"""Random models with a function that bends or jumps in one place, and the same models smoothed.

The smooth twin has a parameter `w`, the width of each bend. As w goes to 0 its motion goes to that
of the model as written, in whatever place the function stands; so one is a reference of the other
that knows nothing of switches.
"""

import math
import random
import re
from dataclasses import dataclass, replace

SHARP = {
    "step": "step({0})",
    "abs": "abs({0})",
    "max": "max({0}, 0.1)",
    "min": "min({0}, 0.2)",
    "hertz": "3*max({0}, 0)^1.5",
    "root": "sqrt(max({0}, 0.1))",
}
KINDS, ROOTS = ("step", "abs", "max", "min"), ("hertz", "root")
ZERO = {"max": 0.1, "min": 0.2, "root": 0.1}  # where each bends; the others at 0
# tanh is 1 to the last bit beyond 19 w, so both models start alike.
SMOOTH = {
    "step": "(1 + tanh(({0})/w))/2",
    "abs": "({0})*tanh(({0})/w)",
    "max": "0.1 + (({0}) - 0.1)*(1 + tanh((({0}) - 0.1)/w))/2",
    "min": "0.2 + (({0}) - 0.2)*(1 - tanh((({0}) - 0.2)/w))/2",
    "hertz": "3*((({0}) + sqrt(({0})^2 + w^2))/2)^1.5",
    "root": "sqrt(0.1 + (({0}) - 0.1)*(1 + tanh((({0}) - 0.1)/w))/2)",
}
# What stands within: of time, of place, of both, of a rate.
OF_TIME = ("t - {c}", "sin(2*t) - 0.31", "{c} - t")
OF_PLACE = ("x - {d}", "x + 0.5*y - {d}", "0.3*y^2 - x - {d}", "sin(x) - {d}")
OF_BOTH = ("x - 0.2*t - {d}", "x*cos(t) - {d}")
OF_RATE = ("x' - {d}", "x' + y'", "y' - 0.1*x")
OF_ATTITUDE = ("(R*[0, 0, 1]).x - {d}", "(R*[0, 1, 0]).z + 0.3*x - {d}")
BODY = (
    "rotation R",
    "let turn = omega(R)",
    "kinetic 0.5*turn.x^2 + 0.4*turn.y^2 + 0.3*turn.z^2 + 0.1*turn.x*x'",
    "potential 0.3*(R*[0.3, 0, 1]).z",
    "start omega(R) = [0.7, 0.9, 0.5]",
)
CHAIN = (
    "size N = 3",
    "coord q[1..N]",
    "fixed q[0] = 0.5*K",
    "free q[N+1]",
    "kinetic sum((1.2 + 0.3*cos(q[i]))*q[i]'^2/2 + 0.2*q[i]'*q[i-1]', i = 1..N)",
    "potential sum((q[i] - q[i-1])^2/2, i = 1..N) + 0.1*x*q[2]",
    "start q[1] = 0.1, q[1]' = 0.2",
)


@dataclass(frozen=True)
class Place:
    """Where the function K stands, as statements before and in the scene; of what it may be."""

    name: str
    of: tuple[str, ...]
    model: tuple[str, ...] = ()
    scene: tuple[str, ...] = ()
    free: str = "xy"


PLACES = (
    Place("potential", OF_TIME + OF_PLACE + OF_BOTH, ("potential 0.6*K",)),
    Place("mass", OF_TIME + OF_PLACE + OF_BOTH, ("kinetic 0.4*(0.5 + K^2)*(x' + 0.3*y')^2/2",)),
    Place("gauge", OF_TIME + OF_PLACE + OF_BOTH, ("lagrangian 0.5*K*y'",)),
    Place("force", OF_TIME + OF_PLACE + OF_BOTH + OF_RATE, ("force y = 0.7*K",)),
    Place("dissipation", OF_TIME + OF_PLACE + OF_BOTH, ("dissipation 0.3*(0.5 + K^2)*y'^2",)),
    Place(
        "constraint",
        OF_TIME + OF_PLACE + OF_BOTH,
        ("constraint c: z = 0.5*K + 0.2*sin(y)",),
        (),
        "xyz",
    ),
    Place(
        "rolling",
        OF_TIME + OF_PLACE + OF_BOTH,
        ("rolling r: z' = 0.5*K + 0.3*cos(x)*y'",),
        (),
        "xyz",
    ),
    Place("rolling_slope", OF_TIME + OF_PLACE, ("rolling r: z' = 0.5*K*y'",), (), "xyz"),
    Place("hold", OF_TIME, (), ("hold z = 0.4*K",), "xyz"),
    Place("input", OF_TIME, ("input u", "force x = u"), ("set u = 0.6*K",)),
    Place("input_energy", OF_TIME, ("input u", "potential u*y"), ("set u = 0.6*K",)),
    Place("input_rate", OF_TIME, ("input u", "kinetic 0.5*u'*(x' + 0.3*y')"), ("set u = 0.6*K",)),
    Place(
        "rate",
        OF_TIME + OF_PLACE + OF_BOTH + OF_RATE,
        ("state s", "rate s = K - 0.5*s", "force x = -0.4*s"),
    ),
    Place("fixed", OF_TIME, CHAIN),
    Place("torque", OF_TIME + OF_PLACE + OF_ATTITUDE, (*BODY, "force R = [0, 0.3*K, 0]")),
    Place("turned", OF_ATTITUDE + OF_TIME, (*BODY, "potential 0.2*K")),
    Place("observe", OF_TIME + OF_PLACE, ("observe o = K",)),
)


CLAIMS = (
    "x'", "y'", "x' + y'", "z'", "z' - 0.5*x'", "p_x", "p_y", "p_z", "p_x + p_z", "energy",
    "x - t*x'", "x*y' - y*x'", "x'^2 + y'^2", "T", "x'^2 + y'^2 + z'^2",
)  # fmt: skip


@dataclass(frozen=True)
class Bend:
    """The function of a place: its kind, and what it is of."""

    place: Place
    kind: str
    form: str  # of the place's forms
    inner: str

    def text(self, sharp: bool) -> str:
        return f"({(SHARP if sharp else SMOOTH)[self.kind].format(self.inner)})"


def together(a: Place, b: Place) -> bool:
    """Whether a model can have both: each name is declared once, and one row holds z."""
    bound = [p.name.startswith(("constraint", "rolling", "hold")) for p in (a, b)]
    return not all(bound) and not _declared(a) & _declared(b)


def _declared(place: Place) -> set[str]:
    lines = (*place.model, *place.scene)
    return {x.split("=")[0] for x in lines if "=" in x or x.startswith(("input", "rotation"))}


def model(
    seed: int,
    places: Place | tuple[Place, ...],
    sharp: bool,
    claim: str = "",
    kinds: tuple[str, ...] = KINDS,
) -> str:
    """A model of two or three coordinates with a function in each place, and a scene.

    With a `claim` it is a free motion but for that function, so that much is constant; what is
    claimed is so for the sharp model and observed of its smooth twin.
    """
    places = places if isinstance(places, tuple) else (places,)
    r = random.Random(f"{' '.join(place.name for place in places)} {seed}")
    names = max((place.free for place in places), key=len)
    while True:
        bends = [_bend(r, place, kinds) for place in places]
        if len(bends) == 2 and bends[0].form in places[1].of and r.random() < 0.3:
            bends[1] = replace(bends[0], place=places[1], kind=bends[1].kind)  # both at once
        start = [round(r.uniform(-0.8, 0.8), 3) for _ in range(4)]
        if all(abs(_number(b.inner, 0.0, *start) - ZERO.get(b.kind, 0.0)) > 0.05 for b in bends):
            break
    lines = ["model bent", *([] if sharp else ["param w = 0.001 in (0, inf)"])]
    lines += ["param g = 1 in (0, inf)", f"coord {', '.join(names)}"]
    for name in names:
        if claim:
            lines.append(f"kinetic {name}'^2/2")
            continue
        factor = r.choice(("1", "(1.5 + cos({0}))", "(1 + {0}^2)")).format(r.choice(names))
        lines.append(f"kinetic {factor}*{name}'^2/2")
    if not claim:
        lines.append("kinetic {}*x'*y'".format(r.choice(("0", "0.3", "0.3*cos(x - y)"))))
        lines += ["kinetic 0.2*z'*(x' - y')"] * (len(names) == 3)
        wells = ("{0}^2", "1 - cos({0})", "{0}^4/4 + {0}^2/3")
        lines += [f"potential g*({r.choice(wells).format(name)})" for name in names]
    x, y, x_dot, y_dot = start
    given = [f"start x = {x}, y = {y}, x' = {x_dot}, y' = {y_dot}"]
    scene = ["scene s"]
    for b in bends:
        own = [re.sub(r" \+ 0\.[23]\*(sin|cos).*", "", t) if claim else t for t in b.place.model]
        lines += [line.replace("K", b.text(sharp)) for line in own]
        scene += [line.replace("K", b.text(sharp)) for line in b.place.scene]
        given += [_of_row(line.replace("K", b.text(True)), *start) for line in own if " z" in line]
    statements = [line for place in places for line in place.model]
    moving = names[:2] if any("hold z" in line for line in scene) else names
    columns = [*moving, *(f"{name}'" for name in moving)]
    columns += [n for n in ("s", "o") if any(f" {n} =" in line for line in statements)]
    columns += ["q[1]", "q[3]", "q[3]'"] * ("size N = 3" in statements)
    columns += ["R", "omega(R)"] * ("rotation R" in statements)
    if claim:
        given.append(("conserve" if sharp else "observe") + f" claimed = {claim}")
        columns = ["claimed"]
    else:
        given.append(f"event e: {bends[0].inner} either")
    scene += ["until 2", f"record {', '.join(columns)} every 1", "end"]
    return "\n".join([*lines, *given, *scene]) + "\n"


def _bend(r: random.Random, place: Place, kinds: tuple[str, ...]) -> Bend:
    if place.name in ("constraint", "rolling", "rolling_slope") and kinds == ROOTS:
        kinds = ("root",)  # the twin of the other does not start on the same surface
    kind, form = r.choice(kinds), r.choice(place.of)
    c, d = f"{r.uniform(0.3, 1.5):.3f}", f"{r.uniform(-0.3, 0.4):.3f}"
    return Bend(place, kind, form, form.format(c=c, d=d))


def _of_row(line: str, x: float, y: float, x_dot: float, y_dot: float) -> str:
    """Where z starts, and how fast, by the row that binds it."""
    text = line.split(" = ")[1]

    def along(t: float) -> float:
        return _number(text, t, x + t * x_dot, y + t * y_dot, x_dot, y_dot)

    if line.startswith("rolling"):
        return f"start z = 0.1, z' = {along(0)!r}"
    rate = (8 * (along(1e-3) - along(-1e-3)) - along(2e-3) + along(-2e-3)) / 12e-3
    return f"start z = {along(0)!r}, z' = {rate!r}"


def _number(text: str, t: float, x: float, y: float, x_dot: float, y_dot: float) -> float:
    """The value of one of the texts above."""
    text = re.sub(r"\(R\*\S+ \S+ \S+\)\.[xz]", "0", text)
    python = text.replace("x'", "x_dot").replace("y'", "y_dot").replace("^", "**")
    names = {
        "sin": math.sin,
        "cos": math.cos,
        "abs": abs,
        "max": max,
        "min": min,
        "sqrt": math.sqrt,
    }
    names |= {"step": lambda a: float(a >= 0)}
    names |= {"t": t, "x": x, "y": y, "x_dot": x_dot, "y_dot": y_dot}
    return float(eval(python, {"__builtins__": {}}, names))
