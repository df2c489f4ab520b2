"""pkgen: a compiler from Lagrangians to C. `compiler.py` is its architecture on one page.

>>> import pkgen
>>> m = pkgen.load("models/double_pendulum.lag")
>>> m.params["m1"] = "2 [kg]"
>>> r = m.run(until=20, every=0.01)
>>> r["theta1"].shape
(2001,)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .version import __version__

if TYPE_CHECKING:
    from .api.errors import BuildError, ModelError, NumericsFailed, RunError, UsageError
    from .api.model import Model, load
    from .api.result import Result


__all__ = [
    "BuildError",
    "Model",
    "ModelError",
    "NumericsFailed",
    "Result",
    "RunError",
    "__version__",
]
__all__ += ["UsageError", "load"]

_HOMES = {"load": "model", "Model": "model", "Result": "result"}


def __dir__() -> list[str]:
    return sorted(__all__)


def __getattr__(name: str) -> object:
    """Imports the API at its first use, since the command line does not need it."""
    if name not in __all__:
        raise AttributeError(f"module 'pkgen' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f".api.{_HOMES.get(name, 'errors')}", __name__), name)
