"""What current regulators do at the voltage limit, and how they compensate dead time and drops."""

from __future__ import annotations

from math import hypot
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate_models.contract.duty.records import duty_sense_record
from drivegate_models.controllers.duty.current_regulator import (
    _compensated_ratio,
    _ripple_at_edge,
    limited_request,
    voltage_limit,
)
from drivegate_models.controllers.duty.state import foc_state

pytestmark = pytest.mark.kernel
LIMIT = 173.0


def test_decoupling_remains_where_the_currents_only_move_a_little_more_slowly() -> None:
    direct, quadrature = limited_request((-30.0, 104.0), (0.0, 100.0), (27.0, 0.0), LIMIT)
    assert direct == pytest.approx(-3.0)
    assert hypot(direct, quadrature) == pytest.approx(LIMIT)


def test_the_currents_move_before_they_are_decoupled_where_the_limit_leaves_too_little() -> None:
    # Whole decoupling would leave 4 V of 60 V.
    direct, quadrature = limited_request((0.0, 130.0), (0.0, 60.0), (110.0, 0.0), LIMIT)
    assert direct == pytest.approx(0.0, abs=1e-9)
    assert quadrature == pytest.approx(LIMIT)


def test_decoupling_remains_in_a_long_step_that_takes_all_of_the_voltage_either_way() -> None:
    # Currents that are reversed: a hundredth of the requested voltage fits, with decoupling and without.
    direct, quadrature = limited_request((0.0, 40.0), (0.0, 10_000.0), (60.0, 0.0), LIMIT)
    assert direct == pytest.approx(60.0), "the d current is left to the rotation"
    assert hypot(direct, quadrature) == pytest.approx(LIMIT)


@given(st.tuples(*(st.integers(0, 1000) for _ in range(3))))
def test_the_ripple_at_an_edge_is_the_integral_of_the_switched_voltages(duties: tuple[int, int, int]) -> None:
    # In thousandths of half a carrier period, each leg is low up to its edge and high from there on.
    steps = np.arange(1000)
    legs = np.array([steps >= 1000 - duty for duty in duties], dtype=float)
    ratios = np.array(duties) / 1000.0
    switched = legs - legs.mean(axis=0)
    mean = (ratios - ratios.mean())[:, None]
    first_edge = 1000 - duties[0]
    ripple = float((switched - mean)[0, :first_edge].sum()) / 1000.0
    assert _ripple_at_edge(*(float(ratio) for ratio in ratios)) == pytest.approx(ripple, abs=1e-12)


def with_drops(switch: float, diode: float, dead_ratio: float = 0.0) -> Any:
    state: Any = foc_state("foc").view(np.recarray)[0]
    state.dead_current, state.dead_ratio = 0.01, dead_ratio
    state.switch_drop, state.diode_drop = switch, diode
    return state


@given(
    ratio=st.floats(0.1, 0.9),
    current=st.sampled_from((-5.0, 5.0)),
    switch=st.floats(0.0, 3.0),
    diode=st.floats(0.0, 3.0),
)
def test_a_leg_with_drops_has_the_mean_voltage_of_its_duty_ratio(
    ratio: float, current: float, switch: float, diode: float
) -> None:
    link = 300.0
    given_ratio = _compensated_ratio(with_drops(switch, diode), ratio, current, 0.0, 1.0 / link)
    if current > 0.0:
        upper, lower = link - switch, -diode
    else:
        upper, lower = link + diode, switch
    mean = given_ratio * upper + (1.0 - given_ratio) * lower
    assert mean == pytest.approx(ratio * link, abs=3.0 * 3.0 / link), "to the second order"


def test_a_leg_without_current_and_one_without_drops_are_not_compensated() -> None:
    assert _compensated_ratio(with_drops(2.0, 1.0), 0.4, 0.0, 0.0, 1e-2) == 0.4
    assert _compensated_ratio(with_drops(0.0, 0.0), 0.4, 5.0, 0.0, 1e-2) == 0.4


def test_two_switches_take_their_drops_of_the_voltage() -> None:
    sense: Any = duty_sense_record(np.zeros(3)).view(np.recarray)[0]
    sense.supply_voltage = 48.0
    assert voltage_limit(with_drops(1.5, 0.7), sense) == pytest.approx(45.0 / 3.0**0.5)
    sense.supply_voltage = 0.0
    assert voltage_limit(with_drops(1.5, 0.7), sense) == 0.0
