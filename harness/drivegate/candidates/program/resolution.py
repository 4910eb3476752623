"""A candidate that is a program of any language, named by its command line."""

import os
import shlex
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from drivegate.candidates.candidate import STEP_DEADLINE, Candidate, Program, hash_of
from drivegate.candidates.command_path import command_path
from drivegate.candidates.kinds import EXEC_PREFIX
from drivegate.isolation.layers import system_places
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest
    from drivegate_cases.documents.reach import Reach

_EXAMPLE = "exec:python3 controller.py"


def from_text(specification: str) -> Candidate:
    """Find the program that a string names; it starts in the present folder."""
    command = specification.removeprefix(EXEC_PREFIX).strip()
    where = f"the candidate '{one_line(specification)}'"
    words = _words(command, where, f"write {_EXAMPLE}")
    folder = Path.cwd()
    return _candidate(specification, command, folder, _program(words, folder, where))


def from_manifest(manifest: "Manifest", specification: str, reach: "Reach") -> Candidate:
    """Find the program that a manifest names; it starts in the manifest's folder."""
    where = f"{shown_path(specification)}: the key 'entry'"
    words = _words(manifest.entry, where, "write a command line, such as 'python3 controller.py'")
    deadline = STEP_DEADLINE if manifest.step_deadline_s is None else manifest.step_deadline_s
    _require_reached(words, reach, where)
    program = _program(words, reach.folder, where, deadline)
    return _candidate(specification, manifest.entry, reach.folder, program, manifest.source_files(reach))


def _candidate(
    specification: str,
    command: str,
    folder: Path,
    program: Program,
    further_sources: tuple[Path, ...] = (),
) -> Candidate:
    # Without the folders of files, so that a waiver matches wherever they are.
    short = (
        Path(word).name if "/" in word and _file_named(word, folder) else word for word in program.arguments
    )
    name = EXEC_PREFIX + one_line(shlex.join(short))
    named = (_file_named(word, folder) for word in program.arguments)
    sources = tuple(dict.fromkeys((*(file for file in named if file is not None), *further_sources)))
    entry = shlex.join(program.arguments)
    digest = hash_of(sources, entry)
    # Only the program itself shows its contract.
    return Candidate(
        name, "exec", specification, command, folder, sources, digest, details=program, contract=None
    )


def _words(command: str, where: str, advice: str) -> tuple[str, ...]:
    try:
        words = tuple(shlex.split(command))
    except ValueError as error:
        problem = "a quote that is not closed" if "quotation" in str(error) else "a backslash at its end"
        raise InputError(f"{where} has {problem}; {advice}") from error
    if not words or not words[0]:
        raise InputError(f"{where} names no program; {advice}")
    return words


def _program(words: Sequence[str], folder: Path, where: str, step_deadline: float = STEP_DEADLINE) -> Program:
    """Find the executable: a name with a slash from the folder on, any other in PATH."""
    word = words[0]
    if "/" not in word:
        found = shutil.which(word, path=command_path())
        if found is None:
            hint = "" if not (folder / word).is_file() else f", or ./{one_line(word)} for the file there"
            raise InputError(
                f"{where} starts '{one_line(word)}', which is no program in PATH; name an installed program{hint}"
            )
        return Program(Path(found).absolute(), tuple(words), step_deadline)
    file = folder / word
    if not file.is_file():
        raise InputError(f"{where} starts {shown_path(file)}, which does not exist; name an existing program")
    if not os.access(file, os.X_OK):
        raise InputError(
            f"{where} starts {shown_path(file)}, which is not executable; set its permission with chmod +x, or name "
            "its interpreter first"
        )
    return Program(file.absolute(), tuple(words), step_deadline)


def _require_reached(words: Sequence[str], reach: "Reach", where: str) -> None:
    """Refuse a command line that names a file which is neither in reach nor of the system.

    Programs in PATH are the user's, whatever links lead to them: the `python3` of a virtual environment does.
    """
    programs = [Path(place).resolve() for place in command_path().split(os.pathsep) if place]
    usual = [Path(place).resolve() for place in system_places()]
    for number, word in enumerate(words):
        file = _file_named(word, reach.folder)
        if file is None or (number == 0 and ("/" not in word or file.parent in programs)):
            continue
        if not any(file.is_relative_to(place) for place in usual):
            reach.file(word, f"{where}: a file")


def _file_named(word: str, folder: Path) -> Path | None:
    try:
        return (folder / word).resolve() if word and (folder / word).is_file() else None
    except OSError:
        return None
