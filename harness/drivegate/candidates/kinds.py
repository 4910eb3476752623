"""The kinds of candidate, one row each; all that the rest of the harness must know of a kind is in its row.

The folder of a kind has two modules. `resolution` has ``from_text(specification)`` and
``from_manifest(manifest, specification, reach)``, which return a `Candidate` and run none of its code; a manifest's
name, declaration and drive are added to it by `drivegate.candidates.resolution`. `loading` has
``load_controller(candidate)``, which runs it, and for some kinds ``compile_own_code(candidate)``. They are imported
when they are needed: each kind brings libraries of its own, and a process needs those of one kind only.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import Controller
from drivegate.candidates.step_costs import NO_COSTS
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from drivegate.candidates.reached_code import SourceFile
    from drivegate_cases.documents.document import Document
    from drivegate_cases.documents.reach import Reach


EXEC_PREFIX: Final = "exec:"
"""What the command line of a candidate that is a program begins with."""

FAULTY_PREFIX: Final = "faulty:"
"""What a faulty controller's name begins with; such controllers check the checks."""

DESIGN_PREFIX: Final = "design:"
"""What the name of a correct controller of another design begins with."""

NEAR_PREFIX: Final = "near:"
"""What the name of a correct controller begins with that is near a limit by design."""

LABORATORY_PREFIXES: Final = (FAULTY_PREFIX, DESIGN_PREFIX, NEAR_PREFIX)
"""What the name of a built-in controller begins with that the laboratory brings."""

INNER_PREFIX: Final = "inner:"
"""What the name of a controller of current references begins with that is run on duty ratios."""

MANIFEST_SUFFIX: Final = ".toml"

_COUNTED: Final = "C, C++, Rust and Python, and images with lines in DWARF"

COMPILED_FOLDER: Final = "native"
"""Folder of the kinds whose code is compiled for this processor."""


@dataclass(frozen=True)
class Kind:
    name: str
    """Its name in manifests and results."""
    folder: str
    """The folder next to this module that has its code."""
    ways: tuple[str, ...] = ()
    """How a user writes such a candidate, as messages show it."""
    prefixes: tuple[str, ...] = ()
    """What the string of such a candidate begins with."""
    suffixes: tuple[str, ...] = ()
    """Suffixes of the file that a candidate of this kind is as a whole."""
    may_lack_suffix: bool = False
    """Whether the entry of a manifest may also be a file without a suffix."""
    manifest_keys: tuple[str, ...] = ()
    """Keys of a manifest that are for this kind, and for others that have them too."""
    is_included: bool = False
    """Whether all of its code is drivegate's own, and so needs no process to contain it."""
    compiles_own_code: bool = False
    """Whether compiled code of drivegate is between a candidate's code and the loop."""
    is_counted: bool = False
    """Whether its folder has a module `coverage`, which counts what runs reach of its code."""
    reports_output: bool = False
    """Whether a fault without a traceback is reported with what the candidate's process printed."""
    way_of_running: str = ""
    """How its steps run, without which their time says little; empty where the controller itself states it."""
    untimed_because: str = ""
    """Why the time of its steps is not judged, in one clause; empty where it is."""

    def from_text(self, specification: str) -> Candidate:
        candidate: Candidate = self._module("resolution").from_text(specification)
        return candidate

    def from_manifest(self, manifest: Document, specification: str, reach: Reach) -> Candidate:
        """Find the candidate that a `Manifest` describes, whose keys are checked against these rows."""
        candidate: Candidate = self._module("resolution").from_manifest(manifest, specification, reach)
        return candidate

    def load_controller(self, candidate: Candidate) -> Controller:
        controller: Controller = self._module("loading").load_controller(candidate)
        return controller

    def compile_own_code(self, candidate: Candidate) -> None:
        """Compile what processes of a candidate need of drivegate and can only read; this runs none of its code."""
        if self.compiles_own_code:
            self._module("loading").compile_own_code(candidate)

    def counted_candidate(self, candidate: Candidate, folder: Path) -> Candidate:
        """Return a candidate whose processes write what runs reach of its code into a folder."""
        if not self.is_counted:
            raise InputError(
                f"--coverage counts candidates in {_COUNTED}, but '{one_line(candidate.name)}' is of the kind "
                f"'{self.name}'; leave the option out"
            )
        counted: Candidate = self._module("coverage").counted_candidate(candidate, folder)
        return counted

    def sanitized_candidate(self, candidate: Candidate, sanitizers: Sequence[str], folder: Path) -> Candidate:
        """Return a candidate whose processes also run a build with sanitizers."""
        if not self.is_counted or self.folder != COMPILED_FOLDER:
            raise InputError(
                f"--sanitize serves candidates in C, C++ and Rust, but '{one_line(candidate.name)}' is of the kind "
                f"'{self.name}'; leave the option out"
            )
        sanitized: Candidate = self._module("sanitizing").sanitized_candidate(candidate, sanitizers, folder)
        return sanitized

    def measured_files(self, candidate: Candidate, output: Path) -> tuple[SourceFile, ...]:
        """Read what was counted, and write the files for services into a folder."""
        files: tuple[SourceFile, ...] = self._module("coverage").measured_files(candidate, output)
        return files

    def _module(self, name: str) -> Any:
        return import_module(f"drivegate.candidates.{self.folder}.{name}")


