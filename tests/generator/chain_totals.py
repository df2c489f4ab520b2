"""Dice for sums over all members inside expressions, and for rates of states in equations."""

import re

from chain_bodies import Bodies, Family, upto

OF_TOTALS = (
    "cos({0})",
    "log(2 + {0}^2)",
    "{0}^2/9",
    "{0}/(1 + {0}^2)",
    "sqrt(1 + {0}^2)",
    "{0}*{1}/5",
    "{1}/(2 + {0}^2)",
    "exp(-({0} - {1})^2)",
    "atan2({0}, 2)",
)


def apart(text: str) -> str:
    """With another loop variable, to stand where there is one."""
    return re.sub(r"\bi\b", "j", text)


class Totalled(Bodies):
    def a_total(self, moving: bool = False) -> str:
        """One over members, or a `let` of one; with `moving` of rates perhaps."""
        if self.total and self.chance(0.4):
            return self.total
        self.begin()
        body = self.of(self.linear, lambda: self.smooth(1), lambda: f"i*({self.linear()})/N")
        if moving and self.chance(0.5):
            body = self.of(
                f"{self.ref(True)}'", f"{self.ref(True)}'^2", f"{body}*{self.ref(True)}'"
            )
        return self.summed(body) or "0.3"

    def of_totals(self, moving: bool = False) -> str:
        form = self.dice.choice(OF_TOTALS)
        one = f"({self.a_total(moving)})"
        other = self.of(
            one, lambda: f"({self.a_total(moving)})", *self.scalars, *self.members_named()
        )
        return form.format(one, other)

    def members_named(self) -> list[str]:
        f = self.dice.choice(self.families)
        return [f"{f.name}[{f.lo}]", f"{f.name}[{upto(f.hi)}]"]

    def of_mean(self) -> str | None:
        """A sum of members each of which feels a total, or stands beside one throughout."""
        one = f"({apart(self.of_totals())})"
        self.begin()
        forms = ("({0})*{1}", "cos({0} - {1})", "({0} - {1})^2/9", "{1}*({0})^2/9")
        return self.summed(self.dice.choice(forms).format(self.linear(), one))

    def total_energies(self) -> None:
        for _ in range(self.of(0, 0, 0, 1, 2)):
            word = self.of("potential", "potential", "lagrangian -")
            if self.chance(0.6):
                self.lines.append(f"{word} {self.factor_of_none()}*{self.of_totals()}")
            else:
                self.add(f"{word} {self.factor_of_none()}*", self.of_mean())
        if self.chance(0.1):
            f = self.dice.choice(self.families)
            self.begin()
            self.member(f, 0)
            weight = f"(2 + cos({apart(self.of_totals())}))"
            self.begin()
            own = self.member(f, 0)
            self.add("kinetic", self.summed(f"{weight}*{own}'^2/3"))
        if self.chance(0.1):
            self.lines.append(f"dissipation sqrt(1 + ({self.a_total(True)})^2)/9")

    def factor_of_none(self) -> str:
        return self.of(self.number(), "k", "sin(t)", "0.3")

    def total_forces(self) -> None:
        if self.chance(0.2):
            f = self.dice.choice(self.families)
            over = f"{f.lo}..{upto(f.hi)}"
            own = self.of("0.1", f"{f.name}[i]", f"{f.name}[i]'")
            felt = apart(self.of_totals(True))
            self.lines.append(f"force {f.name}[i = {over}] = {own}*{felt}/9")

    def second_states(self) -> None:
        """States whose rates use those of u and s."""
        if not self.chance(0.4):
            return
        uses = ["u[i]'", "u[i]'*u[1]'", "s'/2", "u[i]'*s"]
        if any(f.name == "u" and f.down and f.up for f in self.others):
            uses += ["u[i+1]' - u[i-1]'"]
        self.lines.append("state r[1..N]")
        self.lines.append(f"rate r[i = 1..N] = -r[i] + {self.of(*uses)}/3")
        f = self.dice.choice(self.families)
        if self.chance(0.5) and f.lo <= 1 and f.hi >= 0:
            self.lines.append(f"force {f.name}[i = 1..N] = r[i]' - 0.1*u[i]'")
        if self.chance(0.5):
            other = self.of("0", "s'", "u[N]'")
            self.lines.append(f"observe turned = r[1]' + {other}")
        if self.chance(0.3):
            self.lines.append("observe each_rate[i = 1..N] = r[i]'*u[i]'")
        self.others.append(Family("r", 1, 0, moves=False))

    def total_outputs(self) -> None:
        if self.chance(0.2):
            self.lines.append(f"observe whole = {self.of_totals(True)}")
        if self.chance(0.15):
            f = self.dice.choice(self.families)
            over = f"{f.lo}..{upto(f.hi)}"
            felt = apart(self.of_totals(True))
            self.lines.append(f"observe beside[i = {over}] = {f.name}[i] - {felt}")
        if self.chance(0.1):
            self.lines.append(f"observe changing = ({self.of_totals()})'")

    def less_mean(self, value: str, over: str, n: str) -> str:
        """A start whose mean, or whose norm, is taken out."""
        if not self.chance(0.2):
            return value
        total = apart(f"sum({value}, i = {over})")
        return self.of(f"{value} - {total}/{n}", f"({value})/sqrt(1 + {total}^2)")
