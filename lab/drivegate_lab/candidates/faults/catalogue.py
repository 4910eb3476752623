"""Every faulty controller, by kind of fault."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, TypeVar

from drivegate_cases.documents.wording import nearest, one_line
from drivegate_lab.candidates.faults import (
    clocks,
    instances,
    measurements,
    regions,
    regulation,
    searches,
    tolerances,
)
from drivegate_models.errors import InputError

FaultT = TypeVar("FaultT")

_KINDS: Final = (
    measurements.POWER_ESTIMATE_FAULTS,
    regulation.COMMAND_FAULTS,
    searches.ANGLE_MODEL_FAULTS,
    searches.SEARCH_FAULTS,
    regulation.REGULATOR_FAULTS,
    clocks.CLOCK_FAULTS,
    clocks.CONTROL_PERIOD_FAULTS,
    measurements.FILTER_FAULTS,
    regulation.DERATING_FAULTS,
    regions.FAULTS,
    measurements.SAMPLE_FAULTS,
    instances.FAULTS,
    tolerances.FAULTS,
    searches.FLOWCHART_FAULTS,
)

MUTATIONS: Final = MappingProxyType({mutation.name: mutation for kind in _KINDS for mutation in kind})
"""Every faulty controller by its name, in the order of the kinds."""


def find_fault(name: str, known: Mapping[str, FaultT]) -> FaultT:
    """Find a faulty controller among those of a contract."""
    if name not in known:
        raise InputError(
            f"the faulty controller '{one_line(name)}' is unknown, the nearest known one is "
            f"'{nearest(name, known)}'; known are {', '.join(known)}"
        )
    return known[name]
