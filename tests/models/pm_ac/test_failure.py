"""What fails in a run of a PM AC drive: from its control period on, and nothing else with it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from drivegate_models.contract.duty.records import duty_sense_record
from drivegate_models.contract.duty.signals import LEG_OFF, LEG_PWM
from drivegate_models.pm_ac.failure import (
    LOCKED_ROTOR,
    LOST_EDGE,
    LOST_POSITION,
    NOTHING,
    OPEN_PHASE,
    STUCK_CURRENT,
    Failure,
    fail_legs,
    fails_now,
    has_failed,
    make_failure,
    show_failed,
)

pytestmark = pytest.mark.kernel


def shown(failure: Failure, *, is_exact: bool = True) -> list[tuple[float, ...]]:
    """Return the currents, angle and speed that six steps show, which truly are 0, 1, 2 ... in each step."""
    currents = np.zeros(3)
    sense: Any = duty_sense_record(currents).view(np.recarray)[0]
    rows = []
    for k in range(6):
        currents[:] = (k, 10 + k, 20 + k)
        sense.angle = 30.0 + k
        sense.speed = 40.0 + k
        show_failed(failure, k, currents, sense, is_exact)
        rows.append((*map(float, currents), float(sense.angle), float(sense.speed)))
    return rows


TRUE = [(0.0 + k, 10.0 + k, 20.0 + k, 30.0 + k, 40.0 + k) for k in range(6)]


@pytest.mark.parametrize("kind", [NOTHING, OPEN_PHASE, LOCKED_ROTOR, LOST_EDGE])
def test_what_is_no_failure_of_a_sensor_changes_nothing_that_is_shown(kind: int) -> None:
    assert shown(make_failure(kind, 3, 1)) == TRUE


@pytest.mark.parametrize("leg", [0, 1, 2])
def test_a_stuck_sensor_goes_on_showing_its_last_current_and_the_others_theirs(leg: int) -> None:
    expected = [list(row) for row in TRUE]
    for row in expected[3:]:
        row[leg] = TRUE[2][leg]
    assert shown(make_failure(STUCK_CURRENT, 3, leg)) == [tuple(row) for row in expected]


def test_a_lost_position_stays_where_it_was_with_its_speed() -> None:
    expected = [*TRUE[:3], *((*row[:3], *TRUE[2][3:]) for row in TRUE[3:])]
    assert shown(make_failure(LOST_POSITION, 3)) == expected


def test_a_position_by_edges_is_not_touched_for_its_sensor_knows_that_none_came() -> None:
    assert shown(make_failure(LOST_POSITION, 3), is_exact=False) == TRUE


@pytest.mark.parametrize("leg", [0, 1, 2])
def test_an_open_phase_has_its_leg_off_from_its_period_on(leg: int) -> None:
    failure = make_failure(OPEN_PHASE, 3, leg)
    for k in (2, 3, 4):
        legs = np.full(3, LEG_PWM, np.int64)
        fail_legs(failure, k, legs)
        assert [leg for leg in range(3) if legs[leg] == LEG_OFF] == ([leg] if k >= 3 else [])


@pytest.mark.parametrize("kind", [NOTHING, STUCK_CURRENT, LOST_POSITION, LOCKED_ROTOR, LOST_EDGE])
def test_other_failures_leave_the_legs_alone(kind: int) -> None:
    legs = np.full(3, LEG_PWM, np.int64)
    fail_legs(make_failure(kind, 0, 1), 5, legs)
    assert list(legs) == [LEG_PWM] * 3


def test_only_what_fails_has_failed_and_only_from_then_on() -> None:
    failure = make_failure(LOCKED_ROTOR, 3)
    assert [has_failed(failure, LOCKED_ROTOR, k) for k in (2, 3, 4)] == [False, True, True]
    assert not has_failed(failure, OPEN_PHASE, 4)


def test_an_edge_is_lost_once() -> None:
    failure = make_failure(LOST_EDGE, 3)
    assert [fails_now(failure, LOST_EDGE, k) for k in (2, 3, 4)] == [False, True, False]
    assert not fails_now(failure, LOST_POSITION, 3)
