"""Families of scenarios of a PM AC drive, drawn by Hypothesis as whole steps from plain ones."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from typing import Final, TypeAlias

from hypothesis import strategies as st

from drivegate.contracts.duty.scenarios.drawn.beyond import overspeed_scenarios
from drivegate.contracts.duty.scenarios.drawn.changes import (
    hoist_scenarios,
    load_step_scenarios,
    low_speed_scenarios,
    reversal_scenarios,
    speed_step_scenarios,
    start_scenarios,
    supply_step_scenarios,
    torque_step_scenarios,
    torque_supply_step_scenarios,
    weakening_scenarios,
)
from drivegate.contracts.duty.scenarios.drawn.circumstances import (
    false_edge_scenarios,
    joint_change_scenarios,
    lost_sample_scenarios,
    parameter_scenarios,
    position_error_scenarios,
    restart_scenarios,
    sensor_scenarios,
)
from drivegate.contracts.duty.scenarios.drawn.failures import failure_scenarios, that_can_fail
from drivegate.contracts.duty.scenarios.drawn.hot import hot_winding_scenarios, may_be_hot
from drivegate.contracts.duty.scenarios.drawn.linked import link_scenarios
from drivegate.contracts.duty.scenarios.drawn.released import released_scenarios
from drivegate.contracts.duty.scenarios.drawn.sensorless import (
    flying_start_scenarios,
    lost_rotor_scenarios,
    sensorless_load_scenarios,
    sensorless_load_step_scenarios,
    sensorless_parameter_scenarios,
    sensorless_reversal_scenarios,
    sensorless_start_scenarios,
)
from drivegate.contracts.duty.scenarios.drawn.steps import Drawn
from drivegate.scenarios.rotation import goes_backward, is_mirrored, mirrored, needs_reverse
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.failure_kind import FailureKind
from drivegate_cases.scenario.reference import FollowedReference, Reference, reference_of
from drivegate_cases.scenario.scenario import Scenario

Family: TypeAlias = Callable[[PmAcDocument], Drawn]
"""From a drive to scenarios of one kind."""
FAMILY_GROUPS: Final[tuple[tuple[Family, ...], ...]] = (
    (torque_step_scenarios,),
    (weakening_scenarios, overspeed_scenarios),
    (speed_step_scenarios, reversal_scenarios),
    (load_step_scenarios, low_speed_scenarios, hoist_scenarios),
    (
        start_scenarios,
        torque_step_scenarios,
        failure_scenarios,
        restart_scenarios,
        released_scenarios,
        hot_winding_scenarios,
        link_scenarios,
    ),
    (parameter_scenarios,),
    (
        supply_step_scenarios,
        torque_supply_step_scenarios,
        sensor_scenarios,
        position_error_scenarios,
        lost_sample_scenarios,
        false_edge_scenarios,
    ),
    (weakening_scenarios, parameter_scenarios, joint_change_scenarios),
)
"""Families of scenarios that a shard of the search draws from; shards take turns at them."""
SENSORLESS_GROUPS: Final[tuple[tuple[Family, ...], ...]] = (
    (sensorless_start_scenarios, flying_start_scenarios),
    (sensorless_load_scenarios, torque_step_scenarios),
    (sensorless_load_step_scenarios, sensorless_reversal_scenarios),
    (sensorless_parameter_scenarios, lost_rotor_scenarios, weakening_scenarios),
)
"""The same of a drive without a position sensor."""
_OF_BOTH_SENSES: Final = frozenset({reversal_scenarios, hoist_scenarios})
_BACKWARD_SHARE: Final = 4
"""One run in so many is drawn backward."""
_OF_EITHER: Final = frozenset(
    {
        restart_scenarios,
        position_error_scenarios,
        lost_sample_scenarios,
        false_edge_scenarios,
        joint_change_scenarios,
    }
)
_OF_TORQUE: Final = frozenset(
    {
        torque_step_scenarios,
        torque_supply_step_scenarios,
        weakening_scenarios,
        overspeed_scenarios,
        released_scenarios,
        hot_winding_scenarios,
        link_scenarios,
    }
)
_OF_WEAKENING: Final = frozenset({weakening_scenarios, overspeed_scenarios})


def serves(family: Family, drive: PmAcDocument) -> bool:
    """Return True if a drive has what a family's runs are about: field weakening, thermal data, a link of its own."""
    if family in _OF_WEAKENING:
        return drive.weakens
    if family is hot_winding_scenarios:
        return may_be_hot(drive)
    return family is not link_scenarios or drive.real_link is not None


def drawn_scenarios(
    drive: PmAcDocument,
    group: int | None = None,
    references: Collection[FollowedReference] = ("speed", "torque"),
    detected: Collection[FailureKind] = (),
    *,
    reverses: bool = True,
) -> Drawn:
    """Draw a scenario of any family, or of one group of them, as far as a candidate follows or detects it.

    One in four turns backward where both candidate and drive reverse.
    """
    reverses = reverses and drive.one_way_because is None
    failures = partial(failure_scenarios, detected=detected, references=references)
    can_fail = bool(that_can_fail(drive, detected, references))
    followed = [
        [
            failures if family is failure_scenarios else partial(_following, family, references)
            for family in families
            if (reverses or family not in _OF_BOTH_SENSES)
            and serves(family, drive)
            and (can_fail if family is failure_scenarios else _reference(family) in (*references, None))
        ]
        for families in (FAMILY_GROUPS if drive.has_sensor else SENSORLESS_GROUPS)
    ]
    groups = [families for families in followed if families]
    chosen = groups if group is None else [groups[group % len(groups)]]
    drawn = st.one_of([family(drive) for families in chosen for family in families])
    if not reverses:
        return drawn.filter(lambda run: not needs_reverse(run))

    def turned(run: Scenario, backward: bool) -> Scenario:
        return mirrored(run) if backward and is_mirrored(run) and not goes_backward(run) else run

    backward = st.integers(0, _BACKWARD_SHARE - 1).map(lambda number: number == _BACKWARD_SHARE - 1)
    return st.builds(turned, drawn, backward)


def _reference(family: Family) -> Reference | None:
    """Return the reference of a family's runs; None where they have either."""
    if family in _OF_EITHER:
        return None
    return "torque" if family in _OF_TORQUE else "speed"


def _following(family: Family, references: Collection[FollowedReference], drive: PmAcDocument) -> Drawn:
    """Draw the runs of a family that have one of the references."""
    drawn = family(drive)
    return drawn.filter(lambda run: reference_of(run) in references) if family in _OF_EITHER else drawn
