"""Random models of a family of rotations, and the same with its members one by one: names of their
own, sums written out, ends put in by hand."""

import random
import re
from dataclasses import dataclass, field

# What may hold beyond an end: the rotation there, and its body rates by hand.
FIXED = {
    "rot([0, 0, 1], 0.3*t)": "[0, 0, 0.3]",
    "rot([1, 0, 0], 0.4)*rot([0, 1, 0], sin(t))": "[0, cos(t), 0]",
    "rot([3, 4, 0], b)": "[0, 0, 0]",
}
ENDS = ("periodic", "free", *FIXED)
TOKEN = re.compile(r"<(\w+)(?:,(-?\d+))?>")  # <R,1> is member i + 1 of R, <w,1> its body rates

INERTIA = {
    "diagonal": "a[<i>]/2*<w,0>.x^2 + 0.7*<w,0>.y^2 + <w,0>.z^2",
    "with its products": "0.6*dot(<w,0>, <w,0>) + 0.1*dot(<w,0>, [1, 2, 3])^2",
    "of what hangs on points": "0.6*dot(<w,0>, <w,0>) + 0.3*<x,0>'^2"
    " + 0.2*dot([<x,0>', 0, 0] + <R,0>*cross(<w,0>, [0.3, 0.2, 1]), <R,0>*[1, 2, 0.5])^2",
    "of neighbours": "0.6*dot(<w,0>, <w,0>)"
    " + 0.1*dot(<R,1>*<w,1> - <R,0>*<w,0>, <R,1>*<w,1> - <R,0>*<w,0>)",
}
POTENTIALS = (  # of a member and the next
    "b*dot(<R,0>*[0, 0, 1], <R,1>*[0, 0, 1])",
    "dot(<R,0>*[1, 0.2, 0], <R,1>*[0, 1, 0])^2/3",
    "sin(dot(<R,0>*[1, 0, 0], <R,1>*[0.3, 0, 1]))*(1 + 0.1*<i>)",
    "dot([<x,0>, 1, 0] - <R,1>*[1, 0, 0], <R,0>*[0, 1, 1])",
    "sqrt(2 + dot(<R,0>*[1, 1, 0], <R,1>*[0, 0, 1]))*cos(t)",
)
ALONE = (
    "a[<i>]*(<R,0>*[0, 0.3, 1]).z",
    "<x,0>*(<R,0>*[1, 0, 0]).y",
    "(inverse(<R,0>)*[1, 0, 2]).x^2/4 + X*<R,0>.x*<R,0>.w",
)
FORCES = (
    "-0.1*<w,0>",
    "[<x,0>, 0.2*sin(t), 0] - 0.1*<w,0>",
    "0.1*cross(<w,0>, [1, 0, 2]) + inverse(<R,0>)*[0, 0, 0.3]",
)
DRAG = (
    "0.05*dot(<w,0>, <w,0>)",
    "0.05*dot(<R,1>*<w,1> - <R,0>*<w,0>, <R,1>*<w,1> - <R,0>*<w,0>)",
)


@dataclass
class Made:
    """A model and, of the same size, its members one by one."""

    size: int
    ends: tuple[str, str]  # below and above
    text: str = ""
    singles: str = ""
    outputs: tuple[str, ...] = ()
    names: list[str] = field(default_factory=list)


