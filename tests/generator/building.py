"""Models of the parts that a test gives: their text, checked."""

from collections.abc import Mapping, Sequence

from pkgen.front.check.check import check_text
from pkgen.middle.reduce.reduction import Needs
from pkgen.model import Model
from pkgen.plan import Use
from pkgen.record import record
from pkgen.source import Source

DEFINED = {"lets": "let", "forces": "force"}
DEFINED |= {"observed": "observe", "conserved": "conserve", "starts": "start"}


def model(name: str = "test", **parts: str | Sequence[str] | Mapping[str, object]) -> Model:
    """Sizes, coordinates, `ends` and `inputs`; energies, of each one or several; `DEFINED` parts
    by name."""
    lines = [f"model {name}", *(f"size {n} = {x}" for n, x in parts.pop("sizes", {}).items())]
    lines += [f"param {n} = {x}" for n, x in parts.pop("params", {}).items()]
    for word, part in (("coord", "coords"), ("input", "inputs")):
        lines += [f"{word} {', '.join(names)}" for names in [parts.pop(part, ())] if names]
    lines += parts.pop("ends", ())
    for part, given in parts.items():
        if part in DEFINED:
            lines += [f"{DEFINED[part]} {n} = {x}" for n, x in given.items()]
        else:
            lines += [f"{part} {x}" for x in ([given] if isinstance(given, str) else given)]
    return check_text(Source(f"{name}.lag", "\n".join(lines) + "\n"))[0]


def links(count: int, own: bool = False, name: str = "links") -> Model:
    return model(name, **parts_of_links(count, own))


def parts_of_links(count: int, own: bool = False) -> dict[str, object]:
    """The pendulum of N links; with `own`, each link has a mass and a length of its own."""
    m, length, of = ("m[k]", "l[k]", "[k=1..N]") if own else ("m", "l", "")
    return dict(
        sizes={"N": count},
        params={f"m{of}": 1.3, f"l{of}": 0.7, "g": 9.81},
        coords=("theta[1..N]",),
        lets={
            "x[0]": "0",
            "y[0]": "0",
            "x[k=1..N]": f"x[k-1] + {length}*sin(theta[k])",
            "y[k=1..N]": f"y[k-1] - {length}*cos(theta[k])",
        },
        kinetic=f"sum({m}/2*(x[k]'^2 + y[k]'^2), k = 1..N)",
        potential=f"sum({m}*g*y[k], k = 1..N)",
    )


@record(kw_only=True)
class Needing(Use):
    """The whole model, of which these columns alone are needed."""

    columns: frozenset[str]

    def needs(self, used: Model) -> Needs:
        return Needs(self.columns)
