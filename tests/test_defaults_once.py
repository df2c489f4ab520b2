"""A default or a bound of a run is defined in one module, and an option is parsed in one."""

import ast
import re

from conftest import ROOT
from pkgen import defaults

PKGEN = ROOT / "generator" / "pkgen"
RUN_NUMBERS = ("until", "every", "step", "max_step", "rtol", "atol")
# Who may look at the text of such an option: its parser, and messages that repeat the text.
READ_BY = {"run/values.py": RUN_NUMBERS, "run/rows.py": ("every",), "cli/chart.py": ("step",)}
TELLING = ("cli", "api", "scenes", "run", "describe", "analysis")


def test_a_default_of_a_run_is_in_one_module_and_an_option_is_parsed_in_one() -> None:
    """Defaults and bounds of runs are those of defaults.py: others have neither such a number nor a
    text with it, and read options as the numbers of a plan."""
    own = [defaults.RTOL, defaults.GAUSS_RTOL, defaults.MAX_STEPS, defaults.SMALLEST_RTOL]
    said = re.compile(r"\b(1e-10|1e-5|1_?000_?000_?000|2\.2e-16)\b")
    wrong = []
    roots = [PKGEN / folder for folder in TELLING] + [*ROOT.glob("addons/*/pkgen_*")]
    for path in (path for root in roots for path in root.rglob("*.py")):
        name = path.relative_to(PKGEN).as_posix() if PKGEN in path.parents else path.name
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                wrong += [f"{name}:{node.lineno}: '{x}'" for x in said.findall(node.value)]
            if isinstance(node, ast.Constant) and (name, node.value) not in UNRELATED:
                known = any(node.value == x and type(node.value) is type(x) for x in own)
                wrong += [f"{name}:{node.lineno}: {node.value}"] * known
            of_options = isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)
            if of_options and node.value.id == "options" and isinstance(node.ctx, ast.Load):
                alone = node.attr in RUN_NUMBERS and node.attr not in READ_BY.get(name, ())
                wrong += [f"{name}:{node.lineno}: options.{node.attr}"] * alone
    assert wrong == []


# Numbers that are equal to a default by chance.
UNRELATED = {
    ("analysis/choose/reference.py", defaults.RTOL),
    ("analysis/linear/system.py", defaults.RTOL),
    ("analysis/stability/orbits.py", defaults.GAUSS_RTOL),
}
