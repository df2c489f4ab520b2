"""`pkgen export`: exports a model for other programs (hosts). Add-ons define the hosts."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

from ..back.exported import Exported, Host
from ..describe.page_data import describe
from ..middle.refused import refuse_statements
from ..system import addons
from ..system.exits import UsageError
from ..system.files import replace
from ..system.near import near
from . import arguments as shared
from .compilation import compile_within_limits
from .messages import findings

EXAMPLES = """
pkgen export models/double_pendulum.lag --as fmu
pkgen export models/heavy_top.lag --as source --scene nutation -o top
"""


@cache
def hosts() -> dict[str, Host]:
    """Returns the hosts of the installed add-ons, by name."""
    return {name: addons.load("exports", name) for name in addons.here("exports")}


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    add = parser.add_argument
    add("--as", dest="host", metavar="NAME", help="what it is made for; the list is below")
    add("-o", dest="path", metavar="PATH", help="a folder, or a file where there is one")
    shared.of_a_motion(parser)
    add("--method", metavar="NAME", help="what integrates it unless its user chooses another")
    add("--step", metavar="H", help="of a method with fixed steps")
    shared.tolerance(parser)
    shared.own_methods(parser)
    for flag, having in _flags().items():
        how = dict(having[0].options)[flag]
        names = ", ".join(host.name for host in having)
        add(flag, **{**how, "default": None, "help": f"{how['help']} ({names})"})
    parser.epilog = "\n".join(["hosts:", *_listed()])


def _listed() -> Iterator[str]:
    for host in hosts().values():
        tools = f"; needs {host.tools}" if host.tools else ""
        yield f"  {host.name:12} {host.doc}{tools}"


def _flags() -> dict[str, list[Host]]:
    """Returns, for each option of hosts, the hosts that have it."""
    found: dict[str, list[Host]] = {}
    for host in hosts().values():
        for flag, _ in host.options:
            found.setdefault(flag, []).append(host)
    return found


def run(options: argparse.Namespace) -> None:
    """Write the files that another program needs to use the model: C, interface, description."""
    host = _host(options)
    found = describe(
        options,
        lambda options, **how: compile_within_limits(options, **how, **host.how(options)),
        draw=host.drawing,
    )
    made = found.compilation
    refuse_statements(made.declared, "pkgen export")
    made.declared.refuse_long("pkgen export")
    model = Exported(
        made.model.name,
        found.description,
        made.files,
        made.structure.separable,
        made.model.methods,
        options,
        made.program,
    )
    files = _placed(host, model.name, host.make(model), options.path)
    for line in host.warnings(model):
        findings(f"{options.model}: warning: {line[0].lower()}{line[1:].rstrip('.')}")
    for folder in {path.parent for path in files}:
        folder.mkdir(parents=True, exist_ok=True)
    replace(files)
    if options.json:
        print(json.dumps({"files": [str(path) for path in files]}))
        return
    size = math.ceil(sum(map(len, files.values())) / 1000)
    shown = next(iter(files)) if host.suffix else f"{_folder(host, model.name, options.path)}/"
    count = "" if host.suffix else f"{len(files)} files, "
    print(f"{shown}: {count}{size} kB")


def _host(options: argparse.Namespace) -> Host:
    """Returns the host of --as. Raises UsageError if it is unknown or lacks a given option."""
    if options.host is None:
        raise UsageError("--as: name what it is made for:\n" + "\n".join(_listed()))
    if options.host not in hosts():
        if options.host in addons.points("exports"):
            addons.load("exports", options.host)  # Raises UsageError if the add-on is missing.
        raise UsageError(f"--as {options.host}: {near(options.host, list(hosts()), 'host')}")
    host = hosts()[options.host]
    for flag, having in _flags().items():
        if getattr(options, flag[2:].replace("-", "_")) is not None and host not in having:
            names = " or ".join(other.name for other in having)
            raise UsageError(f"{flag}: this is of --as {names}, not of --as {host.name}")
    return host


def _folder(host: Host, name: str, path: str | None) -> Path:
    return Path(path or f"{name}-{host.name}")


def _placed(
    host: Host, name: str, made: Mapping[str, bytes], path: str | None
) -> dict[Path, bytes]:
    """Returns the exported files by path. `path` is a folder; for a host that writes a single file,
    it may be the file. Raises UsageError."""
    if not host.suffix:
        folder = _folder(host, name, path)
        if folder.exists() and not folder.is_dir():
            raise UsageError(f"-o {folder}: this is a file; give a folder")
        return {folder / file: data for file, data in made.items()}
    ((file, data),) = made.items()
    if path is None:
        return {Path(file): data}
    if path.endswith(host.suffix) and not Path(path).is_dir():
        return {Path(path): data}
    if Path(path).suffix and not Path(path).is_dir():
        raise UsageError(f"-o {path}: the file's name must end in {host.suffix}")
    return {Path(path) / file: data}
