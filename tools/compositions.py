"""Coefficients of splitting methods to 36 digits: the published ones, which have 15 to 26 digits,
put back on their order conditions by Newton's method. Prints them, or with names of methods these.

The conditions are those of the composition as a formal series: the product of exponentials of the
parts must be the exponential of their sum up to the order, word by word. For compositions of a
symmetric scheme S(h) = exp(h Y1 + h^3 Y3 + h^5 Y5 + ...) words are made of Y1, Y3, Y5, Y7; for
kicks and drifts of A (drift) and B (kick); and with quadratic kinetic energy (Runge-Kutta-Nystrom)
[B, [B, [B, A]]] = 0, so words with ABBB are rewritten. Reference: E. Hairer, C. Lubich, G. Wanner,
Geometric Numerical Integration, 2nd ed., III.4, III.5 and V.3.

Where a method has more coefficients than conditions, the nearest solution is taken (least change).
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

from mpmath import mp, mpf, nstr, sqrt

DIGITS = 36
mp.dps = 80

Series = dict[str, mpf]


@dataclass(frozen=True)
class Rules:
    """An algebra of words up to a weight, in which ABBB may be written by others."""

    order: int
    nystrom: bool = False

    def weight(self, word: str) -> int:
        return sum(int(letter) if letter.isdigit() else 1 for letter in word)

    def product(self, x: Series, y: Series) -> Series:
        out: Series = {}
        for left, a in x.items():
            for right, b in y.items():
                if self.weight(left) + self.weight(right) <= self.order:
                    self._add(out, left + right, a * b)
        return out

    def _add(self, out: Series, word: str, value: mpf) -> None:
        at = word.find("ABBB") if self.nystrom else -1
        if at < 0:
            out[word] = out.get(word, mpf(0)) + value
            return
        for other, factor in (("BBBA", 1), ("BBAB", -3), ("BABB", 3)):
            self._add(out, word[:at] + other + word[at + 4 :], factor * value)

    def exponential(self, exponent: Series) -> Series:
        total: Series = {"": mpf(1)}
        power: Series = {"": mpf(1)}
        for k in range(1, self.order + 1):
            power = {w: c / k for w, c in self.product(power, exponent).items()}
            for word, c in power.items():
                total[word] = total.get(word, mpf(0)) + c
        return total


def defects(parts: list[Series], whole: Series, rules: Rules) -> list[mpf]:
    made: Series = {"": mpf(1)}
    for part in parts:
        made = rules.product(made, rules.exponential(part))
    wanted = rules.exponential(whole)
    return [made.get(w, mpf(0)) - wanted.get(w, mpf(0)) for w in sorted({*made, *wanted})]


def schemes(gamma: list[mpf], order: int) -> list[mpf]:
    """Of a composition of symmetric schemes of order 2."""
    letters = [k for k in (1, 3, 5, 7) if k <= order]
    parts = [{str(k): g**k for k in letters} for g in gamma]
    return defects(parts, {"1": mpf(1)}, Rules(order))


def flows(kick: list[mpf], drift: list[mpf], order: int, nystrom: bool) -> list[mpf]:
    """Of kicks and drifts."""
    parts = [{"B": kick[0]}]
    for a, b in zip(drift, kick[1:], strict=True):
        parts += [{"A": a}, {"B": b}]
    return defects(parts, {"A": mpf(1), "B": mpf(1)}, Rules(order, nystrom))


def polish(conditions: Callable[[list[mpf]], list[mpf]], start: list[mpf]) -> list[mpf]:
    """Newton's method, of least change where the solution is not isolated."""
    x = [mpf(v) for v in start]
    for _ in range(8):
        f = conditions(x)
        step = mpf(10) ** -30
        columns = []
        for i in range(len(x)):
            moved = [v + (step if j == i else 0) for j, v in enumerate(x)]
            columns.append([(a - b) / step for a, b in zip(conditions(moved), f, strict=True)])
        x = [v - d for v, d in zip(x, _least_change(columns, f), strict=True)]
        if max(abs(v) for v in f) < mpf(10) ** -60:
            break
    worst = max(abs(v) for v in conditions(x))
    if worst > mpf(10) ** -45:
        raise ArithmeticError(f"no solution there: defect {nstr(worst, 3)}")
    return x


def _least_change(columns: list[list[mpf]], f: list[mpf]) -> list[mpf]:
    """The smallest d with J d = f, J given by columns, its rank found by pivoting rows away."""
    rows: list[list[mpf]] = []
    values: list[mpf] = []
    width = len(columns)
    remaining = [([columns[j][i] for j in range(width)], f[i]) for i in range(len(f))]
    while remaining and len(rows) < width:  # Gram-Schmidt, the largest row first
        row, value = max(remaining, key=lambda r: sum(c * c for c in r[0]))
        norm = sqrt(sum(c * c for c in row))
        if norm < mpf(10) ** -20:  # differences leave some 1e-30 of a row that depends on others
            break
        unit = [c / norm for c in row]
        rows.append(unit)
        values.append(value / norm)
        rest = []
        for r, v in remaining:
            dot = sum(a * b for a, b in zip(r, unit, strict=True))
            rest.append(
                ([a - dot * b for a, b in zip(r, unit, strict=True)], v - dot * value / norm)
            )
        remaining = [r for r in rest if sum(c * c for c in r[0]) > mpf(10) ** -40]
    return [sum(v * r[j] for v, r in zip(values, rows, strict=True)) for j in range(width)]


def palindrome(half: list[mpf]) -> list[mpf]:
    """Its last number is the middle one."""
    return half + half[-2::-1]


def composed(gamma: list[mpf]) -> tuple[list[mpf], list[mpf]]:
    """Kicks and drifts of a composition of Verlet steps, kick first."""
    ends = [mpf(0), *gamma, mpf(0)]
    return [(a + b) / 2 for a, b in pairwise(ends)], gamma


