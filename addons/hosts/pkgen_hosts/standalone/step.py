"""Writes C for the step of one method with the kernels of one model, without the runtime."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pkgen.back.c.render import pasted
from pkgen.back.exported import Exported
from pkgen.back.host.data import states
from pkgen.back.templates import filled
from pkgen.methods import known
from pkgen.system.exits import UsageError
from pkgen.version import __version__

from .coefficients import table
from .plain import plain

HERE = Path(__file__).parent / "templates"
FAMILIES = {"ERK": "erk", "SPLITTING": "splitting"}
KERNELS = frozenset(("acceleration", "energy", "observe"))
_FIELD = re.compile(r"offsetof\(struct \w+, (\w+)\)(?: \+ (\d+) \* sizeof\(pk_real\))?")
_SINCOS = re.compile(r"#ifndef PK_SINCOS_H.*?\n#endif\n(?=\n[a-z])", re.DOTALL)
_CALLED = re.compile(r"\bPK_F\((\w+)\)")
# Compilers make one instruction of each of these functions, so they need no libm.
INSTRUCTIONS = {"fabs", "fma", "sqrt"}


class Step:
    """The C of a step. Raises UsageError if the export does not support the method or the model."""

    def __init__(self, model: Exported, scalar: str, *, has_main: bool = False):
        self.model = model
        # whether to write a main(); it ends the run at an event that stops the motion
        self.has_main = has_main
        self.of = model.description
        self.name = model.name
        self.float = (model.options.scalar or scalar) == "float"
        self.bounded = bool(model.options.no_libm)
        self.method = self._method()
        self._refuse()

    def _method(self) -> dict[str, Any]:
        run = self.of["run"]
        own = known(self.model.own)
        offered = {m["name"]: m for m in self.of["methods"]}
        name = run["method"]
        # With linear drag, splitting methods need an exponential, which this export lacks.
        families = {f for f in FAMILIES if f != "SPLITTING" or self.model.separable}
        fitting = [m["name"] for m in self.model.methods() if own[m["name"]].family in families]
        if name not in fitting:
            given = f"--method {name}" if self.model.options.method else f"the method {name}"
            why = "is not one of fixed explicit steps, which this export has alone"
            if not offered[name]["gsl"] and own[name].family in FAMILIES:
                why = (
                    "needs the exponential of the forces' rates here, which this export is without"
                )
            raise UsageError(f"{given} {why}; give --method: {', '.join(fitting)}")
        if not run["step"]:
            raise UsageError(f"method {name} has a fixed step: give it by --step H")
        return offered[name]

    def _refuse(self) -> None:
        parts = {
            "constraints": self.of["constraints"],
            "rotations": self.of["rotations"],
        }
        for what, there in parts.items():
            if there:
                raise UsageError(
                    f"{self.name} has {what}, whose steps end with a projection that this export "
                    "is without; --as source has all of the runtime"
                )
        if self.of["looped"]:
            raise UsageError(f"{self.name} is too large to be written out; --as source has loops")
        header, source = self.model.files[f"{self.name}.h"], self.model.files[f"{self.name}.c"]
        if self.float and "#error" in header:
            raise UsageError(f"{self.name} has constants that float cannot hold: --scalar double")
        if self.bounded:
            called = sorted({*_CALLED.findall(_SINCOS.sub("", source))} - INSTRUCTIONS)
            if called:
                raise UsageError(
                    f"--no-libm: {self.name} calls {', '.join(called)}, "
                    "which the C library has; without --no-libm it may"
                )

    @property
    def header(self) -> str:
        return self._text(self.model.files[f"{self.name}.h"], "#include <stddef.h>\n")

    @property
    def source(self) -> str:
        return plain(self.model.files[f"{self.name}.c"], {"PK_RUNTIME": False})

    def _text(self, text: str, at: str) -> str:
        """Returns the text of a header; macros that this export needs are defined before the line
        `at`."""
        defined = "".join(
            f"#ifndef {name}\n#define {name} /* {why} */\n#endif\n"
            for name, why, there in (
                ("PK_FLOAT", "the scalar type", self.float),
                ("PK_BOUNDED_ANGLES", "no libm: see NAME_step()", self.bounded),
            )
            if there
        )
        text = plain(text, {"PK_RUNTIME": False})
        return (
            text.replace(at, defined.replace("NAME", self.name) + "\n" + at, 1) if defined else text
        )

    def step_header(self, include: str) -> str:
        return filled(HERE, "step.h.j2", header=include, **self._context())

    @property
    def step_source(self) -> str:
        known_here = {"PK_WITHOUT_RUNTIME": True}
        texts = {
            key: _pasted(f"step/{header}.h", known_here)
            for key, header in (
                ("numbers", "numbers"),
                ("tableau", "tableau"),
                ("evaluate", "evaluate"),
                ("family", FAMILIES[self.family]),
            )
        }
        name = self.method["name"]
        return filled(
            HERE,
            "step.c.j2",
            **texts,
            table=table(name, self.model.own),
            call=FAMILIES[self.family],
            work=self.family == "ERK",
            parameters=list(self._parameters()),
            given=self._given(),
            starts=list(self._starts()),
            inputs=[self.number(u["value"]) for u in self.of["inputs"]],
            **self._context(),
        )

    @property
    def family(self) -> str:
        return known(self.model.own)[self.method["name"]].family

    def _context(self) -> dict[str, object]:
        return {
            "name": self.name,
            "version": __version__,
            "method": self.method["name"],
            "doc": self.method["doc"],
            "calls": self.method["stages"],
            "step": self.number(self.of["run"]["step"]),
            "n_inputs": len(self.of["inputs"]),
            "n_q": len(self.of["coordinates"]),
            "libm": not self.bounded,
            "notes": self.notes,
        }

    def _events(self, *, stop: bool) -> str:
        return ", ".join(event["name"] for event in self.of["events"] if event["stop"] is stop)

    @property
    def stops(self) -> bool:
        """Whether main() detects events."""
        return self.has_main and bool(self._events(stop=True))

    @property
    def missed(self) -> list[str]:
        """Returns descriptions of those differences from `pkgen run` that change the motion."""
        found = []
        if not self.has_main and self._events(stop=True):
            found.append(f"Nothing stops at {self._events(stop=True)}, where pkgen run does.")
        if " side_[" in self.model.files[f"{self.name}.h"]:
            found.append(
                "Steps do not end where step, abs, min or max change the equations; one across "
                "loses the order of the method."
            )
        return found

    @property
    def notes(self) -> list[str]:
        """Returns all differences from `pkgen run`."""
        found = self.missed
        if self.stops:
            found.append(f"A step looks for no events; main() ends at: {self._events(stop=True)}.")
        if self._events(stop=False):
            found.append(f"Events are not looked for: {self._events(stop=False)}.")
        return found

    def number(self, value: float) -> str:
        text = repr(float(value))
        return f"-PK_C({text[1:]})" if text.startswith("-") else f"PK_C({text})"

    @property
    def _chosen(self) -> bool:
        options = self.model.options
        return bool(options.scene or options.set or options.start)

    def _parameters(self) -> Iterator[str]:
        fields = _FIELD.findall(self.model.files[f"{self.name}.c"])
        _, _, after = self.model.files[f"{self.name}.h"].partition(f"struct {self.name}_params {{")
        declared, _, _ = after.partition("};")
        for item in self.of["parameters"]:
            if self._chosen and not item["follows"] and item["value"] is not None:
                field, position = fields[item["index"]]
                at = f"[{position}]" if f" {field}[" in declared else ""
                yield f"m->p.{field}{at.replace('[]', '[0]')} = {self.number(item['value'])};"

    def _given(self) -> list[int]:
        if not self._chosen:
            return []
        return [int(not item["follows"]) for item in self.of["parameters"]]

    def _starts(self) -> Iterator[str]:
        if not self._chosen:
            return
        for place, item in places(self.of):
            if not item["follows"] and item["value"] is not None:
                yield f"m->{place} = {self.number(item['value'])};"


def places(of: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    """Returns, for each state variable, the C of its member of `struct NAME_motion`, and its
    description."""
    n_q = len(of["coordinates"])
    return [(f"q[{k}]" if k < n_q else f"v[{k - n_q}]", y) for k, y in enumerate(states(of))]


def _pasted(header: str, conditions: dict[str, bool]) -> str:
    """Returns the text of a runtime header without the comment at its top, its include guard and
    its includes of <pk/...>."""
    text = plain(pasted(header), conditions)
    text = re.sub(r"^#include <pk/[^\n]*\n", "", text, flags=re.MULTILINE)
    guard = re.search(r"^#ifndef (PK_\w+_H)\n#define \1\n", text, re.MULTILINE)
    if guard:
        text = text.replace(guard[0], "", 1)
        text = text[: text.rindex("#endif")]
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"