_ALL: Final = (
    Kind(
        "python",
        "python",
        ways=("module:Class", "file.py:Class"),
        manifest_keys=("sources",),
        is_counted=True,
    ),
    Kind("builtin", "builtin", prefixes=LABORATORY_PREFIXES, is_included=True),
    Kind(
        "c",
        "native",
        ways=("file.c", "file.cpp"),
        suffixes=(".c", ".cpp", ".cc", ".cxx"),
        manifest_keys=("sources", "include", "flags"),
        is_counted=True,
    ),
    Kind(
        "so",
        "native",
        ways=("file.so",),
        suffixes=(".so",),
        manifest_keys=("sources", "build"),
        is_counted=True,
    ),
    Kind(
        "elf",
        "elf",
        ways=("file.elf",),
        suffixes=(".elf", ".axf", ".out"),
        may_lack_suffix=True,
        manifest_keys=(
            "sources",
            "build",
            "start",
            "ram",
            "step_instructions",
            "step_cycles",
            "stack_bytes",
            "step",
            "peripherals",
            "write",
            "read",
            "stub",
            "once",
            "pause",
        ),
        compiles_own_code=True,
        is_counted=True,
        way_of_running="an emulated target",
        untimed_because="the speed of the emulator says nothing of the target, so the manifest states limits of a step "
        "instead, such as 'step_cycles'",
    ),
    Kind(
        "fmu",
        "fmu",
        ways=("file.fmu",),
        suffixes=(".fmu",),
        manifest_keys=("sources", "build"),
        way_of_running="FMU",
    ),
    Kind(
        "exec",
        "program",
        ways=("exec:command",),
        prefixes=(EXEC_PREFIX,),
        manifest_keys=("sources", "step_deadline_s"),
        reports_output=True,
        way_of_running="a process of its own",
        untimed_because="most of the time of a program's step passes in the pipes to it",
    ),
    Kind(
        "inner",
        "inner",
        ways=("inner:pi:candidate",),
        prefixes=(INNER_PREFIX,),
        compiles_own_code=True,
        reports_output=True,
    ),
)

KINDS: Final[Mapping[str, Kind]] = {kind.name: kind for kind in _ALL}
"""Every kind by its name, in the order in which messages list them."""

WHOLE_FILE_SUFFIXES: Final = (MANIFEST_SUFFIX, *(suffix for kind in _ALL for suffix in kind.suffixes))


def load_controller(candidate: Candidate) -> Controller:
    return KINDS[candidate.kind].load_controller(candidate)


def untimed_because(candidate: Candidate) -> str:
    """Return why neither the time nor the cost of a candidate's steps is judged; empty where one is."""
    return "" if candidate.step_limits != NO_COSTS else KINDS[candidate.kind].untimed_because
