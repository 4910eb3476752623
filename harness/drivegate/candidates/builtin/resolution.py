"""From the name of a controller that comes with drivegate, or a manifest with it, to a candidate."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

from drivegate.candidates.builtin.candidates import (
    BUILTIN_CANDIDATES,
    DESIGN_CANDIDATES,
    DUTY_CANDIDATES,
)
from drivegate.candidates.candidate import Candidate
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.kinds import DESIGN_PREFIX, FAULTY_PREFIX, NEAR_PREFIX
from drivegate.version import __version__
from drivegate_cases.documents.wording import nearest, one_line, shown_path
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


def _declaration_of(name: str) -> Declaration:
    if _answers_with_duty_ratios(name):
        # A faulty one declares what the controller does that it is a variation of.
        return DUTY_CANDIDATES.get(name, DUTY_CANDIDATES["foc"])
    if name.startswith(FAULTY_PREFIX):
        # Their registry is only read where one of them is named.
        from drivegate.candidates.builtin.faults.catalogue import find_mutation

        return BUILTIN_CANDIDATES[find_mutation(name.removeprefix(FAULTY_PREFIX)).base]
    if name.startswith(NEAR_PREFIX):
        return _near_declaration(name)
    if name.startswith(DESIGN_PREFIX):
        return _design_declaration(name)
    return BUILTIN_CANDIDATES[name]


def _answers_with_duty_ratios(name: str) -> bool:
    if not name.startswith(FAULTY_PREFIX):
        return name in DUTY_CANDIDATES
    # Their registry is only read where a faulty controller is named.
    from drivegate.candidates.builtin.duty_faults import DUTY_FAULTS

    return name.removeprefix(FAULTY_PREFIX) in DUTY_FAULTS


def _design_declaration(name: str) -> Declaration:
    if name in DESIGN_CANDIDATES:
        return DESIGN_CANDIDATES[name]
    raise _unknown(name, list(DESIGN_CANDIDATES))


def _near_declaration(name: str) -> Declaration:
    from drivegate.candidates.builtin.faults.tolerances import NEAR_DESIGNS

    names = [f"{NEAR_PREFIX}{design}" for design in NEAR_DESIGNS]
    if name in names:
        return BUILTIN_CANDIDATES[NEAR_DESIGNS[name.removeprefix(NEAR_PREFIX)].base]
    raise _unknown(name, names)


def _unknown(name: str, known: list[str]) -> InputError:
    return InputError(
        f"the candidate '{one_line(name)}' is unknown, the nearest known one is "
        f"'{nearest(name, known)}'; known are {', '.join(known)}"
    )


def _candidate(name: str, specification: str, entry: str, declaration: Declaration) -> Candidate:
    digest = hashlib.sha256(f"drivegate {__version__} {entry}".encode()).hexdigest()
    contract: ContractName = "duty" if _answers_with_duty_ratios(entry) else "current"
    return Candidate(
        name, "builtin", specification, entry, Path.cwd(), (), digest, declaration, contract=contract
    )
