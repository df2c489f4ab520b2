"""Reproducible zip archives: the same entries give the same bytes."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping


def archive(entries: Mapping[str, bytes]) -> bytes:
    """Returns a zip file of the entries, sorted by path and without dates."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        for path in sorted(entries):
            info = zipfile.ZipInfo(path)
            info.external_attr = 0o644 << 16
            info.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(info, entries[path])
    return packed.getvalue()
