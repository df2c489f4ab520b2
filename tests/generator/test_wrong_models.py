"""Wrong models and exactly what is said about them.

`wrong/NAME.lag` is a model, `wrong/NAME.txt` what pkgen says. PKGEN_UPDATE=1 writes the latter
anew; read the difference before you keep it.
"""

import os
from pathlib import Path

import pytest

from pkgen.compiler import check_model
from pkgen.front.read import from_text, read
from pkgen.source import ModelError

MODELS = sorted(Path(__file__).with_name("wrong").glob("*.lag"))
USERS = sorted(Path(__file__).with_name("wrong").glob("parts/*.lag"))


def said_about(path: Path) -> str:
    source = from_text(path.name, path.read_text(encoding="utf-8"))
    here = os.getcwd()
    os.chdir(path.parent)  # the data of tables are beside the model
    try:
        with pytest.raises(ModelError) as caught:
            check_model(source)
    finally:
        os.chdir(here)
    return caught.value.text() + "\n"


def test_there_are_wrong_models():
    assert len(MODELS) > 50


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_message(path: Path):
    said = said_about(path)
    expected = path.with_suffix(".txt")
    if os.environ.get("PKGEN_UPDATE"):
        expected.write_text(said, encoding="utf-8")
    assert said == expected.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", USERS, ids=lambda path: path.stem)
def test_message_of_parts(path: Path, monkeypatch: pytest.MonkeyPatch):
    """The files of the parts are in `wrong/parts/files`."""
    monkeypatch.chdir(path.parent)
    with pytest.raises(ModelError) as caught:
        check_model(read(path.name))
    said, expected = caught.value.text() + "\n", path.with_suffix(".txt")
    if os.environ.get("PKGEN_UPDATE"):
        expected.write_text(said, encoding="utf-8")
    assert said == expected.read_text(encoding="utf-8")
    places = [caught.value.source.place(d.span) + d.message for d in caught.value.diagnostics]
    assert len(set(places)) == len(places)


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_every_message_has_its_place(path: Path):
    """Each finding points into the file, and no two say the same at one place."""
    source = from_text(path.name, path.read_text(encoding="utf-8"))
    with pytest.raises(ModelError) as caught:
        check_model(source)
    places = [(d.message, d.span.start) for d in caught.value.diagnostics]
    assert len(set(places)) == len(places)
    for d in caught.value.diagnostics:
        assert 0 <= d.span.start <= d.span.end
        assert d.span.start <= len(source.text)
        assert d.message and not d.message.endswith(".")
