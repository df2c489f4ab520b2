"""Makes an integration method from a tableau or from weights: chooses the family of the runtime
that runs the method, and writes the table of coefficients in C.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path

from ..methods import METHODS, Own
from ..source import Diagnostic, ModelError, Source, Span
from . import words
from .tableau import NotANumber, Tableau, number, read_tableau
from .trees import Conditions, symmetric, symplectic

MOST_RUN = 16  # most stages of a tableau for runs: PK_MOST_STAGES of pk/step/tableau.h
MOST_WEIGHTS = 64
_EXACT = 2**53  # All integers up to this one are exact doubles.


def fit(name: str) -> str:
    """Returns a valid method name for a file name; it differs from the built-in methods' names."""
    word = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_").lower()[:40]
    word = word if word[:1].isalpha() else f"m_{word}".rstrip("_")
    return f"own_{word}" if word in METHODS else word


def of_text(name: str, source: Source) -> Own:
    """Returns the method of a tableau file. Raises ModelError."""
    return of_tableau(name, read_tableau(source))


def facts(tableau: Tableau) -> dict[str, object]:
    """Returns properties of a tableau, computed from its coefficients."""
    conditions = Conditions(tableau.a)
    order, size = conditions.order(tableau.b)
    found: dict[str, object] = {
        "class": tableau.kind,
        "stages": tableau.stages,
        "order": order,
        "error constant": size,
        "symplectic": symplectic(tableau.a, tableau.b),
        "symmetric": symmetric(tableau.a, tableau.b),
    }
    if tableau.bhat is not None:
        found["embedded order"] = conditions.order(tableau.bhat)[0]
    return found


def of_tableau(name: str, tableau: Tableau) -> Own:
    """Returns the method of a tableau. Raises ModelError if the runtime does not support it."""
    found = facts(tableau)
    if tableau.kind != "explicit":
        near = "gauss1 to gauss8, lobatto2 to lobatto4, radau5 and radau9 are built in"
        raise _refused(
            tableau, f"the method is {tableau.kind}", f"tables run that are explicit; {near}"
        )
    same_last = _first_same_as_last(tableau)
    stages = tableau.stages - same_last
    if stages > MOST_RUN:
        raise _refused(
            tableau, f"{stages} stages", f"an explicit table that runs has {MOST_RUN} at most"
        )
    order = int(found["order"])
    a, b = tableau.a[:stages], tableau.b[:stages]
    lists = {
        "c": tableau.c[:stages],
        "a": [x for i, row in enumerate(a) for x in row[:i]],
        "b": b,
    }
    more, traits, family = "", set(), "ERK"
    if tableau.bhat is not None:
        lists["e"] = [x - y for x, y in zip(tableau.b, tableau.bhat, strict=True)]
        # This entry is the weight of the derivative at the new point.
        if same_last:
            lists["e"][stages] = -tableau.bhat[stages]
        else:
            lists["e"].append(Fraction(0))
        low = max(1, min(order, int(found["embedded order"])))
        more = f", .e = pk_{name}_e, .error_order = {low + 1}, .beta = PK_C(0.04)"
        more += ", .shrink = PK_C(0.2), .grow = PK_C(10.0)"
        traits |= {"adaptive", "dense"}
        family = "EMBEDDED"
    return Own(
        family=family,
        traits=frozenset(traits),
        requires=METHODS["rk4"].requires,
        name=name,
        order=order,
        stages=stages,
        dense_order=min(3, order) if family == "EMBEDDED" else 0,
        table=_table(name, "pk_tableau", stages, lists, more),
        doc=f"explicit Runge-Kutta of {Path(tableau.source.path).name}",
        facts=tuple(found.items()),
    )


def _first_same_as_last(tableau: Tableau) -> int:
    """Returns 1 if the method is first-same-as-last, else 0. The last stage is then left out, since
    the runtime evaluates the derivative at the new point anyway."""
    a, b = tableau.a, tableau.b
    pair = tableau.bhat is not None and tableau.stages > 1
    return int(pair and a[-1][:-1] == b[:-1] and not b[-1] and not a[-1][-1])


