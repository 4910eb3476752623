"""Loading an FMU as a candidate: unpacking it within bounds, reading its description, loading its library.

This opens the candidate's file and runs its code, so it belongs into a worker process. What cannot be used raises
`InputError`; an FMU whose own code fails raises `CandidateFault`.
"""

import contextlib
import os
import shutil
import stat
import tempfile
import weakref
import zipfile
import zlib
from functools import cache
from lzma import LZMAError
from pathlib import Path, PurePosixPath
from typing import Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.contract import AnyNameplate, require_nameplate_of
from drivegate.candidates.fmu.description import FmuDescription, read_description
from drivegate.candidates.fmu.instance import FmuInstance
from drivegate.candidates.fmu.variables import LEGS
from drivegate.candidates.python.bridge import PythonController
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

# A small archive can unpack to any size. Both limits are far above what tools export.
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


def load_controller(candidate: Candidate) -> "FmuController":
    """Make a new instance of an FMU; its file is unpacked once a process."""
    try:
        import fmpy  # noqa: F401
    except ImportError as error:
        raise InputError(
            f"the candidate '{one_line(candidate.specification)}' is an FMU, which needs the package fmpy; "
            "pip install fmpy"
        ) from error
    unpacked = _unpacked(Path(candidate.entry), candidate.content_hash)
    return FmuController(unpacked)


class UnpackedFmu:
    """An FMU in a temporary folder, which goes when the process ends."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.folder = Path(tempfile.mkdtemp(prefix="drivegate-fmu-"))
        self._removal = weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)
        self._current: weakref.ref[FmuInstance] | None = None
        try:
            unpack(file, self.folder)
            self.description: FmuDescription = read_description(file, self.folder)
            self._check_library()
            self.instance()
        except BaseException:
            self._removal()
            raise

    def instance(self) -> FmuInstance:
        # Some libraries are loaded from their own folder, and fmpy stays in it when that fails.
        with contextlib.chdir(Path.cwd()):
            try:
                return _loaded(self.description, self.folder)
            except Exception as error:
                problem = one_line(str(error).replace(f"{self.folder}{os.sep}", "")).rstrip(". ")
                raise InputError(
                    f"{shown_path(self.file)} has a library that cannot be loaded: {problem}; export it for this "
                    "platform, with all that it needs"
                ) from error

    def close_other(self, instance: FmuInstance) -> None:
        """Close the present instance of an FMU that can have only one in a process, before another one is made."""
        if not self.description.only_once:
            return
        current = self._current() if self._current is not None else None
        if current is not None and current is not instance:
            current.close()
        self._current = weakref.ref(instance)

    def _check_library(self) -> None:
        import fmpy

        place = fmpy.platform if self.description.version == 2 else fmpy.platform_tuple
        library = f"{self.description.identifier}{fmpy.sharedLibraryExtension}"
        if (self.folder / "binaries" / place / library).is_file():
            return
        others = sorted(folder.name for folder in (self.folder / "binaries").glob("*/"))
        has = f"has binaries for {one_line(', '.join(others))} only" if others else "has no binaries"
        raise InputError(
            f"{shown_path(self.file)} {has}, but this platform needs binaries/{place}/{library}; export it for this "
            "platform"
        )


class FmuController(PythonController):
    """An FMU behind the C function that the compiled loop calls."""

    def __init__(self, unpacked: UnpackedFmu) -> None:
        self._unpacked = unpacked
        self._fmu = unpacked.instance()
        super().__init__(self._fmu)

    def reset(self, nameplate: AnyNameplate) -> None:
        connections = self._unpacked.description.connections
        require_nameplate_of(connections.contract, nameplate)
        phases = getattr(nameplate, "phases", LEGS)
        for name, count in connections.arrays:
            if count != phases:
                raise InputError(
                    f"{shown_path(self._unpacked.file)} takes {count} {name.replace('_', ' ')}, but the motor has "
                    f"{phases} phases; export it for that many, or without {name}"
                )
        self._unpacked.close_other(self._fmu)
        super().reset(nameplate)


def _loaded(description: FmuDescription, folder: Path) -> FmuInstance:
    given = {
        "guid": description.token,
        "modelIdentifier": description.identifier,
        "unzipDirectory": str(folder),
        "instanceName": "controller",
    }
    if description.version == 2:
        from fmpy.fmi2 import FMU2Slave

        from drivegate.candidates.fmu.instance import Fmi2Instance

        return Fmi2Instance(description, FMU2Slave(**given))
    from fmpy.fmi3 import FMU3Slave

    from drivegate.candidates.fmu.instance import Fmi3Instance

    return Fmi3Instance(description, FMU3Slave(**given))


@cache
def _unpacked(file: Path, _content_hash: str) -> UnpackedFmu:
    """Unpack a file once; the hash shows when it has changed."""
    return UnpackedFmu(file)
