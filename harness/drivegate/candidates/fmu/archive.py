"""Unpacking an FMU, which is a zip archive from anywhere: within bounds, and nowhere but into its folder."""

import shutil
import stat
import zipfile
import zlib
from lzma import LZMAError
from pathlib import Path, PurePosixPath
from typing import Final

from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

MOST_FILES: Final = 10_000
"""Entries that an FMU may have."""
MOST_BYTES: Final = 512 * 2**20
"""Size that all its files may have together, unpacked."""

_DAMAGED: Final = (
    zipfile.BadZipFile,
    zlib.error,
    LZMAError,
    EOFError,
    NotImplementedError,
    OSError,
    RuntimeError,
    ValueError,
)


def unpack(file: Path, folder: Path, *, most_files: int = MOST_FILES, most_bytes: int = MOST_BYTES) -> None:
    """Unpack an FMU."""
    try:
        archive = zipfile.ZipFile(file)
    except _DAMAGED as error:
        raise InputError(
            f"{shown_path(file)} is no zip archive, which every FMU is; name a file that a tool exported as an FMU"
        ) from error
    with archive:
        entries = archive.infolist()
        _check_size(file, entries, most_files, most_bytes)
        for entry in entries:
            _check_name(file, entry)
        try:
            for entry in entries:
                _extract(archive, entry, folder)
        except _DAMAGED as error:
            raise InputError(
                f"{shown_path(file)} is damaged: '{one_line(entry.filename)}' in it cannot be unpacked "
                f"({one_line(str(error)) or type(error).__name__}); export the FMU again"
            ) from error


def _check_size(file: Path, entries: list[zipfile.ZipInfo], most_files: int, most_bytes: int) -> None:
    if len(entries) > most_files:
        raise InputError(f"{shown_path(file)} has {len(entries)} files in it; an FMU may have {most_files}")
    # An entry never unpacks to more than the size that it declares.
    size = sum(entry.file_size for entry in entries)
    if size > most_bytes:
        raise InputError(
            f"{shown_path(file)} would unpack to {size / 2**20:.0f} MiB; an FMU may have {most_bytes / 2**20:.0f} MiB"
        )


def _check_name(file: Path, entry: zipfile.ZipInfo) -> None:
    name = PurePosixPath(entry.filename)
    leaves = name.is_absolute() or ".." in name.parts or "\\" in entry.filename or ":" in entry.filename
    if leaves or stat.S_ISLNK(entry.external_attr >> 16):
        raise InputError(
            f"{shown_path(file)} has the entry '{one_line(entry.filename)}', which may lead outside of its folder; "
            "an FMU has files with relative names only"
        )


def _extract(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, folder: Path) -> None:
    target = folder / entry.filename
    if entry.is_dir():
        target.mkdir(parents=True, exist_ok=True)
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    with archive.open(entry) as packed, target.open("wb") as unpacked:
        shutil.copyfileobj(packed, unpacked)
