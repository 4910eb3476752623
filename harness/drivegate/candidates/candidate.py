"""What a candidate controller is, once its name has been resolved and before any of its code runs."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

from drivegate.candidates.declaration import Declaration
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.composed.candidate import Composition
    from drivegate.candidates.native.candidate import NativeBuild
    from drivegate.candidates.program.candidate import Program

CandidateKind: TypeAlias = Literal["builtin", "python", "c", "so", "fmu", "exec", "compose"]


@dataclass(frozen=True)
class Candidate:
    """A candidate controller, resolved but not loaded.

    Attributes
    ----------
    name : str
        What waivers match and reports show.
    kind : {"builtin", "python", "c", "so", "fmu", "exec", "compose"}
        How the candidate is loaded.
    specification : str
        The string that named it.
    entry : str
        For Python, ``module:Class`` or the absolute ``/path/file.py:Class``; for a built-in, its name; for a file,
        its absolute path; for a program, its command line.
    folder : Path
        Folder whose modules the candidate may import, and in which a program starts.
    sources : tuple of Path
        The files that the hash covers.
    content_hash : str
        SHA-256 of the sources' contents and the entry's class, in hexadecimal.
    declaration : Declaration
        What the candidate declares of itself.
    details : NativeBuild, Program, Composition or None
        What only its kind needs.
    """

    name: str
    kind: CandidateKind
    specification: str
    entry: str
    folder: Path
    sources: tuple[Path, ...]
    content_hash: str
    declaration: Declaration
    details: "NativeBuild | Program | Composition | None" = None


def existing_file(path: Path) -> Path:
    """Find a file that a candidate is made of."""
    try:
        if path.is_file():
            return path.resolve()
        problem = "is a folder" if path.is_dir() else "does not exist"
    except OSError as error:
        problem = f"cannot be read: {error.strerror}"
    raise InputError(f"{shown_path(path)} {problem}; name an existing file")


def hash_of(sources: Sequence[Path], entry: str) -> str:
    """Hash what a candidate is made of."""
    digest = hashlib.sha256(entry.encode())
    for source in sources:
        try:
            content = source.read_bytes()
        except OSError as error:
            sentence = f"{shown_path(source)} cannot be read: {error.strerror}; name a readable file"
            raise InputError(sentence) from error
        digest.update(f"\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()
