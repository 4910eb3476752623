"""From a source in C or C++, a library or their manifest to a candidate; a source is compiled here, but not run."""

from __future__ import annotations

import mmap
import platform
import re
import struct
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from drivegate.candidates.candidate import Candidate, NativeBuild, existing_folder, hash_of
from drivegate.candidates.contract import ContractName
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.native.compiler import Compilation
from drivegate_cases.documents.reach import existing_file
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest
    from drivegate.candidates.native.build_commands import ProjectBuild
    from drivegate_cases.documents.reach import Reach

_MAGIC: Final = b"\x7fELF"
_HEADER: Final = struct.Struct("<4xBB10xHH")
_SHARED: Final = 3
_MACHINES: Final = {
    3: "i686",
    20: "ppc",
    21: "ppc64le",
    22: "s390x",
    40: "arm",
    62: "x86_64",
    183: "aarch64",
    243: "riscv64",
    258: "loongarch64",
}
_OTHER_NAMES: Final = {"amd64": "x86_64", "arm64": "aarch64", "ppc64": "ppc64le"}
# A name in a table of symbols ends with a zero byte and begins behind one, on macOS with an underscore.
_STEP_NAMES: Final[dict[ContractName, re.Pattern[bytes]]] = {
    "current": re.compile(rb"[\0_]drivegate_step\0"),
    "duty": re.compile(rb"[\0_]drivegate_duty_step\0"),
}

# These change what the compiler writes, or which programs it starts.
_REFUSED_FLAGS: Final = (
    "-o",
    "-M",
    "-fplugin",
    "-wrapper",
    "-specs",
    "--specs",
    "-B",
    "-x",
    "-save-temps",
    "-pipe",
    "-Wp,-M",
    "-Wl,-plugin",
    "-Wl,--plugin",
)
_OTHER_WIDTHS: Final = ("-m32", "-mx32", "-m16")
_OF_64_BITS: Final = (
    "a process of 64 bits loads no library of 32: use types of fixed width such as int32_t and leave the flag out, or "
    'link an image for the target (kind = "elf"), or start a program of 32 bits (kind = "exec")'
)
_REFUSED_WORDS: Final = ("-c", "-E", "-S", "-fsyntax-only", "-r", "--help", "--version", "-", "-###")


def from_text(specification: str) -> Candidate:
    file = existing_file(Path(specification))
    if file.suffix.lower() == ".so":
        return _library_candidate(specification, file, file, (file,))
    return _source_candidate(specification, file, Compilation(file.parent, (file.name,)))


def from_manifest(manifest: Manifest, specification: str, reach: Reach) -> Candidate:
    where, folder = shown_path(specification), reach.folder
    entry, further = manifest.files(specification, reach)
    if manifest.kind == "so":
        build = project_build(manifest, further, specification, folder)
        library, sources = built_or_given(build, entry, further)
        return _library_candidate(specification, entry, library, sources, build)
    for include in manifest.include:
        if not reach.place(include, f"{where}: a folder of the key 'include'").is_dir():
            raise InputError(f"{where}: the key 'include' names '{one_line(include)}', which is no folder")
    for flag in manifest.flags:
        _check_flag(flag, where)
    files = dict.fromkeys((entry, *further))
    are_sources = {file: file.suffix.lower() in KINDS["c"].suffixes for file in files}
    compiled = tuple(_named(file, folder) for file, is_source in are_sources.items() if is_source)
    others = tuple(file for file in further if not are_sources[file])
    plan = Compilation(folder, compiled, manifest.include, manifest.flags, others)
    return _source_candidate(specification, entry, plan)


def _named(file: Path, folder: Path) -> str:
    """Name a source as messages of the compiler show it: in the manifest's folder without that folder."""
    return str(file.relative_to(folder)) if file.is_relative_to(folder) else str(file)


def _check_flag(flag: str, where: str) -> None:
    if not flag.startswith("-"):
        raise InputError(
            f"{where}: the key 'flags' has '{one_line(flag)}', which is no flag; each must begin with '-' and have "
            "its value in the same text, as in '-DGAIN=2'"
        )
    if flag in _OTHER_WIDTHS:
        raise InputError(f"{where}: the key 'flags' has '{flag}', but {_OF_64_BITS}")
    if flag in _REFUSED_WORDS or flag.startswith(_REFUSED_FLAGS):
        raise InputError(
            f"{where}: the key 'flags' has '{one_line(flag)}', but what the compiler writes and runs is for drivegate "
            "to say; give flags that define, optimise, warn or link, such as '-DGAIN=2', '-O3' or '-lname'"
        )


