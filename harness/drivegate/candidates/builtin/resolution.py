"""From the name of a built-in controller, or a manifest with it, to a candidate."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES, DUTY_CANDIDATES
from drivegate.candidates.builtin.prefixed import family_of
from drivegate.candidates.candidate import Candidate, hash_of
from drivegate.candidates.declaration import Declaration
from drivegate.version import __version__
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.contract import ContractName
    from drivegate.candidates.manifest import Manifest
    from drivegate_cases.documents.reach import Reach


def from_text(specification: str) -> Candidate:
    found = family_of(specification)
    if found is not None:
        family, name = found
        return _candidate(specification, specification, family.declaration(name), family.contract(name))
    declaration = {**BUILTIN_CANDIDATES, **DUTY_CANDIDATES}[specification]
    return _candidate(specification, specification, declaration, _contract_of(specification))


def from_manifest(manifest: Manifest, specification: str, reach: Reach) -> Candidate:  # noqa: ARG001  (as all kinds)
    """Find the controller that a manifest names, which has no prefix."""
    known = (*BUILTIN_CANDIDATES, *DUTY_CANDIDATES)
    if manifest.entry not in known:
        raise InputError(
            f"{shown_path(specification)}: the key 'entry' is '{one_line(manifest.entry)}', but must be "
            f"one of the built-in candidates {', '.join(known)}"
        )
    return _candidate(specification, manifest.entry, manifest.declaration(), _contract_of(manifest.entry))


def _contract_of(name: str) -> ContractName:
    return "duty" if name in DUTY_CANDIDATES else "current"


def _candidate(specification: str, entry: str, declaration: Declaration, contract: ContractName) -> Candidate:
    # Its code has no file of its own, so drivegate's version is hashed instead.
    digest = hash_of((), f"drivegate {__version__} {entry}")
    return Candidate(
        entry, "builtin", specification, entry, Path.cwd(), (), digest, declaration, contract=contract
    )
