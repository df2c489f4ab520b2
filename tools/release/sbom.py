"""What a wheel of pkgen holds and needs, as a bill of materials (CycloneDX 1.6, JSON).

It is made of the wheel: its digest, the distributions that its metadata asks for, and HELD, what of
others' lies in it. The same wheel gives the same bytes.
"""

from __future__ import annotations

import hashlib
import uuid
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timezone
from email import message_from_bytes
from pathlib import Path

from cyclonedx.model import HashAlgorithm, HashType, Property
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentScope, ComponentType
from cyclonedx.model.license import DisjunctiveLicense, LicenseAcknowledgement
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL
from packaging.requirements import Requirement


@dataclass(frozen=True)
class Held:
    """Something of others in the wheel: where, and under which licence."""

    folder: str
    name: str
    version: str
    licence: str  # SPDX
    purl: PackageURL


HELD = (
    Held(
        "pkgen_web/vendor/",
        "uplot",
        "1.6.32",
        "MIT",
        PackageURL("npm", name="uplot", version="1.6.32"),
    ),
    Held(
        "pkgen_pages/explain/fonts/",
        "STIX Math",
        "1.1.1",
        "OFL-1.1",
        PackageURL("deb", "debian", "fonts-stix", "1.1.1-4.1"),
    ),
)
# What a machine has, or not: the first two to run a model, GSL for what is named after it.
MACHINE = (
    ("c-compiler", "", ComponentScope.REQUIRED),
    ("ar", "", ComponentScope.REQUIRED),
    ("gsl", "GPL-3.0-or-later", ComponentScope.OPTIONAL),
)


def _licence(name: str) -> list[DisjunctiveLicense]:
    declared = LicenseAcknowledgement.DECLARED
    return [DisjunctiveLicense(id=name, acknowledgement=declared)] if name else []


def _sha256(data: bytes) -> HashType:
    return HashType(alg=HashAlgorithm.SHA_256, content=hashlib.sha256(data).hexdigest())


def _held(archive: zipfile.ZipFile) -> Iterator[Component]:
    for one in HELD:
        files = [name for name in sorted(archive.namelist()) if name.startswith(one.folder)]
        yield Component(
            name=one.name,
            version=one.version,
            type=ComponentType.LIBRARY,
            bom_ref=f"held:{one.name}",
            purl=one.purl,
            licenses=_licence(one.licence),
            properties=[Property(name="pkgen:holds", value=name) for name in files],
        )


def _needed(metadata: bytes) -> Iterator[Component]:
    """The distributions that pip brings, those of extras as optional ones."""
    found: dict[str, list[Requirement]] = {}
    for text in message_from_bytes(metadata).get_all("Requires-Dist", ()):
        requirement = Requirement(text)
        if requirement.name != "pkgen-lag":  # an extra that has another
            found.setdefault(requirement.name.lower(), []).append(requirement)
    for name, requirements in sorted(found.items()):
        always = any(r.marker is None for r in requirements)
        yield Component(
            name=name,
            type=ComponentType.LIBRARY,
            bom_ref=f"needed:{name}",
            purl=PackageURL("pypi", name=name),
            scope=ComponentScope.REQUIRED if always else ComponentScope.OPTIONAL,
            properties=[Property(name="pkgen:requires", value=str(r)) for r in requirements],
        )


def _of_the_machine() -> Iterator[Component]:
    for name, licence, scope in MACHINE:
        yield Component(
            name=name,
            type=ComponentType.APPLICATION
            if scope is ComponentScope.REQUIRED
            else ComponentType.LIBRARY,
            bom_ref=f"machine:{name}",
            licenses=_licence(licence),
            scope=scope,
        )


def bill(wheel: Path, epoch: int) -> str:
    data = wheel.read_bytes()
    with zipfile.ZipFile(wheel) as archive:
        (metadata,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
        text = archive.read(metadata)
        held = [*_held(archive)]
    head = message_from_bytes(text)
    whole = Component(
        name="pkgen",
        version=head["Version"],
        description=head["Summary"],
        type=ComponentType.APPLICATION,
        bom_ref="pkgen",
        licenses=_licence("MIT"),
        hashes=[_sha256(data)],
    )
    parts = [*held, *_needed(text), *_of_the_machine()]
    bom = Bom(components=parts, serial_number=uuid.uuid5(uuid.NAMESPACE_OID, _sha256(data).content))
    bom.metadata.component = whole
    bom.metadata.timestamp = datetime.fromtimestamp(epoch, timezone.utc)
    bom.register_dependency(whole, parts)
    return JsonV1Dot6(bom).output_as_string(indent=2) + "\n"


def written(wheel: Path, epoch: int) -> Path:
    """The bill beside its wheel."""
    name, version, *_ = wheel.name.split("-")
    path = wheel.with_name(f"{name}-{version}.cdx.json")
    path.write_text(bill(wheel, epoch), encoding="utf-8")
    return path
