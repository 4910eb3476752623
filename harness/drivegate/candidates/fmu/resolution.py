"""From an FMU or its manifest to a candidate; the file is only hashed here, a worker process opens it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from drivegate.candidates.candidate import Candidate, existing_file, hash_of
from drivegate.candidates.declaration import Declaration

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest


def from_text(specification: str) -> Candidate:
    """Find the candidate that an FMU is."""
    file = existing_file(Path(specification))
    return _candidate(Path(specification).name, specification, file, (), Declaration())


def from_manifest(manifest: Manifest, specification: str, folder: Path) -> Candidate:
    """Find the FMU that a manifest describes."""
    file, further = manifest.files(specification, folder)
    return _candidate(manifest.name, specification, file, further, manifest.declaration())


def _candidate(
    name: str, specification: str, file: Path, further: tuple[Path, ...], declaration: Declaration
) -> Candidate:
    sources = tuple(dict.fromkeys((file, *further)))
    digest = hash_of(sources, "")
    # Its variables show its contract, which only a worker process reads.
    return Candidate(
        name, "fmu", specification, str(file), file.parent, sources, digest, declaration, contract=None
    )
