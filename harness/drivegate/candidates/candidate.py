"""What a candidate controller is, once its name has been resolved and before any of its code runs."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from drivegate.candidates.declaration import NOTHING_DECLARED, Declaration
from drivegate.candidates.step_costs import NO_COSTS, StepCosts
from drivegate_cases.documents.regular_file import regular_content
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.contract import ContractName
    from drivegate_cases.drive.drive_document import DriveDocument

Instrument: TypeAlias = Literal["coverage", "sanitizers"]
"""What looks into a candidate while it runs."""

STEP_DEADLINE: Final = 1.0
"""Time that a program has for each step unless its manifest says otherwise (s)."""
_LARGEST_BYTES: Final = 2**30
"""Greatest size of all files of a candidate."""


@dataclass(frozen=True)
class NativeBuild:
    """Where the code of a native candidate is, or the FMU that has it."""

    library: Path
    made_by: object | None = None
    """How it was made, as `drivegate.candidates.native` describes that; None for a library that was given."""


@dataclass(frozen=True)
class Program:
    executable: Path
    arguments: tuple[str, ...]
    """The words of the command line, the program's name the first."""
    step_deadline: float = STEP_DEADLINE
    """Time that it has for each step (s)."""


WAIT_FOR_INTERRUPT: Final = "wfi"
"""In the place of a function that pauses: the instruction."""


@dataclass(frozen=True)
class Stub:
    """A function of an image that does not run."""

    function: str
    returns: str
    """Expression of what it returns."""
    fills: tuple[tuple[str, str], ...] = ()
    """What it writes, mostly through pointers that it is passed, and the expressions of the values."""


@dataclass(frozen=True)
class Target:
    """How an image for a microcontroller is run."""

    image: Path
    start: tuple[str, ...] = ()
    """Functions that are called before each reset, such as one that runs constructors, in their order."""
    ram: tuple[tuple[int, int], ...] = ()
    """Address and size of further memory, such as where peripherals are (bytes)."""
    limits: StepCosts = NO_COSTS
    """What a step may cost; 0 for no limit."""
    step: str | None = None
    """Function that is called in each control period instead of an adapter's; None where there is an adapter."""
    peripherals: tuple[tuple[str, str], ...] = ()
    """Names of places, and the places."""
    write: tuple[tuple[str, str], ...] = ()
    """Variables that are written before a step, and the expressions of their values."""
    read: tuple[tuple[str, str], ...] = ()
    """Fields of the command, and the expressions of their values after a step."""
    stub: tuple[Stub, ...] = ()
    once: tuple[tuple[str, str], ...] = ()
    """Variables that are written once, and the expressions of their values."""
    pause: str | None = None
    """Function at whose call a step ends, or the instruction ``wfi``; None where the step returns."""


@dataclass(frozen=True)
class OuterLoop:
    """The controller of current references behind a loop of currents."""

    outer: Candidate


Details: TypeAlias = NativeBuild | Program | Target | OuterLoop
"""What only one kind needs."""


@dataclass(frozen=True)
class Instrumented:
    """What looks into a candidate while it runs, and where that leaves what it has found."""

    by: Instrument
    folder: Path
    """Folder into which the candidate's processes write."""
    library: Path | None = None
    """A second build of the sources, which runs next to the plain one."""
    reference: Path | None = None
    """The build that it must answer the same as; None for the plain one."""
    environment: tuple[tuple[str, str], ...] = ()
    """Variables that the processes start with, and their values."""
    suspects: tuple[str, ...] = ()
    """Places of which the compiler says that something may be read there before it is written."""
    stepper: Path | None = None
    """The library with the function that steps both builds; None where it is in the second build."""
    counts_branches: bool = True
    """Whether branches are counted, not lines alone."""
    copied: tuple[Path, Path] | None = None
    """The folder of sources and the copy in which it was built, which reports name; None where it was built itself."""


@dataclass(frozen=True)
class Candidate:
    """A candidate controller, resolved but not loaded."""

    name: str
    """What waivers match and reports show."""
    kind: str
    """Name of its kind's row in `drivegate.candidates.kinds.KINDS`."""
    specification: str
    """The string that named it."""
    entry: str
    """For Python, ``module:Class`` or the absolute ``/path/file.py:Class``; for a built-in, its name; for a
    file, its absolute path; for a program, its command line."""
    folder: Path
    """Folder whose modules the candidate may import, and in which a program starts."""
    sources: tuple[Path, ...]
    """The files that the hash covers."""
    content_hash: str
    """SHA-256 of the sources' contents and the entry's class, in hexadecimal."""
    declaration: Declaration = NOTHING_DECLARED
    details: Details | None = None
    drive: DriveDocument | None = None
    """The drive that its manifest names."""
    contract: ContractName | None = "current"
    """What it answers with: ``current``, a current reference and an advance angle, or ``duty``, duty ratios.
    None where nothing shows it before its code runs: then it is asked for what its drive takes."""
    instrumented: Instrumented | None = None
    """What looks into it; None for a plain run."""

    @property
    def step_limits(self) -> StepCosts:
        """What a step may cost on the target; 0 where nothing is stated."""
        return self.details.limits if isinstance(self.details, Target) else NO_COSTS


def existing_folder(file: Path) -> Path:
    """Return the folder that a file is in; where only a build makes it, the nearest one that exists."""
    return next(folder for folder in file.parents if folder.is_dir())


def hash_of(sources: Sequence[Path], entry: str) -> str:
    digest = hashlib.sha256(entry.encode())
    left = _LARGEST_BYTES
    for source in sources:
        try:
            content = regular_content(source)
        except OSError as error:
            raise InputError(
                f"{shown_path(source)} cannot be read: {error.strerror}; name a readable file"
            ) from error
        left -= len(content)
        if left < 0:
            raise InputError(
                f"the candidate's files are larger than {_LARGEST_BYTES // 2**20} MiB together, up to "
                f"{shown_path(source)}; name those alone that it is made of"
            )
        # With its length before each content, bytes that move from one file to the next change the hash.
        digest.update(f"\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()
