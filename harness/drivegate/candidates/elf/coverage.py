"""What runs reach of an image on the emulated processor: blocks of instructions, mapped to lines by DWARF.

Only lines are counted: what a block branches to is not followed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from drivegate.candidates.candidate import Candidate, Instrumented, Target
from drivegate.candidates.fault import bounded_reason
from drivegate.candidates.native.coverage_tools import require_package, work_folder
from drivegate.candidates.native.coverage_trace import trace_of
from drivegate.candidates.reached_code import SourceFile
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.regular_file import made_content
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

_OF_DIRECTORIES: Final = 5
"""Version of DWARF from which on the first folder and file are those of the unit."""


def counted_candidate(candidate: Candidate, folder: Path) -> Candidate:
    """Return a candidate whose processes write into a folder which blocks of its image ran."""
    require_package("gcovr", "--coverage")
    if not _lines_of(candidate):
        raise InputError(
            f"--coverage finds no lines of the sources of '{one_line(candidate.name)}' in its image; compile it with "
            "-g, and name its sources in the key 'sources' of its manifest"
        )
    return replace(candidate, instrumented=Instrumented("coverage", folder, counts_branches=False))


def write_blocks(blocks: Iterable[tuple[int, int]], folder: Path) -> None:
    """Write which blocks of instructions a process has run: addresses and sizes."""
    write_atomically(folder / f"blocks-{os.getpid()}.json", json.dumps(sorted(blocks)))


def measured_files(candidate: Candidate, output: Path) -> tuple[SourceFile, ...]:
    """Read what was counted, and write the files for services into a folder."""
    work = work_folder(candidate)
    ran = _addresses(work.parent)
    lines = _lines_of(candidate)
    common = Path(os.path.commonpath([candidate.folder, *(source.parent for source in lines)]))
    counted = {
        source: {number: (int(bool(places & ran)), ()) for number, places in numbers.items()}
        for source, numbers in lines.items()
    }
    return trace_of(counted, common, work, output)


def _addresses(folder: Path) -> set[int]:
    """Return the addresses of all halfwords that have run in any process."""
    ran: set[int] = set()
    for file in folder.glob("blocks-*.json"):
        for address, size in json.loads(made_content(file)):
            ran.update(range(int(address), int(address) + int(size), 2))
    return ran


def _lines_of(candidate: Candidate) -> Mapping[Path, dict[int, set[int]]]:
    """Return the addresses at which each line of the candidate's sources begins."""
    assert isinstance(candidate.details, Target), "it is an image"
    found: dict[Path, dict[int, set[int]]] = {}
    for path, number, address in _all_rows(candidate.details.image):
        source = _source_of(path, candidate.sources)
        if source is None:
            continue
        found.setdefault(source, {}).setdefault(number, set()).add(address)
    return found


def _source_of(path: str, sources: Iterable[Path]) -> Path | None:
    """Return the source that a path is of, which may be that of a copy in which the image was built."""
    for source in sources:
        if path == str(source):
            return source
    parts = Path(path).parts
    same = [source for source in sources if source.parts[-1:] == parts[-1:]]
    return max(same, key=lambda source: _same_parts(source.parts, parts), default=None)


def _same_parts(first: tuple[str, ...], second: tuple[str, ...]) -> int:
    same = 0
    for one, other in zip(reversed(first), reversed(second), strict=False):
        if one != other:
            break
        same += 1
    return same


def _all_rows(image: Path) -> list[tuple[str, int, int]]:
    try:
        return list(_rows(image))
    except Exception as error:
        # Damaged debug information makes its reader raise nearly anything.
        reason = bounded_reason(str(error)) or type(error).__name__
        raise InputError(
            f"{shown_path(image)}: --coverage cannot read the debug information of the image: {reason}; compile and "
            "link it with -g again"
        ) from error


def _rows(image: Path) -> Iterator[tuple[str, int, int]]:
    """List the file, line and address of each row of the image's tables of lines at which a statement begins."""
    from elftools.elf.elffile import ELFFile

    with image.open("rb") as stream:
        file = ELFFile(stream)
        if not file.has_dwarf_info():
            return
        information = file.get_dwarf_info()
        for unit in information.iter_CUs():
            program = information.line_program_for_CU(unit)
            if program is None:
                continue
            folder = unit.get_top_DIE().attributes.get("DW_AT_comp_dir")
            unit_folder = "" if folder is None else folder.value.decode(errors="replace")
            paths = _paths(program.header, unit_folder)
            for entry in program.get_entries():
                state = entry.state
                if state is not None and state.is_stmt and not state.end_sequence and state.line:
                    yield paths.get(state.file, ""), int(state.line), int(state.address) & ~1


def _paths(header: Any, unit_folder: str) -> dict[int, str]:
    """Return the files of a table of lines by their numbers."""
    is_new = header.version >= _OF_DIRECTORIES
    folders = [name.decode(errors="replace") for name in header.include_directory]
    if not is_new:
        folders = [unit_folder, *folders]
    paths = {}
    for number, entry in enumerate(header.file_entry, 0 if is_new else 1):
        folder = folders[entry.dir_index] if entry.dir_index < len(folders) else ""
        name = entry.name.decode(errors="replace")
        paths[number] = os.path.normpath(Path(unit_folder) / folder / name)
    return paths
