"""Further builds of a candidate in C or C++ that the commands of its own project make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from drivegate.candidates.candidate import Candidate, NativeBuild
from drivegate.candidates.native.build_commands import ProjectBuild, build_in_kept_folder, common_folder
from drivegate.candidates.native.c_shims import FurtherFlags
from drivegate.candidates.native.compiler import CPP, C, Language
from drivegate.candidates.native.two_builds import STEP_BOTH
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

_IN_CPP: Final = frozenset((".cpp", ".cc", ".cxx"))


def c_project(candidate: Candidate) -> ProjectBuild | None:
    """Return how a library is built from sources in C and C++; None for any other candidate."""
    details = candidate.details
    build = details.made_by if isinstance(details, NativeBuild) else None
    if not isinstance(build, ProjectBuild):
        return None
    suffixes = {source.suffix.lower() for source in build.sources}
    return build if ".rs" not in suffixes and suffixes & {".c", *_IN_CPP} else None


def language_of_project(build: ProjectBuild) -> Language:
    """Return the language of the compiler that links."""
    return CPP if any(source.suffix.lower() in _IN_CPP for source in build.sources) else C


def second_project_build(
    candidate: Candidate, option: str, flags: Sequence[str], linked: Sequence[str] = ()
) -> Path:
    """Build with further flags, or find what was."""
    build = c_project(candidate)
    assert build is not None, "it is a project in C"
    library = build_in_kept_folder(replace(build, c_flags=FurtherFlags(tuple(flags), tuple(linked))))
    if STEP_BOTH.encode() not in library.read_bytes():
        raise InputError(
            f"{option}: the 'build' of '{one_line(candidate.name)}' does not link the library by cc, gcc, c++, g++ or "
            "clang of PATH with -shared; have it call the compiler by one of these names"
        )
    return library


def copies_of(candidate: Candidate, copy: Path) -> dict[Path, Path]:
    """Return a candidate's sources by their places in the copy."""
    build = c_project(candidate)
    assert build is not None, "it is a project in C"
    common = common_folder(build)
    return {copy / source.relative_to(common): source for source in build.sources}
