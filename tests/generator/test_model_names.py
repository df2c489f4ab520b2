"""Any name that a model may have links with the driver that `pkgen run` puts around it."""

import subprocess
from pathlib import Path

from conftest import ROOT, case, ran
from pkgen.run.build import runtime_library
from pkgen.system.toolchain import find_toolchain

# Between them these have every kind of function.
SWITCHED = case("switched")
MODELS = (
    ("chains/fput", ()),
    ("pendulums/foucault", ("--canonical",)),
    ("particles/projectile", ()),
    ("heavy_top", ("--canonical",)),
)
SYSTEM = ["-std=c99", "-DPK_RUNTIME", f"-I{ROOT / 'runtime/include'}"]


def exported(path: Path) -> set[str]:
    done = subprocess.run(["nm", "-g", "--defined-only", path], capture_output=True, text=True)
    words = [line.split() for line in done.stdout.splitlines()]
    return {word[2] for word in words if len(word) == 3 and word[1].isupper()}


def test_no_model_can_have_a_symbol_of_the_driver(tmp_path: Path) -> None:
    (tmp_path / "switched.lag").write_text(SWITCHED)
    endings = set()
    for model, options in ((tmp_path / "switched", ()), *MODELS):
        ran((ROOT / "models" / model).with_suffix(".lag"), "--runtime", *options, "-o", tmp_path)
        name = Path(model).name
        command = ["gcc", *SYSTEM, "-c", f"{name}.c"]
        subprocess.run(command, cwd=tmp_path, check=True)
        symbols = exported(tmp_path / f"{name}.o")
        assert all(symbol.startswith(f"{name}_") for symbol in symbols)
        endings |= {symbol[len(name) :] for symbol in symbols}
    assert {"_system", "_start", "_energy", "_events", "_switching", "_attach"} <= endings
    driver = exported(runtime_library(find_toolchain()) / "librun.a")
    driver = {symbol for symbol in driver if not symbol.startswith("pk_")} | {"run_model"}
    assert len(driver) > 100
    assert not [symbol for symbol in driver if symbol.endswith(tuple(endings))]


def test_models_named_as_parts_of_the_driver_run(tmp_path: Path) -> None:
    for name in ("run", "apart", "choice", "features"):
        path = tmp_path / f"{name}.lag"
        path.write_text(f"model {name}\ncoord x\nkinetic x'^2/2\npotential x^4\nstart x = 1\n")
        ran("run", path, "--until", "1", "-o", tmp_path / "rows.csv")
