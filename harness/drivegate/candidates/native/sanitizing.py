"""A build of a candidate in C or C++ with sanitizers, which report what the language leaves undefined."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

from drivegate.candidates.candidate import Candidate, Instrumented
from drivegate.candidates.fault import bounded_reason, short_lines
from drivegate.candidates.native import rust_sanitizing
from drivegate.candidates.native.bounded_command import asked
from drivegate.candidates.native.build_commands import common_folder, copy_around
from drivegate.candidates.native.c_project import c_project, language_of_project, second_project_build
from drivegate.candidates.native.compiler import Compilation, CompilationError, Compilers, found_compiler
from drivegate.candidates.native.coverage import is_compiled_here, plan_of
from drivegate.candidates.native.sanitizer_runtime import preloaded
from drivegate.candidates.native.second_build import LIBRARY, OUTPUT, compilers_of, is_clang, second_build
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

_FLAGS: Final = MappingProxyType(
    {
        "address": ("-fsanitize=address",),
        # A conversion that is out of range is undefined too, but no compiler has it among these.
        "undefined": ("-fsanitize=undefined,float-cast-overflow",),
        "float": ("-fsanitize=float-divide-by-zero",),
    }
)
_COMMON: Final = ("-g", "-fno-omit-frame-pointer", "-fno-sanitize-recover=all")
# An optimizer takes what was never written for whatever suits it.
_UNOPTIMIZED: Final = ("-O0",)
_PATTERN, _ZERO = "-ftrivial-auto-var-init=pattern", "-ftrivial-auto-var-init=zero"
"""What variables are that nothing has written, in the build with sanitizers and in its reference."""
_FILLED: Final = tuple(f"-Wl,--wrap={name}" for name in ("malloc", "_Znwm", "_Znam"))
"""The allocations that `two_builds.c` fills, malloc and C++'s two; linkers of macOS cannot replace them."""
_HEAP_PATTERN, _HEAP_ZERO = "-DDRIVEGATE_FILL=0xfe", "-DDRIVEGATE_FILL=0"
_ANALYSIS: Final = ("-O0", "-Wuninitialized")
# Each path by itself, since where paths are merged, what one of them has written counts as written; and more of them,
# for templates of C++.
_OF_GCC: Final = (
    "-fanalyzer",
    "-fno-analyzer-state-merge",
    "--param=analyzer-bb-explosion-factor=50",
    "-fdiagnostics-path-format=none",
)
_OF_CLANG: Final = ("-Wconditional-uninitialized",)

_UNDEFINED_OPTIONS: Final = "halt_on_error=1:print_stacktrace=0:color=never"
_UNWRITTEN: Final = re.compile(
    r"^(?P<file>[^\s:][^:\n]*):(?P<line>\d+):\d+:\s*warning:\s*(?P<message>.*uninitialized.*?)\s*\[-W",
    re.MULTILINE,
)
# What the analysis calls a value that has no name in the source, and the number of the weakness.
_INTERNAL: Final = re.compile(r" '[^']*[<(][^']*'| \[CWE-\d+\]")
_MOST_SUSPECTS: Final = 5


def sanitized_candidate(candidate: Candidate, sanitizers: Sequence[str], folder: Path) -> Candidate:
    """Return a candidate whose processes also run a build with sanitizers."""
    project = c_project(candidate)
    if not is_compiled_here(candidate) and project is None:
        return rust_sanitizing.sanitized_candidate(candidate, sanitizers, folder)
    languages = plan_of(candidate).languages if project is None else (language_of_project(project),)
    compilers = {language: found_compiler(language) for language in languages}
    for name in sanitizers:
        _require(compilers, name)
    # Older compilers cannot choose what is in a variable that nothing has written.
    chooses = all(_accepts(compiler, _PATTERN) for compiler in compilers.values())
    checked = tuple(flag for name in sanitizers for flag in _FLAGS[name])
    pattern, zero = ([_PATTERN], [_ZERO]) if chooses else ([], [])
    filled = () if sys.platform == "darwin" else _FILLED
    if filled:
        pattern, zero = [*pattern, _HEAP_PATTERN], [*zero, _HEAP_ZERO]
    flags, own = (*_UNOPTIMIZED, *_COMMON, *checked, *pattern), (*_UNOPTIMIZED, *zero)
    if project is None:
        plan = plan_of(candidate)
        built, reference = (second_build(plan, (*each, *filled)) / LIBRARY for each in (flags, own))
        suspects, copied = _suspects(plan, candidate.folder), None
    else:
        built, reference = (
            second_project_build(candidate, "--sanitize", each, filled) for each in (flags, own)
        )
        suspects, copied = (), (common_folder(project), copy_around(built))
    environment = {
        "UBSAN_OPTIONS": _UNDEFINED_OPTIONS,
        **preloaded(compilers[languages[-1]], languages[-1], sanitizers),
    }
    instrumented = Instrumented(
        "sanitizers",
        folder,
        built,
        reference,
        tuple(environment.items()),
        suspects,
        copied=copied,
    )
    return replace(candidate, instrumented=instrumented)


def _require(compilers: Compilers, name: str) -> None:
    """Refuse a sanitizer that a compiler does not have."""
    for language, compiler in compilers.items():
        if not _accepts(compiler, *_FLAGS[name]):
            packages = "libubsan" if name != "address" else "libasan"
            raise InputError(
                f"--sanitize {name} needs a compiler with that sanitizer, but {one_line(compiler[0])} has none; "
                f"install one ({language.packages}; Fedora needs {packages} too)"
            )


def _accepts(compiler: Sequence[str], *flags: str) -> bool:
    words = [*compiler, *flags, "-x", "c", "-E", "/dev/null"]
    return asked(words).status == 0


def _suspects(plan: Compilation, folder: Path) -> tuple[str, ...]:
    """Return the places of which the compiler says that a variable there may be read before it is written."""
    compilers = compilers_of(plan).values()
    flags = (*_ANALYSIS, *(_OF_CLANG if all(map(is_clang, compilers)) else _OF_GCC))
    if not all(_accepts(compiler, *flags) for compiler in compilers):
        return ()
    try:
        output = short_lines((second_build(plan, flags) / OUTPUT).read_text(encoding="utf-8"))
    except CompilationError:
        # It takes long on some sources, and only adds a line to a fault.
        return ()
    # The last complaint of a line is that of the analysis of paths.
    found = {
        f"{_shown(found['file'], folder)}, line {found['line']}": bounded_reason(
            _INTERNAL.sub("", found["message"])
        )
        for found in _UNWRITTEN.finditer(output)
    }
    return tuple(f"{place}: {message}" for place, message in found.items())[:_MOST_SUSPECTS]


def _shown(file: str, folder: Path) -> str:
    path = Path(file)
    return one_line(str(path.relative_to(folder) if path.is_relative_to(folder) else path))
