"""From an FMU or its manifest to a candidate; the file is only hashed here, a worker process opens it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from drivegate.candidates.candidate import Candidate, hash_of
from drivegate_cases.documents.reach import existing_file

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest
    from drivegate_cases.documents.reach import Reach


def from_text(specification: str) -> Candidate:
    return _candidate(specification, existing_file(Path(specification)), ())


def from_manifest(manifest: Manifest, specification: str, reach: Reach) -> Candidate:
    file, further = manifest.files(specification, reach)
    return _candidate(specification, file, further)


def _candidate(specification: str, file: Path, further: tuple[Path, ...]) -> Candidate:
    name = Path(specification).name
    sources = tuple(dict.fromkeys((file, *further)))
    digest = hash_of(sources, "")
    # Its variables show its contract, which only a worker process reads.
    return Candidate(name, "fmu", specification, str(file), file.parent, sources, digest, contract=None)
