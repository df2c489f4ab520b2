"""Random chain models: several families whose bodies reach members up to two away, ends of every
kind, `let`s of each member and of all, chains of `let`s, states, constraints, forces, events.

`drawn(dice)` is a text; what it starts with lies on its constraints.
"""

import random

from chain_bodies import JOLTS, SMOOTH, TIMES, Family, shifted, upto
from chain_totals import Totalled


class Draw(Totalled):
    """One model, statement by statement; forces and rates jump where it `jolts`."""

    def __init__(self, dice: random.Random, size: int | None = None, jolts: bool = False) -> None:
        super().__init__(dice, size)
        self.jolts = jolts

    def made(self) -> None:
        self.bends, self.jumps = self.chance(0.12), self.chance(0.05)
        self.lines += [f"model chain\nsize N = {self.size}", f"param k = {self.number()}"]
        self.lines.append("const c0 = 0.7")
        if self.chance(0.2):
            self.lines.append("input push")
            self.scalars.append("push")
        self.parameters()
        self.coordinates()
        if self.chance(0.35):
            self.lets()
        if self.chance(0.25):
            self.carried()
        if self.chance(0.25):
            self.state_names()
        self.inertia()
        self.potentials()
        self.total_energies()
        self.forces()
        self.total_forces()
        if self.states:
            self.rates()
            self.second_states()
        if self.chance(0.25):
            self.constraints()
        self.starts()
        self.outputs()
        self.total_outputs()

    def lets(self) -> None:
        for name in ("e", "d")[: self.of(1, 2)]:
            self.begin()
            body = self.of(
                self.linear, lambda: self.smooth(1), lambda: f"{self.factor()}*({self.linear()})"
            )
            over = self.over()
            if over is None or self.reach[0] == -9:
                continue
            lo, hi = (int(x.replace("N", "") or 0) for x in over.split(".."))
            if self.chance(0.3) and lo - hi < self.size - 1:
                first = self.of("0", "k", "0.2*t", *self.scalars)
                self.lines.append(f"let {name}[{lo}] = {first}")
                self.lines.append(f"let {name}[i = {lo + 1}..{upto(hi)}] = {body}")
            else:
                self.lines.append(f"let {name}[i = {over}] = {body}")
            moves = "push" not in body
            self.others.append(Family(name, lo, hi, moves=moves, lets=True))
        if self.chance(0.4):
            self.begin()
            total = self.summed(self.smooth(1))
            if total:
                self.lines.append(f"let S = {total}")
                self.total = "S"

    def carried(self) -> None:
        f = self.dice.choice(self.families)
        lo = f.lo
        for name in ("a", "b")[: self.of(1, 1, 2)]:
            first = self.of("0", "0.2*t", "k", *[x for x in self.scalars if x != "push"])
            self.lines.append(f"let {name}[{lo - 1}] = {first}")
            last, own = f"{name}[i-1]", f"{f.name}[i]"
            if name == "b" and self.chance(0.6):
                own = self.of("a[i]", "a[i-1]", f"(a[i] + {f.name}[i])")
            body = self.of(
                f"{last} + {own}",
                f"{last} + {self.number()}*sin({own})",
                f"0.9*{last} + cos({own})",
                f"{last}*(1 + 0.1*sin({own})) + {own}",
                f"sin({last}) + {own}/(2 + {last}^2)",
            )
            if (
                self.others
                and self.others[0].name == "w"
                and self.others[0].lo <= lo
                and self.chance(0.3)
            ):
                body = body.replace("sin(", "w[i]*sin(") if f.hi <= self.others[0].hi else body
            self.lines.append(f"let {name}[i = {lo}..{upto(f.hi)}] = {body}")
            self.others.append(Family(name, lo - 1, f.hi, lets=True))

    def state_names(self) -> None:
        self.states = True
        self.lines.append("state u[1..N], s")
        down, up = self.of((0, 0), (1, 1), (1, 0))
        if up:
            self.lines.append(f"free u[{upto(1)}]")
        if down:
            self.lines.append(f"fixed u[0] = {self.end()}")
        self.others.append(Family("u", 1, 0, down, up, moves=False))
        self.scalars.append("s")

    def inertia(self) -> None:
        for f in self.families:
            self.begin()
            own = self.member(f, 0)
            weight = self.of("1", "2", "(1 + i/N)", self.factor_positive, self.factor_positive)
            if self.chance(0.3):
                self.lines.append(f"kinetic sum({own}'^2/2, i = {f.lo}..{upto(f.hi)})")
                self.add("kinetic", self.summed(f"{weight}*{own}'^2/2"))
            else:
                over = f"{f.lo}..{upto(f.hi)}"
                fits = self.over() == over
                self.lines.append(
                    f"kinetic sum({weight if fits else '1.5'}*{own}'^2/2, i = {over})"
                )
        for name in self.scalars:
            if name in ("X", "Y"):
                self.lines.append(f"kinetic {self.of('1', '(2 + cos(' + name + '))')}*{name}'^2")
        for _ in range(self.of(0, 0, 1, 1, 2)):
            self.begin()
            rates = [self.ref(True) + "'" for _ in range(self.of(2, 2, 3))]
            if self.chance(0.3) and set(self.scalars) & {"X", "Y"}:
                rates.append(self.of(*(x for x in self.scalars if x in ("X", "Y"))) + "'")
            joined = rates[0] + "".join(self.of(" - ", " + ") + x for x in rates[1:])
            self.add("kinetic", self.summed(f"{self.factor_positive()}*({joined})^2/9"))
        if self.chance(0.2):
            self.begin()
            self.add("kinetic", self.summed(f"{self.ref(True)}'*{self.smooth(1)}/7"))
        if self.chance(0.1):
            f = self.dice.choice(self.families)
            at = self.of(f"{f.name}[{f.lo}]", f"{f.name}[{upto(f.hi)}]")
            self.lines.append(f"kinetic {self.of('2', '(2 + sin(' + at + '))')}*{at}'^2")

    def factor_positive(self) -> str:
        form = self.of("1", "k", "(2 + cos({}))", "(1 + {}^2/4)", self.given)
        return form.replace("{}", self.place()) if "{" in form else form

    def potentials(self) -> None:
        for _ in range(self.of(1, 1, 2, 3)):
            self.begin()
            word = self.of("potential", "potential", "lagrangian -")
            body = self.dice.choice(SMOOTH).format(self.smooth(1))
            if self.chance(0.5):
                body = f"{self.factor()}*{body}"
            self.add(word, self.summed(body))
        for f in self.families:
            self.begin()
            self.add("potential", self.summed(f"({self.member(f, 0)} - {self.member(f, -1)})^2/2"))
        for name in self.scalars:
            if name in ("X", "Y"):
                self.lines.append(f"potential {name}^2/2")
        if self.chance(0.15):
            f = self.dice.choice(self.families)
            at = self.of(f"{f.name}[{f.lo}]", f"{f.name}[{upto(f.hi)}]", f"{f.name}[{f.lo + 1}]")
            self.lines.append(f"potential {self.dice.choice(SMOOTH).format(at)}")
        if self.chance(0.15):
            f = self.dice.choice(self.families)
            d = f"{f.name}[i] - {f.name}[j]"
            pair = self.dice.choice(SMOOTH).format(d) + self.of("", "/N", f"*{f.name}[j]")
            lo, hi = f.lo, f.hi
            self.lines.append(
                f"potential sum({pair}, i = {lo}..{upto(hi - 1)}, j = i+1..{upto(hi)})"
            )
        if self.total and self.chance(0.5):
            self.lines.append(f"potential {self.of('k*S/9', 'S^2/20', 'sin(t)*S/5')}")

    def forces(self) -> None:
        if self.chance(0.35):
            self.begin()
            rates = f"{self.ref(True)}' - {self.ref(True)}'"
            self.add("dissipation", self.summed(f"{self.factor_positive()}*({rates})^2/20"))
        for _ in range(self.of(0, 0, 1, 2)):
            f = self.dice.choice(self.families)
            self.begin()
            self.member(f, 0)
            body = self.of(
                f"-0.1*{f.name}[i]'",
                lambda: f"{self.smooth(1)}/4",
                lambda: f"0.1*{self.ref(True)}'*{self.place()}",
                f"-0.2*{f.name}[i]'*abs({f.name}[i]')" if self.bends else self.of(*TIMES),
                f"sum(sin({f.name}[j] - {f.name}[i]), j = {f.lo}..{upto(f.hi)})/(4*N)",
            )
            over = self.over(f.lo, f.hi)
            if over:
                self.lines.append(f"force {f.name}[i = {over}] = {body}")
        if set(self.scalars) & {"X"} and self.chance(0.3):
            self.lines.append(f"force X = -0.1*X' + {self.of(*TIMES)}")
        for _ in range(self.of(1, 1, 2, 3) if self.jolts else 0):
            self.jolt()

    def jolt(self) -> None:
        """A force that jumps: friction, contacts, a force that is switched on or goes along."""
        f = self.dice.choice(self.families)
        self.begin()
        own = self.member(f, 0)
        sized = self.of("0.3", "k/5", self.factor)
        if set(self.scalars) & {"X"} and self.chance(0.15):
            felt = self.of("sign(X')", f"step({f.name}[{upto(f.hi)}] - X)", "step(t - 0.2)")
            self.lines.append(
                f"force X = {sized if '[' not in sized and 'i' not in sized else 'k'}*{felt}"
            )
            return
        what = self.dice.choice(JOLTS)
        what = what.replace("{own}", own).replace("{rate}", own + "'")
        while "{}" in what:
            what = what.replace("{}", self.ref(True), 1)
        over = self.over(f.lo, f.hi)
        if over:
            self.lines.append(f"force {f.name}[i = {over}] = {sized}*{what}")

    def rates(self) -> None:
        near = self.of("(u[i]^2)", "sin(u[i])", "cos(t)", "s")
        self.lines.append("rate u[i = 1..N] = -u[i]^3 + " + near)
        if self.chance(0.5) and self.others:
            self.begin()
            body = self.smooth(1)
            over = self.over(1, 0)
            if over == "1..N":
                self.lines[-1] += f" + ({body})/3"
        felt = [
            "sin(t)",
            "u[1]",
            "sum(u[i]^2, i = 1..N)/N",
            *(["X'"] if "X" in self.scalars else []),
        ]
        if self.total:
            felt.append("S/N")
        if self.jolts:
            self.lines[-1] += self.of(" - step(u[i] - 0.1)/3", " + sign(u[i])/9", "")
        self.lines.append(f"rate s = -s + {self.of(*felt)}")

    def constraints(self) -> None:
        """A family more, each member tied to one that is near."""
        f = self.dice.choice(self.families)
        shift = self.of(0, -1, 1)
        shape = self.of("0.3*{}", "sin({})/2", "{}^2/4 + 0.1*{}", "0.2*{} + sin(t)^2/9")
        shape += " + 0.1*X" * ("X" in self.scalars and self.chance(0.4))
        over = f"{f.lo - shift}..{upto(f.hi - shift)}"
        self.tied = f, shift, shape
        value = shape.replace("{}", f"{f.name}[{shifted(shift)}]")
        self.lines.append(f"coord g[{over}]\nkinetic sum(g[i]'^2/2, i = {over})")
        self.lines.append(f"potential sum(g[i]^2*{f.name}[{shifted(shift)}]/5 + g[i], i = {over})")
        self.lines.append(f"constraint tie[i = {over}]: g[i] = {value}")

    def starts(self) -> None:
        for f in self.families:
            over = f"{f.lo}..{upto(f.hi)}"
            value = f"{self.number()}*sin({self.number()}*i)"
            if not self.tied:
                value = self.less_mean(value, over, f"(N + {f.hi - f.lo + 1})")
            self.lines.append(f"start {f.name}[i = {over}] = {value}")
            if self.tied and self.tied[0] == f:
                _, shift, shape = self.tied
                over = f"{f.lo - shift}..{upto(f.hi - shift)}"
                there = "(" + value.replace("*i)", f"*({shifted(shift)}))") + ")"
                tied = shape.replace("{}", there).replace("sin(t)", "0").replace("X", "0.1")
                self.lines.append(f"start g[i = {over}] = {tied}")
            elif self.chance(0.5):
                self.lines.append(f"start {f.name}[i = {over}]' = {self.number()}*cos(i)/2")
        if "X" in self.scalars:
            self.lines.append("start X = 0.1" + ", X' = 0.3" * (self.tied is None))
        if self.states:
            self.lines.append("start u[i = 1..N] = cos(i), s = 0.4")

    def outputs(self) -> None:
        for k in range(self.of(0, 1, 2)):
            self.begin()
            body = self.of(
                lambda: self.smooth(1), lambda: f"{self.ref(True)}'*{self.place()}", self.linear
            )
            kind = self.of("sum", "each", "sum")
            if kind == "sum":
                total = self.summed(body)
                if total:
                    form = self.of("{}", "sqrt(1 + ({})^2)", "{}*energy", "{}/(1 + energy^2)")
                    self.add(f"observe out{k} =", form.format(total))
            elif over := self.over():
                self.lines.append(f"observe out{k}[i = {over}] = {body}")
        f = self.dice.choice(self.families)
        second = f.lo + (self.size + f.hi > f.lo)
        if "X" in self.scalars and self.chance(0.5):
            self.lines.append(f"observe p = p_X + {f.name}[{second}]")
        elif self.chance(0.3):
            self.lines.append(f"observe p = p_{f.name}[{second}] + {self.of('0', *self.scalars)}")
        if self.tied:
            f, shift, _ = self.tied
            self.lines.append(f"observe pull = lambda_tie[{f.lo - shift}]")
        if self.chance(0.5):
            self.begin()
            which = self.of(
                f"{f.name}[{f.lo}] - 0.1",
                f"{f.name}[{upto(f.hi)}] - {f.name}[{f.lo}]*t",
                f"{f.name}[{second}]'",
                lambda: f"({self.summed(self.linear()) or 't'}) + t - {self.number()}",
                "t - 0.21",
            )
            way = self.of("either", "rising", "falling", "rising stop")
            self.lines.append(f"event near: {which} {way}")

    @property
    def text(self) -> str:
        return "\n".join(self.lines) + "\n"


def drawn(dice: random.Random, size: int | None = None, jolts: bool = False) -> str:
    draw = Draw(dice, size, jolts)
    draw.made()
    return draw.text
