"""The installed drivegate as a wheel, so that what is written today installs anywhere, and gives the same verdicts."""

from __future__ import annotations

import base64
import hashlib
import io
import zipfile
from collections.abc import Iterator
from importlib.metadata import distribution
from importlib.resources import files
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

_PACKAGES: Final = ("drivegate_models", "drivegate_cases", "drivegate", "drivegate_reports")
_METADATA: Final = ("METADATA", "WHEEL", "entry_points.txt", "licenses/LICENSE")
_EARLIEST: Final = (1980, 1, 1, 0, 0, 0)
"""The one time of every file: equal sources give equal bytes."""
_SHARED_FILE: Final = 0o100644 << 16


def wheel_name() -> str:
    """Name the wheel of the installed version."""
    return f"drivegate-{distribution('drivegate').version}-py3-none-any.whl"


def wheel_bytes() -> bytes:
    """Pack the four packages as they are installed, or as they lie in a working tree, into a wheel."""
    place = f"drivegate-{distribution('drivegate').version}.dist-info"
    contents = {f"{name}/{path}": data for name in _PACKAGES for path, data in _contents(files(name))}
    contents |= {
        f"{place}/{name}": text.encode()
        for name in _METADATA
        if (text := distribution("drivegate").read_text(name))
    }
    record = "".join(f"{path},{_digest(data)},{len(data)}\n" for path, data in sorted(contents.items()))
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for path, data in [
            *sorted(contents.items()),
            (f"{place}/RECORD", f"{record}{place}/RECORD,,\n".encode()),
        ]:
            entry = zipfile.ZipInfo(path, _EARLIEST)
            entry.external_attr = _SHARED_FILE
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED, 9)
    return packed.getvalue()


def _contents(folder: Traversable, prefix: str = "") -> Iterator[tuple[str, bytes]]:
    for entry in folder.iterdir():
        if entry.is_dir():
            if entry.name != "__pycache__":
                yield from _contents(entry, f"{prefix}{entry.name}/")
        elif not entry.name.endswith((".pyc", ".nbc", ".nbi")):
            yield f"{prefix}{entry.name}", entry.read_bytes()


def _digest(data: bytes) -> str:
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
