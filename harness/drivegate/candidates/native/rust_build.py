"""A second build of a candidate in Rust: the manifest's commands again, with further flags of Rust's compiler."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from drivegate.candidates.candidate import Candidate, NativeBuild
from drivegate.candidates.native.bounded_command import asked
from drivegate.candidates.native.build import built_library
from drivegate.candidates.native.build_commands import ProjectBuild, built_artefact
from drivegate.candidates.native.compiler import Compilation
from drivegate.candidates.native.rust_shim import found_rustc
from drivegate.candidates.native.second_build import OWN_SOURCE
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError


@dataclass(frozen=True)
class RustCompiler:
    release: str
    """Its version."""
    llvm: int
    """Major version of its LLVM, whose tools read what it counts."""
    sysroot: Path
    host: str

    @property
    def is_nightly(self) -> bool:
        """Whether it takes flags that are not stable."""
        return "nightly" in self.release or "dev" in self.release


def rust_build(candidate: Candidate, option: str) -> ProjectBuild:
    """Return how a library is built from sources in Rust; one that is not is refused."""
    details = candidate.details
    assert isinstance(details, NativeBuild), "it is compiled code"
    build = details.made_by
    if not isinstance(build, ProjectBuild) or not any(source.suffix == ".rs" for source in build.sources):
        raise InputError(
            f"{option} needs the sources of '{one_line(candidate.name)}', which is a library: name them in the "
            "manifest's key 'sources' and the command in 'build', such as 'cargo build --release' or 'make'; for C, "
            'kind = "c" without a command does too'
        )
    return build


def rust_compiler(build: ProjectBuild, option: str) -> RustCompiler:
    """Request from the compiler which one it is; a project may choose its own."""
    program = found_rustc()
    if program is None:
        raise InputError(
            f"{option} needs the Rust compiler, but there is no rustc; install Rust from https://rustup.rs"
        )
    version = _printed(program, build.folder, "-vV")
    llvm = re.search(r"^LLVM version: (\d+)", version, re.MULTILINE)
    release = re.search(r"^release: (\S+)", version, re.MULTILINE)
    host = re.search(r"^host: (\S+)", version, re.MULTILINE)
    if llvm is None or release is None or host is None:
        raise InputError(
            f"{option} needs a Rust compiler that works, but {program} -vV states no version of LLVM"
        )
    sysroot = Path(_printed(program, build.folder, "--print", "sysroot").strip())
    return RustCompiler(release[1], int(llvm[1]), sysroot, host[1])


def _printed(program: str, folder: Path, *words: str) -> str:
    return asked([program, *words], folder).output


def second_rust_build(build: ProjectBuild, flags: Sequence[str]) -> Path:
    """Build sources with further flags, or find what was."""
    return built_artefact(replace(build, rust_flags=tuple(flags)))


def stepping_library() -> Path:
    """Compile the function that steps two builds on its own, where these are not compiled by drivegate."""
    library, _ = built_library(Compilation(OWN_SOURCE.parent, (OWN_SOURCE.name,)))
    return library