def _refused(tableau: Tableau, message: str, help: str) -> ModelError:
    at = next(iter(re.finditer(r"(?m)^\s*(A)\b", tableau.source.text)), None)
    span = Span(at.start(1), at.end(1)) if at else Span(0, 1)
    return ModelError(tableau.source, [Diagnostic(message, span, help)])


def of_weights(name: str, text: str, option: str = "--composition") -> Own:
    """Returns a composition of Verlet steps; the weights are their lengths. Raises ModelError."""
    source = Source(f"{option} {text[:200]}", text)
    weights = _weights(source)
    s, half = len(weights), Fraction(1, 2)
    kicks = [weights[0] * half]
    kicks += [(x + y) * half for x, y in itertools.pairwise(weights)]
    kicks.append(weights[-1] * half)
    order, size = words.order(kicks, weights)
    mirrored = all(
        abs(x - y) < Fraction(1, 10**14) for x, y in zip(weights, weights[::-1], strict=True)
    )
    traits = {"symplectic"} | ({"symmetric"} if mirrored else set())
    found = {
        "class": "composition of Verlet steps",
        "stages": s,
        "order": order,
        "error constant": size,
        "symplectic": True,
        "symmetric": mirrored,
    }
    return Own(
        family="SPLITTING",
        traits=frozenset(traits),
        requires=METHODS["verlet"].requires,
        name=name,
        order=order,
        stages=s,
        dense_order=0,
        table=_table(name, "pk_splitting", s, {"kick": kicks, "drift": weights}, ""),
        doc=f"{s} Verlet step{'s' * (s != 1)} of given weights",
        facts=tuple(found.items()),
    )


def _weights(source: Source) -> list[Fraction]:
    """Parses weights separated by commas. Raises ModelError."""
    found, errors, at = [], [], 0
    parts = source.text.split(",")
    for part in parts[: MOST_WEIGHTS + 1]:
        word = part.strip()
        start = at + len(part) - len(part.lstrip())
        try:
            found.append(number(word))
        except NotANumber as wrong:
            errors.append(
                Diagnostic(str(wrong), Span(start, start + max(1, len(word))), wrong.help)
            )
        at += len(part) + 1
    whole = Span(0, max(1, len(source.text)))
    if len(parts) > MOST_WEIGHTS:
        errors.append(Diagnostic(f"{len(parts)} weights", whole, f"{MOST_WEIGHTS} at most"))
    if not errors and abs(sum(found) - 1) > Fraction(1, 10**12):
        message = f"the weights sum to {float(sum(found)):.12g}, not to 1"
        errors.append(
            Diagnostic(message, whole, "each is the part of a step that a Verlet step is")
        )
    if errors:
        raise ModelError(source, errors[:5], max(0, len(errors) - 5))
    return found


def c_number(x: Fraction) -> str:
    """Returns a number in C with one rounding: a quotient of doubles, or 40 digits."""
    if max(abs(x.numerator), x.denominator) < _EXACT:
        above = f"PK_C({x.numerator}.0)"
        return above if x.denominator == 1 else f"{above} / PK_C({x.denominator}.0)"
    with localcontext() as context:
        context.prec = 40
        return f"PK_C({Decimal(x.numerator) / Decimal(x.denominator):e})"


def _table(
    name: str, kind: str, stages: int, lists: dict[str, Sequence[Fraction]], more: str
) -> str:
    lines = []
    for key, numbers in lists.items():
        if numbers:
            text = ", ".join(map(c_number, numbers))
            lines.append(f"static const pk_real pk_{name}_{key}[] = {{{text}}};")
    members = [
        f".{key} = {f'pk_{name}_{key}' if xs else 'NULL'}"
        for key, xs in lists.items()
        if key != "e"
    ]
    lines.append(
        f"static const struct {kind} pk_{name}_table = {{.stages = {stages}, "
        f"{', '.join(members)}{more}}};"
    )
    return "\n".join(lines) + "\n"
