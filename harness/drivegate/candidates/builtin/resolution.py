"""From the name of a built-in controller, or a manifest with it, to a candidate."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES, DUTY_CANDIDATES
from drivegate.candidates.builtin.prefixed import family_of
from drivegate.candidates.candidate import Candidate
from drivegate.candidates.declaration import Declaration
from drivegate.version import __version__
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.contract import ContractName
    from drivegate.candidates.manifest import Manifest


def from_text(specification: str) -> Candidate:
    """Find a controller by its bare name, or by its name with a prefix."""
    return _candidate(specification, specification, specification, _declaration_of(specification))


def from_manifest(manifest: Manifest, specification: str, folder: Path) -> Candidate:  # noqa: ARG001  (as all kinds)
    """Find the controller that a manifest names; it has a declaration of its own."""
    known = (*BUILTIN_CANDIDATES, *DUTY_CANDIDATES)
    if manifest.entry not in known:
        raise InputError(
            f"{shown_path(specification)}: the key 'entry' is '{one_line(manifest.entry)}', but must be "
            f"one of the built-in candidates {', '.join(known)}"
        )
    return _candidate(manifest.name, specification, manifest.entry, manifest.declaration())


def _declaration_of(entry: str) -> Declaration:
    found = family_of(entry)
    if found is not None:
        family, name = found
        return family.declaration(name)
    return DUTY_CANDIDATES[entry] if entry in DUTY_CANDIDATES else BUILTIN_CANDIDATES[entry]


def _contract_of(entry: str) -> ContractName:
    found = family_of(entry)
    if found is not None:
        family, name = found
        return family.contract(name)
    return "duty" if entry in DUTY_CANDIDATES else "current"


def _candidate(name: str, specification: str, entry: str, declaration: Declaration) -> Candidate:
    digest = hashlib.sha256(f"drivegate {__version__} {entry}".encode()).hexdigest()
    return Candidate(
        name,
        "builtin",
        specification,
        entry,
        Path.cwd(),
        (),
        digest,
        declaration,
        contract=_contract_of(entry),
    )