def made(dice: random.Random, size: int, ends: tuple[str, str] | None = None) -> Made:
    """With `start`s, and with outputs of members, sums and the energy's parts."""
    if ends is None:
        ends = dice.choice(ENDS), dice.choice(ENDS)
    if "periodic" in ends:
        ends = "periodic", "periodic"
    m = Made(size, ends)
    both: list[tuple[str, str]] = []

    def same(line: str) -> None:
        both.append((line, line))

    def summed(word: str, lo: int, hi: int, body: str, sign: str = "") -> None:
        last = "N" if hi == size else f"N-{size - hi}"
        parts = [f"({_single(m, body, i)})" for i in range(lo, hi + 1)]
        family = f"{word} {sign}sum({_family(body)}, i = {lo}..{last})"
        both.append((family, f"{word} {sign}({' + '.join(parts) or '0'})"))

    first, last = (0 if ends[0] != "free" else 1), (size if ends[1] != "free" else size - 1)
    if ends[0] == "periodic" or dice.random() < 0.5:
        first = max(first, 1)
    both.append(("model spins", "model singles"))
    both.append((f"size N = {size}", ""))
    same("param b = 0.7")
    both.append(
        (
            "param a[i = 1..N] = 1 + 0.2*sin(i) in (0, inf)",
            "\n".join(f"param a{i} = 1 + 0.2*sin({i})" for i in range(1, size + 1)),
        )
    )
    both.append(("coord x[1..N]", "\n".join(f"coord x{i}" for i in range(1, size + 1))))
    same("coord X")
    both.append(("rotation R[1..N]", "\n".join(f"rotation R{i}" for i in range(1, size + 1))))
    same("rotation S")
    if ends[0] == "periodic":
        both.append(("periodic R", ""))
    for at, end in (("0", ends[0]), ("N+1", ends[1])):
        if end in FIXED:
            both.append((f"fixed R[{at}] = {end}", ""))
        elif end == "free":
            both.append((f"free R[{at}]", ""))
    same("kinetic X'^2/2 + dot(omega(S), omega(S))/2 + 0.2*(omega(S).x + X')^2")
    inertia = INERTIA[dice.choice([*INERTIA])]
    of_pairs = "<w,1>" in inertia
    summed("kinetic", first if of_pairs else 1, last if of_pairs else size, inertia)
    if of_pairs:
        summed("kinetic", 1, size, "0.5*dot(<w,0>, <w,0>)")
    summed("kinetic", 1, size, "0.4*<x,0>'^2")
    summed("potential", 1, size, "0.3*<x,0>^2")
    for body in dice.sample(POTENTIALS, 2):
        begin = max(first, 1) if "<x" in body or "<i>" in body else first
        summed("potential", begin, last, body, "-" if dice.random() < 0.5 else "")
    for body in dice.sample(ALONE, 2):
        summed("potential", 1, size, body)
    both.append(
        (
            "potential dot(S*[0, 0, 1], R[1]*[0.5, 0, 1]) + X^2/2",
            "potential dot(S*[0, 0, 1], R1*[0.5, 0, 1]) + X^2/2",
        )
    )
    if dice.random() < 0.5:
        body = dice.choice(DRAG)
        summed(
            "dissipation", first if "<w,1>" in body else 1, last if "<w,1>" in body else size, body
        )
    if dice.random() < 0.7:
        body = dice.choice(FORCES)
        both.append(
            (
                f"force R[i = 1..N] = {_family(body)}",
                "\n".join(f"force R{i} = {_single(m, body, i)}" for i in range(1, size + 1)),
            )
        )
        same("force S = [0.1, -0.2*omega(S).y, 0]")
    angle, rates = "0.3*<i> + 0.2", "[0.3*cos(<i>), 0.2, -0.1*<i>/N]"
    both.append(
        (
            f"start R[i = 1..N] = rot([1, 2, 0.5], {_family(angle)})*rot([0, 0, 1], 0.4)",
            "\n".join(
                f"start R{i} = rot([1, 2, 0.5], {_single(m, angle, i)})*rot([0, 0, 1], 0.4)"
                for i in range(1, size + 1)
            ),
        )
    )
    both.append(
        (
            f"start omega(R[i = 1..N]) = {_family(rates)}",
            "\n".join(f"start omega(R{i}) = {_single(m, rates, i)}" for i in range(1, size + 1)),
        )
    )
    both.append(("start x[N] = 0.3, X' = 0.5", f"start x{size} = 0.3, X' = 0.5"))
    same("start S = rot([0, 1, 0], 0.2), omega(S) = [0.1, 0.2, 0.3]")
    both.append(
        (
            "observe tip = (R[N]*[0, 1, 0]).z + omega(R[N]).x",
            f"observe tip = (R{size}*[0, 1, 0]).z + omega(R{size}).x",
        )
    )
    summed("observe up =", 1, size, "(<R,0>*[0, 0, 1]).z*<w,0>.y")
    same("observe own = omega(S).z + S.w")
    m.text = "\n".join(a for a, _ in both if a) + "\n"
    m.singles = "\n".join(b for _, b in both if b).replace("/N]", f"/{size}]") + "\n"
    m.outputs = ("tip", "up", "own", "energy")
    return m


def _family(body: str) -> str:
    def shown(token: re.Match) -> str:
        name, shift = token[1], int(token[2] or 0)
        at = f"i+{shift}" if shift else "i"
        return {"i": "i", "a": "a[i]", "w": f"omega(R[{at}])"}.get(name, f"{name}[{at}]")

    return TOKEN.sub(shown, body)


def _single(m: Made, body: str, i: int) -> str:
    def shown(token: re.Match) -> str:
        name, at = token[1], i + int(token[2] or 0)
        if name == "i":
            return str(i)
        if not 1 <= at <= m.size:
            end = m.ends[0 if at < 1 else 1]
            if end in FIXED:
                return f"({end})" if name == "R" else FIXED[end]
            at = (at - 1) % m.size + 1 if end == "periodic" else 1 if at < 1 else m.size
        return f"omega(R{at})" if name == "w" else f"{name}{at}"

    return TOKEN.sub(shown, body.replace("a[<i>]", f"a{i}"))
