"""The coefficients of splitting methods, as they stand in the header: they fulfil their order
conditions to 33 digits, miss those of the next order, and the check sees a wrong digit."""

import re
import sys
from pathlib import Path

import pytest
from mpmath import mpf, workdps

from pkgen.methods import METHODS

ROOT = Path(__file__).parents[2]
HEADER = ROOT / "runtime" / "include" / "pk" / "step" / "tables_splitting.h"
sys.path.insert(0, str(ROOT / "tools"))
import compositions  # noqa: E402

ORDERS = {"symplectic_euler": 1, "verlet": 2, "mclachlan4": 4} | {
    name: method.order for name, method in compositions.METHODS.items()
}


def numbers(text: str) -> list[mpf]:
    return [mpf(number) for number in re.findall(r"PK_C\((.*?)\)", text)]


def table(name: str) -> tuple[list[mpf], list[mpf]]:
    text = HEADER.read_text()
    with workdps(50):
        half = re.search(rf"PK_VERLETS\({name}, (\d+),(.*?)\)\n(?! )", text, re.DOTALL)
        if half:
            drift = numbers(half[2] + ")")
            assert len(drift) == int(half[1])
            return compositions.composed(compositions.palindrome(drift))
        found = []
        for kind in ("kick", "drift"):
            body = re.search(rf"pk_{name}_{kind}\[\] = {{(.*?)}};", text, re.DOTALL)
            assert body, name
            values = numbers(body[1])
            if "PK_TWICE_" in body[1]:
                values += values[::-1]
            found.append(compositions.palindrome(values) if "PK_MIRROR_" in body[1] else values)
        return found[0], found[1]


def worst(name: str, order: int, wrong: float = 0) -> mpf:
    kick, drift = table(name)
    method = compositions.METHODS.get(name)
    with workdps(50):
        kick[0] += wrong
        composed, steps = compositions.composed(drift)
        if isinstance(method, compositions.Scheme):
            apart = max(abs(a - b) for a, b in zip(kick, composed, strict=True))
            return max(apart, *(abs(d) for d in compositions.schemes(steps, order)))
        nystrom = method is not None and method.nystrom
        return max(abs(d) for d in compositions.flows(kick, drift, order, nystrom))


def test_every_table_is_known() -> None:
    methods = {name for name, row in METHODS.items() if row.family == "SPLITTING"}
    assert methods == set(ORDERS) and len(methods) == 11


@pytest.mark.parametrize("name", ORDERS)
def test_order_conditions(name: str) -> None:
    order = ORDERS[name]
    assert worst(name, order) < 1e-33
    if order < 8:  # the next; for schemes the next is odd
        assert worst(name, order + 1) > 1e-7
    assert worst(name, order, wrong=1e-20) > 1e-21
