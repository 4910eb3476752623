"""What runs reach of a candidate in C or C++: a build with counters, and what `gcovr` reads of them."""

from __future__ import annotations

import os
import re
import shlex
import shutil
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from drivegate.candidates.candidate import Candidate, Instrumented, NativeBuild
from drivegate.candidates.native import rust_coverage
from drivegate.candidates.native.build_commands import TOOLS, ProjectBuild, copy_around
from drivegate.candidates.native.c_project import (
    c_project,
    copies_of,
    language_of_project,
    second_project_build,
)
from drivegate.candidates.native.compiler import Compilation, Language, found_compiler, include_folder
from drivegate.candidates.native.coverage_tools import (
    COBERTURA,
    LCOV,
    TRACE,
    files_of_trace,
    gcovr,
    hand_over,
    require_package,
    take_over,
    work_folder,
)
from drivegate.candidates.native.coverage_trace import trace_of
from drivegate.candidates.native.second_build import LIBRARY, compilers_of, is_clang, second_build
from drivegate.candidates.reached_code import SourceFile
from drivegate_models.errors import InputError

_COUNTED: Final = ("--coverage", "-g", "-DDRIVEGATE_COUNTS")
# Functions that are inlined before counters are added would have branches for each call.
_OF_GCC: Final = ("-fprofile-abs-path", "-fno-early-inlining")
# It shortens the paths of files below the folder in which it runs.
_OF_CLANG: Final = ("-ffile-compilation-dir=/",)


def counted_candidate(candidate: Candidate, folder: Path) -> Candidate:
    """Return a candidate whose processes also run a build that counts, and write the counters into a folder."""
    project = c_project(candidate)
    if not is_compiled_here(candidate) and project is None:
        return rust_coverage.counted_candidate(candidate, folder)
    require_package("gcovr", "--coverage")
    if project is not None:
        language = language_of_project(project)
        reader_of(language)
        flags = _OF_CLANG if is_clang(found_compiler(language)) else _OF_GCC
        library = second_project_build(candidate, "--coverage", (*_COUNTED, *flags))
        return replace(candidate, instrumented=Instrumented("coverage", folder, library))
    plan = plan_of(candidate)
    reader_of(plan.languages[-1])
    flags = _OF_CLANG if any(map(is_clang, compilers_of(plan).values())) else _OF_GCC
    built = second_build(plan, (*_COUNTED, *flags))
    return replace(candidate, instrumented=Instrumented("coverage", folder, built / LIBRARY))


def is_compiled_here(candidate: Candidate) -> bool:
    """Return True if drivegate compiles the sources, not a command of the manifest."""
    details = candidate.details
    return isinstance(details, NativeBuild) and isinstance(details.made_by, Compilation)


def plan_of(candidate: Candidate) -> Compilation:
    """Return how a candidate of the kind `c` is compiled."""
    details = candidate.details
    assert isinstance(details, NativeBuild), "it is compiled code"
    assert isinstance(details.made_by, Compilation), "drivegate compiles it"
    return details.made_by


def reader_of(language: Language) -> str:
    """Return the command that reads the counters of a language's compiler."""
    (program, *_) = compiler = found_compiler(language)
    clang = is_clang(compiler)
    version = re.search(r"-\d+$", Path(program).name)
    name = ("llvm-cov" if clang else "gcov") + (version[0] if version else "")
    found = shutil.which(name) or shutil.which("llvm-cov" if clang else "gcov")
    if found is None:
        raise InputError(
            f"--coverage needs the program {name}, which belongs to the compiler {program}; install it (Debian and "
            f"Ubuntu: apt install {'llvm' if clang else 'gcc'})"
        )
    return f"{shlex.quote(found)} gcov" if clang else shlex.quote(found)


def measured_files(candidate: Candidate, output: Path) -> tuple[SourceFile, ...]:
    """Read what was counted, and write the files for services into a folder."""
    project = c_project(candidate)
    if project is not None:
        return _measured_project(candidate, project, output)
    if not is_compiled_here(candidate):
        return rust_coverage.measured_files(candidate, output)
    instrumented = candidate.instrumented
    assert instrumented is not None
    assert instrumented.library is not None, "it was compiled to count"
    plan = plan_of(candidate)
    work = work_folder(candidate)
    # Objects are numbered, drivegate's own the last. libgcov makes the folders in which an object was compiled.
    for number in range(len(plan.sources)):
        take_over(instrumented.library.with_name(f"{number}.gcno"), work)
        for counted in instrumented.folder.glob(f"**/made/{number}.gcda"):
            take_over(counted, work)
    own = Path(os.path.commonpath([plan.folder, *(source.parent for source in candidate.sources)]))
    places = (plan.folder, *(source.parent for source in candidate.sources))
    readable = (include_folder(), *places, *(Path(place) for place in plan.include))
    outputs = ("--lcov", str(work / LCOV), "--cobertura", str(work / COBERTURA))
    _read(work, own, candidate.sources, readable, reader_of(plan.languages[-1]), outputs)
    hand_over(work, output)
    return files_of_trace(work / TRACE, own)


def _measured_project(candidate: Candidate, project: ProjectBuild, output: Path) -> tuple[SourceFile, ...]:
    """Read what was counted in the copy of a project, and name the files in the project itself."""
    instrumented = candidate.instrumented
    assert instrumented is not None
    assert instrumented.library is not None, "it was built to count"
    copy = copy_around(instrumented.library)
    work = work_folder(candidate)
    for number, note in enumerate(sorted(copy.rglob("*.gcno"))):
        counted = (instrumented.folder / note.relative_to("/")).with_suffix(".gcda")
        if not counted.exists():
            # Of another program, such as those by which cmake tries a compiler.
            continue
        place = work / str(number)
        place.mkdir()
        for file in (note, counted):
            take_over(file, place)
    sources, readable = copies_of(candidate, copy), (copy, copy.parent / TOOLS, include_folder())
    _read(work, copy, sources, readable, reader_of(language_of_project(project)), ())
    lines = {
        sources[copy / file.name]: {line.number: (line.count, line.branches) for line in file.lines}
        for file in files_of_trace(work / TRACE, copy)
    }
    common = Path(os.path.commonpath([candidate.folder, *(source.parent for source in lines)]))
    return trace_of(lines, common, work, output)


def _read(
    work: Path,
    root: Path,
    sources: Iterable[Path],
    readable: Iterable[Path],
    reader: str,
    outputs: Sequence[str],
) -> None:
    """Have gcovr read the counters in a folder of the tools, and write a trace and other files there."""
    filters = [word for source in sources for word in ("--filter", re.escape(str(source)) + "$")]
    words = [
        "--root",
        str(root),
        *filters,
        *("--gcov-executable", reader),
        *("--exclude-throw-branches", "--merge-mode-functions", "separate"),
        *("--json", str(work / TRACE)),
        *outputs,
        str(work),
    ]
    gcovr(words, work, readable, work)
