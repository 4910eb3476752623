"""What runs reach of a candidate in Rust: a build with counters, and what `llvm-cov` reads of them."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final, NamedTuple

from drivegate.candidates.candidate import Candidate, Instrumented
from drivegate.candidates.native.bounded_command import asked
from drivegate.candidates.native.coverage_tools import require_package, run_tool, work_folder
from drivegate.candidates.native.coverage_trace import trace_of
from drivegate.candidates.native.rust_build import (
    RustCompiler,
    rust_build,
    rust_compiler,
    second_rust_build,
    stepping_library,
)
from drivegate.candidates.reached_code import SourceFile
from drivegate_cases.documents.regular_file import made_content
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

_OPTION: Final = "--coverage"
# Counters are in a file from the first one on, so that they outlive the end of a process and a reset of variables.
_COUNTED: Final = (
    "-Cinstrument-coverage",
    "-Cllvm-args=-runtime-counter-relocation",
    "-Cdebuginfo=1",
    "-Cstrip=none",
)
_BRANCHES: Final = "-Zcoverage-options=branch"
_PROFILES: Final = "%p-%c.profraw"
_MAPPED: Final = b"__llvm_covmap"
"""Name of the section that maps counters to lines."""
_VERSION: Final = re.compile(r"LLVM version (\d+)\S*")


class Tools(NamedTuple):
    merge: str
    """The program `llvm-profdata`."""
    read: str
    """The program `llvm-cov`."""


def counted_candidate(candidate: Candidate, folder: Path) -> Candidate:
    """Return a candidate whose processes also run a build that counts, and write the counters into a folder."""
    require_package("gcovr", _OPTION)
    build = rust_build(candidate, _OPTION)
    compiler = rust_compiler(build, _OPTION)
    tools_of(compiler)
    branches = (_BRANCHES,) if compiler.is_nightly else ()
    library = second_rust_build(build, (*_COUNTED, *branches))
    if _MAPPED not in library.read_bytes():
        raise InputError(
            f"{_OPTION}: the library of '{one_line(candidate.name)}' has no counters, since its 'build' starts another "
            "rustc than the one of the variable RUSTC and of PATH; have it start that one"
        )
    return replace(
        candidate,
        instrumented=Instrumented(
            "coverage",
            folder,
            library,
            environment=(("LLVM_PROFILE_FILE", str(folder / _PROFILES)),),
            stepper=stepping_library(),
            counts_branches=compiler.is_nightly,
        ),
    )


def tools_of(compiler: RustCompiler) -> Tools:
    """Find the tools of the compiler's LLVM; those of another version do not read its counters."""
    own = compiler.sysroot / "lib" / "rustlib" / compiler.host / "bin"
    other = ""
    for place, suffix in ((own, ""), (None, f"-{compiler.llvm}"), (None, "")):
        found = [shutil.which(f"{name}{suffix}", path=place) for name in ("llvm-profdata", "llvm-cov")]
        if found[0] is None or found[1] is None:
            continue
        version = _version_of(found[1])
        if version == compiler.llvm:
            return Tools(found[0], found[1])
        other = f" ({found[1]} is of version {version})"
    raise InputError(
        f"{_OPTION} needs llvm-profdata and llvm-cov of LLVM {compiler.llvm}, which rustc {compiler.release} is built "
        f"with{other}; install them (rustup component add llvm-tools; Debian and Ubuntu: apt install "
        f"llvm-{compiler.llvm})"
    )


def _version_of(program: str) -> int:
    found = _VERSION.search(asked([program, "--version"]).output)
    return int(found[1]) if found else 0


def measured_files(candidate: Candidate, output: Path) -> tuple[SourceFile, ...]:
    """Read what was counted, and write the files for services into a folder."""
    instrumented = candidate.instrumented
    assert instrumented is not None
    assert instrumented.library is not None, "it was compiled to count"
    work = work_folder(candidate)
    profiles = sorted(instrumented.folder.glob("*.profraw"))
    if not profiles:
        return ()
    tools = tools_of(rust_compiler(rust_build(candidate, _OPTION), _OPTION))
    merged, listed, names = work / "merged.profdata", work / "listed.info", work / "profiles.txt"
    names.write_text("".join(f"{profile}\n" for profile in profiles), encoding="utf-8")
    readable = (instrumented.folder, instrumented.library, candidate.folder, *candidate.sources)
    words = [tools.merge, "merge", "-sparse", "-o", str(merged), "-f", str(names)]
    run_tool(words, work, readable, work, "llvm-profdata")
    words = [tools.read, "export", "-format=lcov", f"-instr-profile={merged}", str(instrumented.library)]
    # What is printed is kept in parts only.
    to_file = ["/bin/sh", "-c", 'out=$1; shift; exec "$@" > "$out"', "sh", str(listed)]
    run_tool([*to_file, *words], work, readable, work, "llvm-cov")
    counted = {path: lines for path, lines in _counted(listed) if path in candidate.sources}
    common = Path(os.path.commonpath([candidate.folder, *(path.parent for path in counted)]))
    return trace_of(counted, common, work, output)


def _counted(listed: Path) -> Iterator[tuple[Path, dict[int, tuple[int, tuple[int, ...]]]]]:
    """List the lines of each source in a file of LCOV: how often each ran, and how often each way out was taken."""
    for record in made_content(listed).decode().split("end_of_record"):
        source = re.search(r"^SF:(.+)$", record, re.MULTILINE)
        if source is None:
            continue
        counts = {
            int(line): int(count) for line, count in re.findall(r"^DA:(\d+),(\d+)", record, re.MULTILINE)
        }
        branches: dict[int, list[int]] = {}
        for line, taken in re.findall(r"^BRDA:(\d+),\d+,\d+,(\d+|-)", record, re.MULTILINE):
            branches.setdefault(int(line), []).append(0 if taken == "-" else int(taken))
        yield (
            Path(source[1]),
            {line: (count, tuple(branches.get(line, ()))) for line, count in counts.items()},
        )