@dataclass(frozen=True)
class Scheme:
    """A symmetric composition of Verlet's: half of its steps as published, the middle one last."""

    order: int
    half: tuple[str, ...]

    def solve(self) -> tuple[list[mpf], list[mpf]]:
        half = polish(lambda x: schemes(palindrome(x), self.order), [mpf(v) for v in self.half])
        return composed(palindrome(half))


@dataclass(frozen=True)
class Flows:
    """Symmetric kicks and drifts, as published: half of them, without the middle one and the last
    of the other kind, which follow from their sums."""

    order: int
    kick: tuple[str, ...]
    drift: tuple[str, ...]
    nystrom: bool = False

    def solve(self) -> tuple[list[mpf], list[mpf]]:
        count = len(self.kick)

        def both(x: list[mpf]) -> tuple[list[mpf], list[mpf]]:
            kick, drift = x[:count], x[count:]
            if len(kick) > len(drift):  # a kick in the middle, half the drifts' sum to be made up
                drift = [*drift, mpf(1) / 2 - sum(drift)]
                return palindrome([*kick, 1 - 2 * sum(kick)]), drift + drift[::-1]
            kick = [*kick, mpf(1) / 2 - sum(kick)]
            return kick + kick[::-1], palindrome([*drift, 1 - 2 * sum(drift)])

        def conditions(x: list[mpf]) -> list[mpf]:
            return flows(*both(x), self.order, self.nystrom)

        return both(polish(conditions, [mpf(v) for v in self.kick + self.drift]))


METHODS: dict[str, Scheme | Flows] = {
    # H. Yoshida, Phys. Lett. A 150 (1990) 262, Tables 1 and 2.
    "yoshida4": Scheme(4, ("1.351207191959658", "-1.702414383919315")),
    "yoshida6": Scheme(
        6, ("0.784513610477560", "0.235573213359357", "-1.17767998417887", "1.315186320683906")
    ),
    "yoshida8": Scheme(
        8,
        (
            *("0.914844246229740", "0.253693336566229", "-1.44485223686048", "-0.158240635368243"),
            *("1.93813913762276", "-1.96061023297549", "0.102799849391985", "1.708453070786998"),
        ),
    ),
    # M. Suzuki, Phys. Lett. A 146 (1990) 319: 1/(4 - 4^(1/3)), two on either side.
    "suzuki4": Scheme(4, ("0.414490771794376", "0.414490771794376", "-0.657963087177503")),
    # W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089, s9odr6a and s17odr8a.
    "kahan_li6": Scheme(
        6,
        (
            *("0.39216144400731413928", "0.33259913678935943860", "-0.70624617255763935981"),
            *("0.082213596293550800230", "0.79854399093482996340"),
        ),
    ),
    "kahan_li8": Scheme(
        8,
        (
            *("0.13020248308889008088", "0.56116298177510838456", "-0.38947496264484728641"),
            *("0.15884190655515560090", "-0.39590389413323757734", "0.18453964097831570709"),
            *("0.25837438768632204729", "0.29501172360931029887", "-0.60550853383003451170"),
        ),
    ),
    # S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313: SRKN_6^b, SRKN_11^b.
    "blanes_moan4": Flows(
        4,
        ("0.0829844064174052", "0.396309801498368", "-0.0390563049223486"),
        ("0.245298957184271", "0.604872665711080"),
        nystrom=True,
    ),
    "blanes_moan6": Flows(
        6,
        (
            *("0.0414649985182624", "0.198128671918067", "-0.0400061921041533"),
            *("0.0752539843015807", "-0.0115113874206879"),
        ),
        (
            *("0.123229775946271", "0.290553797799558", "-0.127049212625417"),
            *("-0.246331761062075", "0.357208872795928"),
        ),
        nystrom=True,
    ),
}


def mclachlan4() -> tuple[list[mpf], list[mpf]]:
    """R. I. McLachlan, SIAM J. Sci. Comput. 16 (1995) 151, order 4 with 5 stages."""
    r = sqrt(mpf(19))
    kick = [(14 - r) / 108, (20 - 7 * r) / 108, (5 + 2 * r) / 27]
    return kick + kick[::-1], palindrome([mpf(2) / 5, mpf(-1) / 10, mpf(2) / 5])


def rows(values: list[mpf]) -> str:
    texts = [f"PK_C({nstr(value, DIGITS)})" for value in values]
    return ",\n    ".join(", ".join(texts[i : i + 2]) for i in range(0, len(texts), 2))


def show(name: str, kick: list[mpf], drift: list[mpf]) -> None:
    if isinstance(METHODS.get(name), Scheme):
        half = drift[: (len(drift) + 1) // 2]
        print(f"PK_VERLETS({name}, {len(half)},\n    {rows(half)})")
        return
    for kind, values in (("kick", kick), ("drift", drift)):
        half = values[: (len(values) + 1) // 2]
        macro = f"PK_{'MIRROR' if len(values) % 2 else 'TWICE'}_{len(half)}"
        print(f"static const pk_real pk_{name}_{kind}[] = {{{macro}(\n    {rows(half)})}};")


def main() -> int:
    wanted = sys.argv[1:] or [*METHODS, "mclachlan4"]
    for name in wanted:
        if name == "mclachlan4":
            kick, drift = mclachlan4()
            worst = max(abs(v) for v in flows(kick, drift, 4, False))
            if worst > mpf(10) ** -60:
                raise ArithmeticError(f"mclachlan4: defect {nstr(worst, 3)}")
        else:
            kick, drift = METHODS[name].solve()
        show(name, kick, drift)
    return 0


if __name__ == "__main__":
    sys.exit(main())
