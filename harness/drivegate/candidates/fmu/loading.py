"""Loading an FMU as a candidate: unpacking it, reading its description, loading its library.

This opens the candidate's file and runs its code, so it belongs into a worker process. What cannot be used raises
`InputError`; an FMU whose own code fails raises `CandidateFault`.
"""

import contextlib
import os
import shutil
import tempfile
import weakref
from functools import cache
from pathlib import Path

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.contract import AnyNameplate, require_nameplate_of
from drivegate.candidates.fmu.archive import unpack
from drivegate.candidates.fmu.description import FmuDescription, read_description
from drivegate.candidates.fmu.instance import FmuInstance
from drivegate.candidates.fmu.ports import LEGS
from drivegate.candidates.python.bridge import PythonController
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError


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
        """Load the library."""
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

    def make_room(self, instance: FmuInstance) -> None:
        """Make room for an instance of an FMU that can have only one in a process."""
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
        """Instantiate the FMU again before a run."""
        connections = self._unpacked.description.connections
        require_nameplate_of(connections.contract, nameplate)
        phases = getattr(nameplate, "phases", LEGS)
        for name, count in connections.arrays:
            if count != phases:
                raise InputError(
                    f"{shown_path(self._unpacked.file)} takes {count} {name.replace('_', ' ')}, but the motor has "
                    f"{phases} phases; export it for that many, or without {name}"
                )
        self._unpacked.make_room(self._fmu)
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
