"""Files that a model or a plan names lie in its folder, or in one that --allow-path opens; the text
of any other is never shown."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import pkgen
from pkgen.__main__ import main

MODEL = "model p\ncoord a\nkinetic a'^2/2\npotential -cos(a)\nstart a = 1\n"
PLAN = 'until = 1\nmembers = 4\nstep = 0.1\ntableau = ["{}"]\n[random]\na = "0 .. 1"\n'
MODELS = {
    "model": MODEL + "method mine tableau {}\n",
    "scene": MODEL + "scene s\n until 1\n method mine tableau {} step 0.1\nend\n",
}
OF_SWEEP = pytest.mark.needs_addon("sweep")
SECRET = "s3cret-word"
EULER = "A\n0\nb 1\n"


def ways(tmp_path: Path, name: str) -> dict[str, str]:
    """Names of a file outside of the model's folder."""
    (tmp_path / "in" / "link").symlink_to(tmp_path / "out" / name)
    (tmp_path / "in" / "folder").symlink_to(tmp_path / "out")
    absolute = str(tmp_path / "out" / name)
    return {"up": f"../out/{name}", "whole": absolute, "link": "link", "folder": f"folder/{name}"}


@pytest.mark.parametrize("way", ["up", "whole", "link", "folder"])
@pytest.mark.parametrize("by", [*MODELS, pytest.param("plan", marks=OF_SWEEP)])
def test_no_file_outside_is_read(by: str, way: str, tmp_path, monkeypatch, capsys) -> None:
    for name in ("in", "out"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path / "in")
    (tmp_path / "out" / "x").write_text(f"{SECRET} 1\n")
    named = ways(tmp_path, "x")[way]
    Path("m.lag").write_text(MODELS.get(by, MODEL).format(named))
    Path("plan.toml").write_text(PLAN.format(named))
    sweep = ["sweep", "m.lag", "--plan", "plan.toml", "-o", "made"]
    reading = [sweep] if by == "plan" else [["check", "m.lag"], ["run", "m.lag"]]
    for words in reading:
        assert main(words) in (1, 2)
        said = capsys.readouterr().err
        assert "lies outside of the folder" in said and "--allow-path DIR" in said
        assert main([*words, "--allow-path", "../out"]) in (1, 2)
        said += capsys.readouterr().err
        assert ":1:1: this is no tableau" in said and SECRET not in said
        if way == "up":  # the error is the same where there is no such file
            os.rename("../out/x", "../out/y")
            assert main(words) in (1, 2)
            assert "lies outside of the folder" in capsys.readouterr().err
            os.rename("../out/y", "../out/x")
    (tmp_path / "out" / "x").write_text(EULER)
    for words in reading[:1]:
        assert main([*words, "--allow-path", "../out"]) == 0, capsys.readouterr().err
    if by != "plan":
        with pytest.raises(pkgen.ModelError):
            pkgen.load("m.lag")
        pkgen.load("m.lag", allow_path=[tmp_path / "out"])


@OF_SWEEP
@pytest.mark.parametrize("name", ["p.lag", "plan.toml"])
def test_a_sweep_that_comes_from_elsewhere_leads_nowhere(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("m.lag").write_text(MODEL)
    Path("plan.toml").write_text(PLAN.format("x").replace('tableau = ["x"]', 'method = "rk4"'))
    assert main(["sweep", "m.lag", "--plan", "plan.toml", "-o", "made"]) == 0
    Path("secret").write_text(SECRET)
    Path("made", name).unlink()
    Path("made", name).symlink_to("../secret")
    capsys.readouterr()
    assert main(["sweep", "--resume", "made"]) == 2
    said = capsys.readouterr().err
    assert "a link leads out of it" in said and SECRET not in said
