"""Dice for random chain models: what is declared, and bodies over i of whatever has members."""

import random
from dataclasses import dataclass

FAR = 2  # how far a periodic family is reached beyond its ends
TIMES = ("sin(t)", "cos(2*t)", "t^2/3", "exp(-t)", "(0.2 + t/4)")
SMOOTH = (
    "sin({})",
    "cos({})",
    "tanh({})",
    "atan({})",
    "exp(-({})^2)",
    "sqrt(1 + ({})^2)",
    "log(2 + ({})^2)",
    "1/(2 + ({})^2)",
    "({})^2",
    "({})^3/3",
    "({})^4/4",
    "sinh({})/3",
    "atan2({}, 2)",
    "1/(4 + sin({}))^1.5",
    "norm([{}, 0.3, 1])",
)
BENDS = (
    "max({}, 0)^2",
    "min({}, 0.1)^2",
    "abs({})^3",
    "max({} - 0.2, 0)^1.5",
    "clamp({}, -0.3, 0.4)^2",
)
JOLTS = (  # of a member itself and of members near it
    "sign({rate})",
    "sign({rate} - {}')",
    "step({own} - {})",
    "step({own} - 0.2)*cos({})",
    "step({own} - {} + 0.1)*({own} - {})",
    "sign({rate} - 0.3)*(1 + {own}^2)",
    "step(t - 0.02*i)*sin({own})",
    "sign({own}*{} - 0.05)",
    "abs({rate})*sign({own})",
    "sign(2*{rate} - 0.1)*step({own})",
)
JUMPS = ("abs({})", "max({}, 0)", "step({})", "sign({})", "step({} - 0.1)*({})^2")


@dataclass(frozen=True)
class Family:
    """Members from lo to N + hi, and what stands beyond their ends."""

    name: str
    lo: int
    hi: int
    down: int = 0
    up: int = 0
    moves: bool = True  # has rates that bodies may have
    lets: bool = False


def upto(hi: int) -> str:
    return "N" if hi == 0 else f"N{hi:+d}"


def shifted(shift: int) -> str:
    return "i" if shift == 0 else f"i{shift:+d}"


