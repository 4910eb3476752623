"""The controllers that are included, what they declare, and from the name of one to a candidate."""

from __future__ import annotations

import hashlib
import re
from math import radians
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.declaration import Declaration, FlowchartProfile
from drivegate.candidates.kinds import DESIGN_PREFIX, FAULTY_PREFIX, NEAR_PREFIX
from drivegate.version import __version__
from drivegate_cases.documents.wording import nearest, one_line, shown_path
from drivegate_cases.scenario.failure_kind import FAILURE_KINDS
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate.candidates.contract import ContractName
    from drivegate.candidates.manifest import Manifest

BUILTIN_CANDIDATES: Final = MappingProxyType(
    {
        "reference": Declaration(estimates_power=True),
        "published": Declaration(
            flowchart=FlowchartProfile(
                speed_tolerance=5.0 * RADIANS_PER_RPM,
                power_tolerance=0.0,
                power_tolerance_fraction=0.001,
                step=radians(1),
                period=0.1,
            ),
            estimates_power=True,
        ),
        "initial": Declaration(estimates_power=True),
    }
)
"""Declarations by bare name."""

DUTY_CANDIDATES: Final = MappingProxyType(
    {
        name: Declaration(detects=FAILURE_KINDS)
        for name in (
            "foc",
            "foc-mtpa",
            "foc-loss-model",
            "foc-loss-search",
            "predictive-flux",
            "direct-torque",
        )
    }
)
"""Declarations of those that answer with duty ratios, by bare name."""

_DESIGNS = ("golden-section", "quadratic-interpolation", "angle-table", "sweep")

DESIGN_CANDIDATES: Final = MappingProxyType(
    {f"{DESIGN_PREFIX}{design}": Declaration(estimates_power=True) for design in _DESIGNS}
)
"""Declarations of correct candidates of other designs than the reference controller, by name with the prefix.

The harness tests itself with them: no check may accuse a correct controller, whatever its design.
"""

_PREFIXED: Final = re.compile(f"({FAULTY_PREFIX}|{DESIGN_PREFIX}|{NEAR_PREFIX})[a-z0-9-]+")


def is_builtin_name(text: str) -> bool:
    """Return True if a text has the form of the name of a candidate that comes with drivegate, and of nothing else."""
    return text in BUILTIN_CANDIDATES or text in DUTY_CANDIDATES or _PREFIXED.fullmatch(text) is not None


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
