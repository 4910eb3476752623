"""What runs reach of a candidate in C or C++: a build with counters, and what `gcovr` reads of them."""

from __future__ import annotations

import os
import re
import shlex
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Final

from drivegate.candidates.candidate import Candidate, Instrumented, NativeBuild
from drivegate.candidates.native import rust_coverage
from drivegate.candidates.native.compiler import Compilation, found_compiler, include_folder
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
    if not is_compiled_here(candidate):
        return rust_coverage.counted_candidate(candidate, folder)
    require_package("gcovr", "--coverage")
    plan = plan_of(candidate)
    reader_of(plan)
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


def reader_of(plan: Compilation) -> str:
    """Return the command that reads the counters of a compiler."""
    (program, *_) = compiler = found_compiler(plan.languages[-1])
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
    own = os.path.commonpath([plan.folder, *(source.parent for source in candidate.sources)])
    filters = [word for source in candidate.sources for word in ("--filter", re.escape(str(source)) + "$")]
    places = (plan.folder, *(source.parent for source in candidate.sources))
    readable = (include_folder(), *places, *(Path(place) for place in plan.include))
    words = [
        "--root",
        str(own),
        *filters,
        *("--gcov-executable", reader_of(plan)),
        *("--exclude-throw-branches", "--merge-mode-functions", "separate"),
        *("--json", str(work / TRACE), "--lcov", str(work / LCOV), "--cobertura", str(work / COBERTURA)),
        str(work),
    ]
    gcovr(words, work, readable, work)
    hand_over(work, output)
    return files_of_trace(work / TRACE, Path(own))
