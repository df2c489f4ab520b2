"""Writes modelDescription.xml of FMI 2 and 3, and buildDescription.xml."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from xml.etree import ElementTree as xml

from pkgen.back.exported import Exported
from pkgen.front.units import BASE, UnitError, parse_unit

from .variables import Described, Variable, indicators

LOG = {
    "logStatusError": "what is refused, and why",
    "logStatusDiscard": "where the motion or its equations end",
    "logEvents": "events of the model, with their times",
}
METHODS = "Method"  # XML name of the enumeration of methods


def _text(root: xml.Element) -> str:
    xml.indent(root, " ")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{xml.tostring(root, encoding="unicode")}\n'


def _add(parent: xml.Element, tag: str, **attributes: object) -> xml.Element:
    """Adds and returns an element; omits attributes that are None or ""."""
    said = {k: _said(v) for k, v in attributes.items() if v not in (None, "")}
    return xml.SubElement(parent, tag, said)


def _said(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    text = repr(value) if isinstance(value, float) else str(value)
    return " ".join(text.split())


def _head(model: Described, **more: object) -> xml.Element:
    root = xml.Element("fmiModelDescription")
    attributes = {
        **more,
        "modelName": model["model"],
        "description": model["description"],
        "version": model["sha256"][:12],
        "license": "model: its author's; runtime: MIT",
        "generationTool": f"pkgen {model['pkgen']}",
        "variableNamingConvention": "flat",
    }
    root.attrib.update({k: _said(v) for k, v in attributes.items() if v != ""})
    return root


def _units(root: xml.Element, variables: Iterable[Variable], bases: Mapping[str, str]) -> None:
    names = dict.fromkeys(v.unit for v in variables if v.unit)
    if not names:
        return
    definitions = _add(root, "UnitDefinitions")
    for name in names:
        unit = _add(definitions, "Unit", name=name)
        try:
            found = parse_unit(name)
        except UnitError:
            continue
        exponents = dict(zip(BASE, found.dimension, strict=True)) | {"rad": found.angle}
        if all(Fraction(e).denominator == 1 for e in exponents.values()):
            _add(unit, "BaseUnit", **{bases.get(b, b): int(e) for b, e in exponents.items() if e})


def _categories(root: xml.Element) -> None:
    categories = _add(root, "LogCategories")
    for name, about in LOG.items():
        _add(categories, "Category", name=name, description=about)


def _experiment(root: xml.Element, model: Described) -> None:
    run = model["run"]
    step = run["step"] or run["every"]
    _add(root, "DefaultExperiment", startTime=0.0, stopTime=run["until"], tolerance=run["rtol"],
         stepSize=step)  # fmt: skip


def _variability(v: Variable) -> str | None:
    return ("fixed" if v.fixed else "tunable") if v.causality == "parameter" else None


def _initial(v: Variable) -> str | None:
    return "exact" if v.causality == "output" and v.start is not None else None


def fmi3(exported: Exported, variables: Sequence[Variable], token: str) -> str:
    model = exported.description
    root = _head(model, fmiVersion="3.0", instantiationToken=token)
    both = {
        "modelIdentifier": model["model"],
        "canGetAndSetFMUState": True,
        "canSerializeFMUState": True,
        "providesDirectionalDerivatives": True,
        "providesAdjointDerivatives": True,
    }
    told = bool(indicators(model) or model["constraints"] or model["rotations"])
    _add(root, "ModelExchange", **both, needsCompletedIntegratorStep=told)
    _add(
        root, "CoSimulation", **both, canHandleVariableCommunicationStepSize=True,
        providesIntermediateUpdate=True, canReturnEarlyAfterIntermediateUpdate=True,
        mightReturnEarlyFromDoStep=any(e["stop"] for e in model["events"]),
    )  # fmt: skip
    _units(root, variables, {})
    types = _add(_add(root, "TypeDefinitions"), "EnumerationType", name=METHODS)
    for k, m in enumerate(exported.methods(), 1):
        _add(types, "Item", name=m["name"], value=k, description=m["doc"])
    _categories(root)
    _experiment(root, model)
    listed = _add(root, "ModelVariables")
    for v in variables:
        same = {"name": v.name, "valueReference": v.reference, "description": v.description}
        same |= {"causality": v.causality, "variability": _variability(v)}
        if v.kind == "method":
            _add(listed, "Enumeration", **same, declaredType=METHODS, start=v.start)
            continue
        _add(
            listed, "Float64", **same, unit=v.unit, initial=_initial(v), start=v.start, min=v.lo,
            max=v.hi, derivative=v.derivative,
            intermediateUpdate=True if v.causality == "input" else None,
        )  # fmt: skip
    structure = _add(root, "ModelStructure")
    for tag, found in _structure(variables).items():
        for _, v in found:
            _add(structure, tag, valueReference=v.reference)
    return _text(root)


def _structure(variables: Sequence[Variable]) -> dict[str, list[tuple[int, Variable]]]:
    """Returns, for each XML tag in ModelStructure, its variables as (position counted from 1,
    variable)."""
    each = list(enumerate(variables, 1))
    return {
        "Output": [(k, v) for k, v in each if v.causality == "output"],
        "ContinuousStateDerivative": [(k, v) for k, v in each if v.derivative is not None],
        "InitialUnknown": [
            (k, v)
            for k, v in each
            if (v.causality == "output" and v.start is None) or v.derivative is not None
        ],
        "EventIndicator": [(k, v) for k, v in each if v.kind == "indicator"],
    }


def fmi2(
    exported: Exported, variables: Sequence[Variable], token: str, sources: Iterable[str]
) -> str:
    model = exported.description
    count = len(indicators(model))
    root = _head(model, fmiVersion="2.0", guid=token, numberOfEventIndicators=count)
    for tag in ("ModelExchange", "CoSimulation"):
        both = {
            "modelIdentifier": model["model"],
            "canNotUseMemoryManagementFunctions": True,
            "canGetAndSetFMUstate": True,
            "canSerializeFMUstate": True,
            "providesDirectionalDerivative": True,
        }
        if tag == "CoSimulation":
            both |= {"canHandleVariableCommunicationStepSize": True, "canInterpolateInputs": True}
        files = _add(_add(root, tag, **both), "SourceFiles")
        for path in sources:
            _add(files, "File", name=path)
    # FMI 2 has no variables for derivatives of inputs, event indicators and time.
    variables = [v for v in variables if v.reference and v.kind not in ("slope", "indicator")]
    _units(root, variables, {})
    simple = _add(_add(root, "TypeDefinitions"), "SimpleType", name=METHODS)
    types = _add(simple, "Enumeration")
    for k, m in enumerate(exported.methods(), 1):
        _add(types, "Item", name=m["name"], value=k, description=m["doc"])
    _categories(root)
    _experiment(root, model)
    listed = _add(root, "ModelVariables")
    place = {v.reference: k for k, v in enumerate(variables, 1)}
    for v in variables:
        item = _add(
            listed, "ScalarVariable", name=v.name, valueReference=v.reference,
            description=v.description, causality=v.causality, variability=_variability(v),
            initial=_initial(v),
        )  # fmt: skip
        if v.kind == "method":
            _add(item, "Enumeration", declaredType=METHODS, start=v.start)
            continue
        derivative = place.get(v.derivative or 0)
        _add(item, "Real", unit=v.unit, start=v.start, min=v.lo, max=v.hi, derivative=derivative)
    structure = _add(root, "ModelStructure")
    found = _structure(variables)
    for tag, unknowns in (
        ("Outputs", found["Output"]),
        ("Derivatives", found["ContinuousStateDerivative"]),
        ("InitialUnknowns", found["InitialUnknown"]),
    ):
        if unknowns:
            group = _add(structure, tag)
            for k, _ in unknowns:
                _add(group, "Unknown", index=k)
    return _text(root)


def build(name: str, sources: Iterable[str]) -> str:
    """Returns buildDescription.xml: the files to compile, and the library to link."""
    root = xml.Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    configuration = _add(root, "BuildConfiguration", modelIdentifier=name)
    files = _add(configuration, "SourceFileSet", language="C11")
    for path in sources:
        _add(files, "SourceFile", name=path)
    _add(configuration, "Library", name="m", external=True)
    return _text(root)
