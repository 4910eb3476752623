"""From the one string that names a candidate to what it is: its kind, entry, sources and declaration.

Nothing here runs a candidate's code. Whether the class exists and has its methods shows when a worker process
loads it.
"""

import hashlib
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING

from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES
from drivegate.candidates.builtin.design_candidates import DESIGN_PREFIX, design_declaration
from drivegate.candidates.candidate import Candidate, existing_file, hash_of
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.module_search import module_sources
from drivegate.version import __version__
from drivegate_cases.documents.wording import nearest, one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest

ENTRY_POINT_GROUP = "drivegate.controllers"

FAULTY_PREFIX = "faulty:"
"""What a faulty controller's name begins with; such controllers check the checks."""

EXEC_PREFIX = "exec:"
"""What the command line of a candidate that is a program begins with."""

_WAYS = (
    "module:Class, file.py:Class, file.c, file.so, file.fmu, exec:command, candidate.toml or the name of a built-in "
    "or installed controller"
)


def resolve_candidate(text: str) -> Candidate:
    """Find the candidate that a string names."""
    specification = text.strip()
    if not specification:
        raise InputError(f"the candidate's name is empty, but must be {_WAYS}")
    if "\0" in specification:
        raise InputError(
            f"the candidate '{one_line(specification)}' has a zero byte in it, but must be {_WAYS}"
        )
    if specification.startswith(EXEC_PREFIX):
        from drivegate.candidates.program.candidate import exec_candidate

        return exec_candidate(specification)
    if specification.startswith(FAULTY_PREFIX):
        return _faulty_candidate(specification)
    if specification.startswith(DESIGN_PREFIX):
        declaration = design_declaration(specification)
        return _builtin_candidate(specification, specification, specification, declaration)
    suffix = Path(specification).suffix.lower()
    if suffix in (".c", ".so"):
        from drivegate.candidates.native.candidate import native_candidate

        return native_candidate(specification)
    if suffix == ".fmu":
        from drivegate.candidates.fmu.candidate import fmu_candidate

        return fmu_candidate(specification)
    if suffix == ".toml":
        return _from_manifest(specification)
    if suffix == ".py":
        raise InputError(
            f"the candidate '{one_line(specification)}' names no class; write {one_line(specification)}:Class"
        )
    if ":" in specification:
        return _python_candidate(_short_name(specification), specification, specification, Path.cwd())
    return _from_bare_name(specification)


def _short_name(specification: str) -> str:
    """Leave out the folder, so that a waiver matches wherever the file lies."""
    source, _, attribute = specification.rpartition(":")
    return f"{Path(source).name}:{attribute}"


def _from_bare_name(name: str) -> Candidate:
    if name in BUILTIN_CANDIDATES:
        return _builtin_candidate(name, name, name, BUILTIN_CANDIDATES[name])
    installed = {point.name: point for point in entry_points(group=ENTRY_POINT_GROUP)}
    if name in installed:
        point = installed[name]
        return _python_candidate(name, name, f"{point.module}:{point.attr}", Path.cwd())
    known = [*BUILTIN_CANDIDATES, *sorted(installed)]
    raise InputError(
        f"the candidate '{one_line(name)}' is unknown, the nearest known one is "
        f"'{nearest(name, known)}'; known are {', '.join(known)}, or write {_WAYS}"
    )


def _faulty_candidate(specification: str) -> Candidate:
    # Their registry is only read where one of them is named.
    from drivegate.candidates.builtin.faults import find_mutation

    mutation = find_mutation(specification.removeprefix(FAULTY_PREFIX))
    declaration = BUILTIN_CANDIDATES[mutation.base]
    return _builtin_candidate(specification, specification, specification, declaration)


def _builtin_candidate(name: str, specification: str, entry: str, declaration: Declaration) -> Candidate:
    digest = hashlib.sha256(f"drivegate {__version__} {entry}".encode()).hexdigest()
    return Candidate(name, "builtin", specification, entry, Path.cwd(), (), digest, declaration)


def _python_candidate(
    name: str,
    specification: str,
    entry: str,
    folder: Path,
    further_sources: tuple[Path, ...] = (),
    declaration: Declaration | None = None,
) -> Candidate:
    source, _, attribute = entry.rpartition(":")
    if not all(part.isidentifier() for part in attribute.split(".")):
        raise InputError(
            f"the candidate '{one_line(specification)}' names the class '{one_line(attribute)}', which is no "
            "name of a Python class; write module:Class or file.py:Class"
        )
    if source.endswith(".py"):
        file = existing_file(folder / source)
        found: tuple[Path, ...] = (file,)
        entry, folder = f"{file}:{attribute}", file.parent
    else:
        found = module_sources(source, folder, specification)
    sources = tuple(dict.fromkeys((*found, *further_sources)))
    return Candidate(
        name,
        "python",
        specification,
        entry,
        folder,
        sources,
        hash_of(sources, attribute),
        declaration or Declaration(),
    )


def _from_manifest(specification: str) -> Candidate:
    # Reading a manifest needs pydantic, which takes longer to import than all the rest of this module.
    from drivegate.candidates.manifest import Manifest
    from drivegate_cases.documents.document import read_document

    manifest = read_document(specification, Manifest)
    folder = Path(specification).resolve().parent
    if manifest.kind == "builtin":
        return _builtin_from_manifest(manifest, specification)
    if manifest.kind in ("c", "so"):
        from drivegate.candidates.native.candidate import native_from_manifest

        return native_from_manifest(manifest, specification, folder)
    if manifest.kind == "fmu":
        from drivegate.candidates.fmu.candidate import fmu_from_manifest

        return fmu_from_manifest(manifest, specification, folder)
    if manifest.kind == "exec":
        from drivegate.candidates.program.candidate import exec_from_manifest

        return exec_from_manifest(manifest, specification, folder)
    if manifest.kind == "compose":
        from drivegate.candidates.composed.candidate import composed_from_manifest

        return composed_from_manifest(manifest, specification, folder)
    if ":" not in manifest.entry:
        raise InputError(
            f"{shown_path(specification)}: the key 'entry' is '{one_line(manifest.entry)}', "
            "but must be module:Class or file.py:Class"
        )
    sources = tuple(existing_file(folder / source) for source in manifest.sources)
    return _python_candidate(
        manifest.name, specification, manifest.entry, folder, sources, manifest.declaration()
    )


def _builtin_from_manifest(manifest: "Manifest", specification: str) -> Candidate:
    if manifest.entry not in BUILTIN_CANDIDATES:
        raise InputError(
            f"{shown_path(specification)}: the key 'entry' is '{one_line(manifest.entry)}', but must be "
            f"one of the built-in candidates {', '.join(BUILTIN_CANDIDATES)}"
        )
    return _builtin_candidate(manifest.name, specification, manifest.entry, manifest.declaration())