def _library_candidate(
    specification: str,
    file: Path,
    library: Path,
    sources: tuple[Path, ...],
    build: ProjectBuild | None = None,
) -> Candidate:
    _check_shared_library(library)
    commands = () if build is None else build.commands
    return _candidate("so", specification, file, sources, commands, NativeBuild(library, build))


def project_build(
    manifest: Manifest, further: tuple[Path, ...], specification: str, folder: Path
) -> ProjectBuild | None:
    """Return how the manifest's commands make its file; None where it has no commands."""
    from drivegate.candidates.native.build_commands import ProjectBuild

    if not manifest.build:
        return None
    return ProjectBuild(shown_path(specification), folder, manifest.build, further, manifest.entry)


def built_or_given(
    build: ProjectBuild | None, entry: Path, further: tuple[Path, ...]
) -> tuple[Path, tuple[Path, ...]]:
    """Return the file that is loaded, built if there are commands for it, and the files of the hash."""
    from drivegate.candidates.native.build_commands import built_artefact

    if build is None:
        return entry, tuple(dict.fromkeys((entry, *further)))
    return built_artefact(build), further


def _source_candidate(specification: str, file: Path, plan: Compilation) -> Candidate:
    from drivegate.candidates.native.build import built_library

    library, files = built_library(plan)
    sources = tuple(dict.fromkeys((*files, *plan.further_files)))
    return _candidate("c", specification, file, sources, plan.flags, NativeBuild(library, plan))


def _candidate(
    kind: str,
    specification: str,
    file: Path,
    sources: tuple[Path, ...],
    words: tuple[str, ...],
    build: NativeBuild,
) -> Candidate:
    """Describe a library; `words` made it from the sources, so the hash covers them too."""
    return Candidate(
        Path(specification).name,
        kind,
        specification,
        str(file),
        existing_folder(file),
        sources,
        hash_of(sources, "\0".join(words)),
        details=build,
        contract=contract_served(build.library),
    )


def contract_served(library: Path) -> ContractName | None:
    """Return the contract whose step a library names, without running it; None where it names both or neither."""
    # An empty file cannot be mapped.
    if library.stat().st_size == 0:
        return None
    # Mapped, since a library may be far larger than its table of names.
    with library.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        served = [contract for contract, name in _STEP_NAMES.items() if name.search(content)]
    return served[0] if len(served) == 1 else None


class ElfHeader(NamedTuple):
    """The beginning of an ELF file (System V ABI, "ELF Header")."""

    word_size: int
    """1 for 32 bits, 2 for 64."""
    byte_order: int
    """1 for little-endian."""
    kind: int
    """2 for an executable, 3 for a shared object."""
    machine: int
    """Number of the processor's architecture."""


def elf_header(file: Path) -> ElfHeader | None:
    """Read the beginning of an ELF file; None for a file of another kind."""
    try:
        with file.open("rb") as stream:
            beginning = stream.read(_HEADER.size)
    except OSError as error:
        raise InputError(
            f"{shown_path(file)} cannot be read: {error.strerror}; name a readable file"
        ) from error
    is_elf = len(beginning) == _HEADER.size and beginning.startswith(_MAGIC)
    return ElfHeader._make(_HEADER.unpack(beginning)) if is_elf else None


def _check_shared_library(file: Path) -> None:
    """Refuse a file that is no shared library for this machine."""
    if not sys.platform.startswith("linux"):
        return
    header = elf_header(file)
    problem = _problem(header)
    if header is not None and header.word_size == 1:
        raise InputError(f"{shown_path(file)} {problem}; {_OF_64_BITS}")
    if problem:
        raise InputError(f"{shown_path(file)} {problem}; compile it on this machine with cc -shared -fPIC")


def _problem(header: ElfHeader | None) -> str:
    if header is None:
        return "is no shared library"
    here = platform.machine().lower()
    here = _OTHER_NAMES.get(here, here)
    there = _MACHINES.get(header.machine, f"machine {header.machine}")
    if header.word_size != 2 or header.byte_order != 1:
        bits = "32-bit" if header.word_size == 1 else "64-bit"
        end = "little" if header.byte_order == 1 else "big"
        return f"is {bits} and {end}-endian, but this machine is {here}"
    if there != here:
        return f"is compiled for {there}, but this machine is {here}"
    return "" if header.kind == _SHARED else "is compiled code, but no shared library"
