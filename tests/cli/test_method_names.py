"""The digit in a method's name is what docs/commands.md says it is."""

from __future__ import annotations

import json
import os
import re

from pkgen.methods import METHODS
from pkgen.run.build import LISTED, described_methods, runtime_methods
from pkgen.run.methods_table import USES, methods_text


def rounded(found: object) -> object:
    """Compilers differ in the last digits."""
    return json.loads(json.dumps(found), parse_float=lambda x: f"{float(x):.9g}")


def test_the_list_is_as_the_compiled_runtime_says() -> None:
    """PKGEN_UPDATE=1 writes it."""
    found = described_methods()
    if os.environ.get("PKGEN_UPDATE"):
        rows = ",\n".join(map(json.dumps, found))
        LISTED.write_text(f"[\n{rows}\n]\n", encoding="utf-8")
    listed = json.loads(LISTED.read_text(encoding="utf-8"))
    assert [m["name"] for m in listed] == list(METHODS)
    there = {m["name"] for m in found}
    assert rounded([m for m in listed if m["name"] in there]) == rounded(found)


def test_each_method_stands_under_a_use() -> None:
    assert {method.family for method in METHODS.values()} == USES.keys()
    table = methods_text(runtime_methods()).split("\n\n")[1]
    assert {line.split()[0] for line in table.splitlines()[2:]} == METHODS.keys()


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


def test_what_is_known_of_methods_is_as_the_runtime_says() -> None:
    """The generator knows it without a C compiler."""
    noted = {trait for method in METHODS.values() for trait in method.traits}
    for method in runtime_methods():
        known = METHODS[method["name"]]
        assert known.traits == noted & {*method["flags"]}, method["name"]
        assert {*known.requires} == {*method["requires"]}, method["name"]
