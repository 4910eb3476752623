"""From an FMU or its manifest to a candidate; the file is only hashed here, a worker process opens it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from drivegate.candidates.candidate import Candidate, NativeBuild, existing_folder, hash_of
from drivegate.candidates.native.resolution import built_or_given, project_build
from drivegate_cases.documents.reach import existing_file

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest
    from drivegate_cases.documents.reach import Reach


def from_text(specification: str) -> Candidate:
    file = existing_file(Path(specification))
    return _candidate(specification, file, file, (file,))


def from_manifest(manifest: Manifest, specification: str, reach: Reach) -> Candidate:
    file, further = manifest.files(specification, reach)
    build = project_build(manifest, further, specification, reach.folder)
    fmu, sources = built_or_given(build, file, further)
    return _candidate(specification, file, fmu, sources, manifest.build)


def _candidate(
    specification: str, file: Path, fmu: Path, sources: tuple[Path, ...], commands: tuple[str, ...] = ()
) -> Candidate:
    name = Path(specification).name
    digest = hash_of(sources, repr(commands) if commands else "")
    # Its variables show its contract, which only a worker process reads.
    return Candidate(
        name,
        "fmu",
        specification,
        str(fmu),
        existing_folder(file),
        sources,
        digest,
        details=NativeBuild(fmu),
        contract=None,
    )
