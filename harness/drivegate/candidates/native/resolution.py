"""From a C source, a shared library or their manifest to a candidate; a source is compiled here, but not run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from drivegate.candidates.candidate import Candidate, NativeBuild, existing_file, hash_of
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.native.compiler import Compilation
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest

_SUFFIXES: Final = {".c": "c", ".so": "so"}

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
)
_REFUSED_WORDS: Final = ("-c", "-E", "-S", "-fsyntax-only", "-r", "--help", "--version", "-", "-###")


def from_text(specification: str) -> Candidate:
    """Find the candidate that a C source or a shared library is."""
    file = existing_file(Path(specification))
    name = Path(specification).name
    if _SUFFIXES[file.suffix.lower()] == "so":
        return _library_candidate(name, specification, file, ())
    return _source_candidate(name, specification, file, Compilation(file.parent, (file.name,)))


def from_manifest(manifest: Manifest, specification: str, folder: Path) -> Candidate:
    """Find the native candidate that a manifest describes."""
    where = shown_path(specification)
    entry = existing_file(folder / manifest.entry)
    if _SUFFIXES.get(entry.suffix.lower()) != manifest.kind:
        raise InputError(
            f"{where}: the key 'entry' is '{one_line(manifest.entry)}', but for the kind '{manifest.kind}' must be "
            f"a file *.{manifest.kind}"
        )
    further = tuple(existing_file(folder / source) for source in manifest.sources)
    declaration = manifest.declaration()
    if manifest.kind == "so":
        return _library_candidate(manifest.name, specification, entry, further, declaration)
    for include in manifest.include:
        if not (folder / include).is_dir():
            raise InputError(f"{where}: the key 'include' names '{one_line(include)}', which is no folder")
    for flag in manifest.flags:
        _check_flag(flag, where)
    compiled = dict.fromkeys(
        name for name in (manifest.entry, *manifest.sources) if name.lower().endswith(".c")
    )
    others = tuple(file for file in further if file.suffix.lower() != ".c")
    plan = Compilation(folder, tuple(compiled), manifest.include, manifest.flags, others)
    return _source_candidate(manifest.name, specification, entry, plan, declaration)


def _check_flag(flag: str, where: str) -> None:
    if not flag.startswith("-"):
        raise InputError(
            f"{where}: the key 'flags' has '{one_line(flag)}', which is no flag; each must begin with '-' and have "
            "its value in the same text, as in '-DGAIN=2'"
        )
    if flag in _REFUSED_WORDS or flag.startswith(_REFUSED_FLAGS):
        raise InputError(
            f"{where}: the key 'flags' has '{one_line(flag)}', but what the compiler writes and runs is for drivegate "
            "to say; give flags that define, optimise, warn or link, such as '-DGAIN=2', '-O3' or '-lname'"
        )


def _library_candidate(
    name: str,
    specification: str,
    file: Path,
    further: tuple[Path, ...],
    declaration: Declaration | None = None,
) -> Candidate:
    from drivegate.candidates.native.shared_library import check_shared_library

    check_shared_library(file)
    sources = tuple(dict.fromkeys((file, *further)))
    return _candidate(name, "so", specification, file, sources, "", declaration, NativeBuild(file))


def _source_candidate(
    name: str, specification: str, file: Path, plan: Compilation, declaration: Declaration | None = None
) -> Candidate:
    from drivegate.candidates.native.build import built_library

    library, files = built_library(plan)
    sources = tuple(dict.fromkeys((*files, *plan.further_files)))
    flags = "\0".join(plan.flags)
    return _candidate(name, "c", specification, file, sources, flags, declaration, NativeBuild(library))


def _candidate(
    name: str,
    kind: str,
    specification: str,
    file: Path,
    sources: tuple[Path, ...],
    flags: str,
    declaration: Declaration | None,
    build: NativeBuild,
) -> Candidate:
    from drivegate.candidates.native.exports import contract_served

    return Candidate(
        name,
        kind,
        specification,
        str(file),
        file.parent,
        sources,
        hash_of(sources, flags),
        declaration or Declaration(),
        build,
        contract=contract_served(build.library),
    )
