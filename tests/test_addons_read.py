"""What add-ons import of the core, and that the core names no add-on."""

import ast
from pathlib import Path

import pytest
from test_architecture import MODULES

from conftest import ROOT

PKGEN = ROOT / "generator" / "pkgen"


def _packages(text: str) -> set[str]:
    """Returns the packages of this project that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(text)):
        names = [node.module] if isinstance(node, ast.ImportFrom) and not node.level else []
        names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        found |= {name.partition(".")[0] for name in names if name and name.startswith("pkgen")}
    return found


@pytest.mark.needs_addon
def test_the_core_names_no_addon_and_none_another() -> None:
    wrong = []
    for root in [PKGEN, *(ROOT / "addons").glob("*/pkgen_*"), *(ROOT / "addons").glob("*/tests")]:
        own = f"pkgen_{root.parent.name}"
        for path in root.rglob("*.py"):
            used = _packages(path.read_text(encoding="utf-8"))
            wrong += [f"{path}: {name}" for name in used - {"pkgen", "pkgen_runtime", own}]
    assert wrong == []


# An add-on reads `describe`, `api`, `back` and modules that know nothing of models. Each other
# module of the core that it reads is a word of its row: shorter is better.
OPEN = {"describe", "api", "back", "system", "record", "source", "limits", "version"}
READ = {
    "bifurcation": """
        analysis.linear.equilibria analysis.linear.modes
        analysis.linear.symmetries analysis.linear.system cli.arguments cli.compilation compiler
        plot.style run.ensemble run.library run.named run.simulate run.values
        scenes.compile_plan scenes.run_settings scenes.scene
    """,
    "editor": """
        cli.messages compiler front.check.check front.check.names front.check.shared
        front.check.values front.joints front.lexed front.lexer front.parse front.read
        front.shapes front.statements front.table front.units front.words indices methods
        scenes.check tree
    """,
    "enclose": """
        cli.compilation compiler equations front.check.scene_numbers functions
        graph.differentiate graph.graph graph.substitute graph.written indices
        middle.jacobians middle.refused run.named run.values scenes.compile_plan scenes.options
        scenes.run_settings scenes.scene
    """,
    "film": """
        cli.arguments cli.compilation compiler equations plot.names plot.style run.ensemble
        run.library run.named run.settings run.simulate run.values scenes.run
    """,
    "fit": """
        analysis.sensitivity.forward analysis.sensitivity.tape cli.arguments cli.compilation
        cli.pictures compiler front.data plot.style run.library run.named run.values
        scenes.lengths
    """,
    "fmu": "front.units",
    "hosts": "graph.graph methods",
    "linear": """
        analysis.linear.equilibria analysis.linear.modes analysis.linear.newton
        analysis.linear.system cli.arguments cli.compilation cli.messages cli.pictures
        compiler plot.draw plot.names plot.picture plot.style plot.terminal run.named
        run.values scenes.compile_plan
    """,
    "optimise": """
        analysis.sensitivity.forward analysis.sensitivity.tape cli.arguments cli.compilation
        cli.pictures compiler graph.graph plot.style run.library run.named run.values
        scenes.lengths
    """,
    "pages": """
        analysis.chart.chart analysis.chart.table analysis.chart.text analysis.stability.map
        analysis.stability.text compiler equations explain.contents explain.explain
        explain.flat explain.families explain.rows explain.scenes front.parse front.statements
        front.table front.words graph.differentiate graph.graph indices
        middle.analyze.sympy_bridge
        middle.families.indexed_ir middle.families.equations middle.quantities
        middle.structure model plot.compose plot.draw plot.names plot.style plot.table plot.view
        run.diagnostics_text run.named
        tree
    """,
    "peers": """
        analysis.chart.answer analysis.chart.errors analysis.chart.rows
        analysis.chart.measure analysis.chart.points analysis.chart.spectrum
        analysis.chart.sweep compiler functions graph.differentiate graph.graph
        graph.written middle.jacobians run.build
    """,
    "robots": "compiler front.read front.words",
    "sweep": """
        cli.arguments cli.compilation compiler defaults equations front.check.expects
        front.check.options_text front.read methods model plot.draw plot.picture plot.view
        run.build run.diagnostics run.ensemble run.header run.library run.named run.rows
        run.settings run.values scenes.compile_plan scenes.expects
    """,
    "web": "cli.arguments cli.compilation cli.explain cli.messages middle.refused",
}


def _read_by(addon: Path) -> set[str]:
    """Modules of the core that an add-on imports, without those of OPEN."""
    found = set()
    for path in addon.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and not node.level:
                inner = {f"{node.module}.{alias.name}" for alias in node.names}
                found |= inner & MODULES.keys() or {node.module} & MODULES.keys()
    return {name.removeprefix("pkgen.") for name in found if name.split(".")[1] not in OPEN}


@pytest.mark.needs_addon
def test_addons_read_what_is_listed() -> None:
    folders = {path.parent.name: path for path in (ROOT / "addons").glob("*/pkgen_*")}
    assert {name: _read_by(path) for name, path in folders.items()} == {
        name: set(READ.get(name, "").split()) for name in folders
    }