class Bodies:
    """What may stand in a model as it grows."""

    def __init__(self, dice: random.Random, size: int | None = None) -> None:
        self.dice, self.lines = dice, []
        self.size = size or dice.choice((2, 2, 3, 3, 4, 5, 6, 9))
        self.bends = self.jumps = False
        self.families: list[Family] = []  # coordinates
        self.others: list[Family] = []  # parameters, states, lets
        self.scalars: list[str] = []
        self.states = False
        self.reach = (-9, 9)
        self.total = ""  # a `let` of all
        self.tied: tuple[Family, int, str] | None = None  # what g is tied to, how far, how

    # Dice.

    def chance(self, p: float) -> bool:
        return self.dice.random() < p

    def of(self, *choices):
        """One of these; what is a function is called if it is the one."""
        chosen = self.dice.choice(choices)
        return chosen() if callable(chosen) else chosen

    def number(self) -> str:
        if self.chance(0.03):
            return self.of("1e-9", "1e-5", "40", "300")
        return f"{self.dice.uniform(0.2, 1.5):.3f}"

    # Bodies over i.

    def begin(self) -> None:
        self.reach = (-9, 9)

    def over(self, least: int = -9, most: int = 9) -> str | None:
        lo, hi = self.reach
        lo, hi = max(lo, least), min(hi, most)
        if lo == -9 or hi == 9:
            lo, hi = max(lo, 1), min(hi, 0)
        if lo - hi > self.size:
            return None
        return f"{lo}..{upto(hi)}"

    def member(self, family: Family, shift: int | None = None) -> str:
        shift = self.of(0, 0, 0, 0, 1, -1, 1, -1, 2, -2) if shift is None else shift
        lo, hi = self.reach
        lo = max(lo, family.lo - family.down - shift)
        hi = min(hi, family.hi + family.up - shift)
        self.reach = lo, hi
        return f"{family.name}[{shifted(shift)}]"

    def ref(self, moving: bool = False) -> str:
        """Of whatever has members; `moving` what has a rate that bodies may have."""
        pool = [*self.families, *(f for f in self.others if f.moves or not moving)]
        return self.member(self.dice.choice(pool))

    def place(self) -> str:
        """Of a coordinate, a `let`, a state, a scalar."""
        pool = [*self.families, *self.families, *(f for f in self.others if f.lets or not f.moves)]
        if self.scalars and self.chance(0.15):
            return self.dice.choice(self.scalars)
        return self.member(self.dice.choice(pool))

    def factor(self) -> str:
        return self.of(
            self.number,
            "k",
            "i/N",
            "1/(i + 4)",
            "(1 + cos(i))",
            lambda: self.of(*TIMES),
            "c0",
            self.given,
        )

    def given(self) -> str:
        given = [f for f in self.others if f.name in ("m", "w")]
        return self.member(self.dice.choice(given)) if given else "k"

    def linear(self) -> str:
        parts = [self.place()]
        for _ in range(self.of(0, 1, 1, 2)):
            parts.append(self.of("", self.number() + "*") + self.place())
        text = parts[0] + "".join(self.of(" + ", " - ") + x for x in parts[1:])
        return text + self.of("", "", "", " + 0.1", " - " + self.of(*TIMES))

    def smooth(self, depth: int = 2) -> str:
        roll = self.dice.random()
        if depth == 0 or roll < 0.2:
            return self.linear()
        if roll < 0.3:
            return f"({self.smooth(depth - 1)})*({self.smooth(depth - 1)})"
        if roll < 0.4:
            return f"{self.factor()}*({self.smooth(depth - 1)})"
        kinds = SMOOTH
        if self.bends and self.chance(0.2):
            kinds = BENDS
        elif self.jumps and self.chance(0.2):
            kinds = JUMPS
        return self.dice.choice(kinds).replace("{}", self.smooth(depth - 1))

    def summed(self, body: str, **bounds: int) -> str | None:
        over = self.over(**bounds)
        return f"sum({body}, i = {over})" if over else None

    def add(self, statement: str, body: str | None) -> None:
        if body:
            self.lines.append(f"{statement} {body}")

    # Declarations.

    def parameters(self) -> None:
        if self.chance(0.6):
            lo, hi = self.of(1, 1, 0, -1), self.of(0, 0, 1)
            self.lines.append(f"param w[i = {lo}..{upto(hi)}] = 1 + k*cos({self.number()}*i)/3")
            self.others.append(Family("w", lo, hi, moves=False))
        if self.chance(0.5):
            low = max(1, self.others[0].lo if self.others else 1)
            body = self.of("1 + 0.3*sin(i)", "1 + k/(i + 1)^2", *["1 + w[i]^2"] * bool(self.others))
            self.lines.append(f"param m[i = {low}..N] = {body} in (0, inf)")
            self.others.append(Family("m", low, 0, moves=False))

    def coordinates(self) -> None:
        names, ends = [], []
        for name in "qxyz"[: self.of(1, 1, 2, 2, 3)]:
            lo, hi = self.of((1, 0), (1, 0), (1, 0), (0, 0), (0, -1), (1, 1), (2, 0))
            names.append(f"{name}[{lo}..{upto(hi)}]")
            down = up = 0
            if self.chance(0.25) and hi - lo == -1:
                ends.append(f"periodic {name}")
                down = up = FAR
            else:
                for below in (True, False):
                    kind = self.of("none", "free", "free", "fixed", "fixed", "fixed2")
                    at = [f"{name}[{lo - 1}]" if below else f"{name}[{upto(hi + 1)}]"]
                    if kind == "fixed2":
                        at.append(f"{name}[{lo - 2}]" if below else f"{name}[{upto(hi + 2)}]")
                    depth = {"none": 0, "fixed2": 2}.get(kind, 1)
                    if kind == "free":
                        ends.append(f"free {at[0]}")
                    elif kind != "none":
                        ends += [f"fixed {x} = {self.end()}" for x in at]
                    down, up = (depth, up) if below else (down, depth)
            self.families.append(Family(name, lo, hi, down, up))
        for name in "XY"[: self.of(0, 0, 1, 1, 2)]:
            names.append(name)
            self.scalars.append(name)
        self.dice.shuffle(names)
        self.lines += [f"coord {', '.join(names)}", *ends]

    def end(self) -> str:
        return self.of("0", "0", "0.3", "k/2", "0.2*sin(t)", "k*t^2/3", "c0*cos(2*t)/4")
