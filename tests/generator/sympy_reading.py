"""Parts of a model as SymPy reads them: L, D and Q over its symbols, without pkgen."""

import re
from itertools import pairwise

import sympy as sp

t = sp.Symbol("t", real=True)
FUNCTIONS = "sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt pi"


class Family(dict):
    """Members by their index, round and round where there is a period."""

    period = 0

    def __missing__(self, i: int) -> sp.Expr:
        assert self.period, i
        return self[(i - 1) % self.period + 1]


class Reading:
    """Of the coordinates q with rates v, an input u with its derivatives, and parameters."""

    def __init__(self, parts: dict, q: list, v: list, u: list, parameters: dict) -> None:
        self.parts, self.pairs = parts, [*zip(q, v, strict=True), *pairwise(u)]
        self.names = {name: getattr(sp, name) for name in FUNCTIONS.split()}
        self.names |= {"t": t, "u": u[0], "D": self.rate, "dot": dot, "norm": norm}
        self.names |= parameters | parts.get("sizes", {})
        self.places = {}  # of each coordinate
        left = iter(q)
        for name in parts["coords"]:
            base, _, size = name.removesuffix("]").partition("[1..")
            if not size:
                self.places[name] = self.names[name] = next(left)
                continue
            family = self.names[base] = Family()
            for i in range(1, self.names[size] + 1):
                family[i] = next(left)
        for end in parts.get("ends", ()):
            self.end(*end.split(" ", 1))
        for target, text in parts.get("lets", {}).items():
            name, _, index = target.removesuffix("]").partition("[")
            if not index:
                self.names[name] = self.read(text)
                continue
            variable, _, ends = index.rpartition("=")
            lo, hi = (ends.split("..") * 2)[:2]
            for k in range(int(lo), int(self.read(hi)) + 1):
                with_k = re.sub(rf"\b{variable or 'no name'}\b", str(k), text)
                self.names.setdefault(name, Family())[k] = self.read(with_k)

    def end(self, kind: str, said: str) -> None:
        name, index, value = re.fullmatch(r"(\w+)(?:\[(\d+)\])?(?: = (.*))?", said).groups()
        family = self.names[name]
        if kind == "periodic":
            family.period = len(family)
        else:
            family[int(index)] = self.read(value) if value else family[int(index) - 1]

    def rate(self, of: object) -> object:
        """The total time derivative."""
        if isinstance(of, list):
            return [self.rate(x) for x in of]
        return sp.diff(of, t) + sum(sp.diff(of, a) * b for a, b in self.pairs)

    def read(self, text: str) -> sp.Expr:
        text = re.sub(r"(\w+(?:\[[^]]*\])?)'", r"D(\1)", text).replace("^", "**")
        text = re.sub(r"\b([a-z]+)\.([xyz])\b", lambda m: f"{m[1]}[{'xyz'.index(m[2])}]", text)
        over = r"sum((\1) for \2 in range(\3, (\4) + 1))"
        text = re.sub(r"sum\((.*), (\w) = (\w+)\.\.([\w-]+)\)", over, text)
        return eval(re.sub(r"\b(\d+)/", r"sp.Integer(\1)/", text), {"sp": sp, **self.names})

    def energy(self, part: str) -> sp.Expr:
        given = self.parts.get(part, ())
        return sum(map(self.read, (given,) if isinstance(given, str) else given), sp.Integer(0))

    def lagrangian(self) -> sp.Expr:
        return self.energy("kinetic") - self.energy("potential") + self.energy("lagrangian")

    def forces(self) -> list:
        given = self.parts.get("forces", {})
        return [self.read(given[n]) if n in given else sp.Integer(0) for n in self.places]


def dot(a: list, b: list) -> sp.Expr:
    return sum(x * y for x, y in zip(a, b, strict=True))


def norm(a: list) -> sp.Expr:
    return sp.sqrt(dot(a, a))
