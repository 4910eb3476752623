"""Every faulty controller, by kind of fault."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, TypeVar

from drivegate.candidates.builtin.faults import (
    angle_models,
    clocks,
    commands,
    control_period,
    derating,
    filters,
    flowchart,
    instances,
    power_estimate,
    regions,
    regulation,
    samples,
    searches,
    tolerances,
)
from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate_cases.documents.wording import nearest, one_line
from drivegate_models.errors import InputError

FaultT = TypeVar("FaultT")

_KINDS: Final = (
    power_estimate.FAULTS,
    commands.FAULTS,
    angle_models.FAULTS,
    searches.FAULTS,
    regulation.FAULTS,
    clocks.FAULTS,
    control_period.FAULTS,
    filters.FAULTS,
    derating.FAULTS,
    regions.FAULTS,
    samples.FAULTS,
    instances.FAULTS,
    tolerances.FAULTS,
    flowchart.FAULTS,
)

MUTATIONS: Final = MappingProxyType({mutation.name: mutation for kind in _KINDS for mutation in kind})
"""Every faulty controller by its name, in the order of the kinds."""


def find_mutation(name: str) -> Mutation:
    """Find a faulty controller."""
    return find_fault(name, MUTATIONS)


def find_fault(name: str, known: Mapping[str, FaultT]) -> FaultT:
    """Find a faulty controller among those of a contract."""
    if name not in known:
        raise InputError(
            f"the faulty controller '{one_line(name)}' is unknown, the nearest known one is "
            f"'{nearest(name, known)}'; known are {', '.join(known)}"
        )
    return known[name]
