"""Random models with contacts for tests/runs/test_contacts_random.py: a draft is a model in the
language, and the same for tests/contact_reference.py."""

import random
from dataclasses import dataclass, field

from contact_mechanics import Contact, Friction, System

LATE = ("contact", "impact", "friction", "constraint", "event", "mode", "start")


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
    holds: dict[str, str] = field(default_factory=dict)  # the name in the reference, by text
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
