"""Writes tests/long.txt, the cases that `make test` leaves to `make test-long`, by measured times.

    .venv/bin/python -m pytest -n 2 -m 'not long' --junitxml=times.xml tests
    python tools/long_tests.py times.xml

A test function has 1.2 s in `make test`: its quickest cases, one of them at least unless that takes
more than 3 s, or 9 s where there are others. Lines of today's table stay, since their cases were
not measured; delete the file and leave out `-m 'not long'` to begin anew.
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TABLE = ROOT / "tests" / "long.txt"
BUDGET, ALONE = 1.2, 3.0  # s
# What stays whole, and why.
KEPT = {
    "tests/test_docs.py": "docs are examples that run",
    "test_names_and_comments_are_never_markup_or_script": "no other test is of that",
    "test_models_compile_without_sympy": "no other test is of that",
}
# Of random tests against another derivation one case stays, though it takes seconds.
RANDOM = (
    "test_random_models_are_those_of_members_written_out",
    "test_members_are_rotations_one_by_one",
    "test_loops_are_members_written_out",
    "test_redundant_rows_change_no_motion",
    "test_rows_of_loops_that_all_but_follow_from_others_are_told",
    "test_constraints_are_closed_by_their_multipliers",
    "test_chains_that_are_tied_equal_the_unrolled_code",
    "test_a_chain_whose_end_is_held_is_that_written_out",
    "test_a_chain_of_bodies_that_turn_is_that_written_out",
    "test_implicit_methods_of_chains_are_those_written_out",
    "test_bands_of_chains_are_the_dense_matrices",
)


def chosen(junit: Path) -> set[str]:
    """The cases beyond the budget of their function, as pytest names them."""
    functions = defaultdict(list)
    for case in ElementTree.parse(junit).getroot().iter("testcase"):
        path = case.get("classname", "").replace(".", "/") + ".py"
        name = case.get("name", "")
        function = name.partition("[")[0]
        if case.find("skipped") is None and not KEPT.keys() & {path, function}:
            functions[path, function].append((float(case.get("time", 0)), f"{path}::{name}"))
    long = set()
    for (_, function), cases in functions.items():
        spent = 0.0
        for place, (seconds, name) in enumerate(sorted(cases)):
            most = ALONE * (3 if len(cases) > 1 else 1)
            first = place == 0 and (seconds <= most or function in RANDOM)
            if first or spent + seconds <= BUDGET:
                spent += seconds
            else:
                long.add(name)
    return long


def main() -> None:
    before = set(TABLE.read_text(encoding="utf-8").splitlines()) if TABLE.exists() else set()
    lines = sorted(before | chosen(Path(sys.argv[1])))
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{TABLE}: {len(lines)} cases")


if __name__ == "__main__":
    main()
