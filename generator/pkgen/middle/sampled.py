"""Inputs that sample blocks hold, and errors where something does not run sample blocks."""

from __future__ import annotations

from collections.abc import Iterable

from ..model import Model
from .quantities import error

AS_C = "the C of 'pkgen MODEL.lag' has NAME_BLOCK_sample(); 'pkgen build' makes a program"
AS_FORCE = "write the controller as a force for this: its motion goes on between the samples"
_INSTEAD = {
    "pkgen export": AS_C,
    "pkgen show": "'pkgen run' and 'pkgen film' do",
    "pkgen stability": AS_FORCE,
    "--enclose": AS_FORCE,
    "--diagnose": f"'spectrum' and 'area' alone are of its rows; {AS_FORCE}",
    "inputs": "in a model with sample blocks: --set \"d=sin(t)\", or 'set d = sin(t)' in a scene",
}
OF_ROWS = frozenset(("spectrum", "area"))  # diagnostics of motions with samples


def refuse_samples(model: Model, what: str) -> None:
    """Raises ModelError if the model has a sample block; `what` is a key of _INSTEAD."""
    for block in model.samples:
        message = f"{what} runs no sample block"
        if what == "inputs":
            message = "a function or a table is no input beside a sample block"
        raise error(model, message, block.head, _INSTEAD[what])


def refuse_diagnostics(model: Model, names: Iterable[str]) -> None:
    if {*names} - OF_ROWS:
        refuse_samples(model, "--diagnose")


def block_of(model: Model, name: str) -> str:
    """Returns the sample block that sets an input, or ""."""
    return next((item.by for item in model.inputs if item.name == name), "")
