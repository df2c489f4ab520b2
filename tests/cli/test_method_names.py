"""The digit in a method's name is what docs/commands.md says it is."""

from __future__ import annotations

import re

from pkgen.run.build import runtime_methods


def test_the_digit_is_the_order_or_of_some_the_stages() -> None:
    of_stages = {"gauss", "lobatto"}
    told = {"dopri": 5, "dop": 8, "gsl_rkf": 5, "gsl_rk": 8}  # dop853: orders 8, 5 and 3
    seen = 0
    for method in runtime_methods():
        stem, digits, _ = re.fullmatch(r"(\w*?)(\d*)([a-z]*)", method["name"]).groups()
        if not digits:
            continue
        seen += 1
        wanted = told.get(stem, int(digits))
        found = method["stages"] if stem in of_stages else method["order"]
        assert found == wanted, method["name"]
    assert seen > 30
