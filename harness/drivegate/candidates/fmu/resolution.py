"""From an FMU or its manifest to a candidate; the file is only hashed here, a worker process opens it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from drivegate.candidates.candidate import Candidate, existing_file, hash_of
from drivegate.candidates.declaration import Declaration
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest

_SUFFIX: Final = ".fmu"


def from_text(specification: str) -> Candidate:
    """Find the candidate that an FMU is."""
    file = existing_file(Path(specification))
    return _candidate(Path(specification).name, specification, file, (), Declaration())


def from_manifest(manifest: Manifest, specification: str, folder: Path) -> Candidate:
    """Find the FMU that a manifest describes."""
    if Path(manifest.entry).suffix.lower() != _SUFFIX:
        raise InputError(
            f"{shown_path(specification)}: the key 'entry' is '{one_line(manifest.entry)}', but for the kind 'fmu' "
            f"must be a file *{_SUFFIX}"
        )
    file = existing_file(folder / manifest.entry)
    further = tuple(existing_file(folder / source) for source in manifest.sources)
    return _candidate(manifest.name, specification, file, further, manifest.declaration())


def _candidate(
    name: str, specification: str, file: Path, further: tuple[Path, ...], declaration: Declaration
) -> Candidate:
    sources = tuple(dict.fromkeys((file, *further)))
    digest = hash_of(sources, "")
    # Its variables tell its contract, which only a worker process reads.
    return Candidate(
        name, "fmu", specification, str(file), file.parent, sources, digest, declaration, contract=None
    )
