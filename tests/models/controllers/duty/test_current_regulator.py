"""What current regulators do at the voltage limit, and how they compensate dead time and drops."""

from __future__ import annotations

from math import cos, hypot, pi, sin
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.models.controllers.duty.test_plausibility import NAMEPLATE
from tests.models.controllers.duty.test_speed_regulator import reset_with

from drivegate_models.contract.duty.records import (
    duty_command_record,
    duty_sense_record,
)
from drivegate_models.controllers.duty.current_regulator import (
    _compensated_ratio,
    _flux_at_edge,
    _ripple_of,
    compensate_bridge,
    limited_request,
    regulate_currents,
    voltage_limit,
)
from drivegate_models.controllers.duty.flux_prediction import regulate_flux
from drivegate_models.controllers.duty.state import foc_state
from drivegate_models.controllers.duty.torque_regulation import regulate_torque
from drivegate_models.machine.rotor_frame import of_phase

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
    ripple = (switched - mean)[:, :first_edge].sum(axis=1) / 1000.0
    found = _flux_at_edge(float(ratios[0]), *(float(ratio) for ratio in ratios))
    assert [of_phase(leg, *found) for leg in range(3)] == pytest.approx(list(ripple), abs=1e-12)


@given(st.floats(0.0, 2.0 * pi), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_the_ripple_of_a_current_is_less_along_the_axis_of_more_inductance(
    angle: float, along: float, across: float
) -> None:
    state: Any = foc_state("foc").view(np.recarray)[0]
    state.direct_inductance, state.quadrature_inductance = 2e-3, 6e-3
    turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
    current = turn @ np.diag([500.0, 1e3 / 6.0]) @ turn.T @ [along, across]
    found = [_ripple_of(state, (cos(angle), sin(angle)), leg, (along, across)) for leg in range(3)]
    assert found == pytest.approx([of_phase(leg, *current) for leg in range(3)], abs=1e-9)


def with_drops(switch: float, diode: float, dead_ratio: float = 0.0) -> Any:
    state: Any = foc_state("foc").view(np.recarray)[0]
    state.dead_current, state.dead_ratio = 0.01, dead_ratio
    state.switch_drop, state.diode_drop = switch, diode
    state.direct_inductance = state.quadrature_inductance = 1e-3
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


def compensated(state: Any, ratios: tuple[float, ...], angle: float, electrical: float) -> list[float]:
    """Return duty ratios with compensation for 10 A across the d axis."""
    command: Any = duty_command_record().view(np.recarray)[0]
    command.first_duty, command.second_duty, command.third_duty = ratios
    compensate_bridge(state, command, (cos(angle), sin(angle)), electrical, 0.0, 10.0, 300.0)
    return [float(command.first_duty), float(command.second_duty), float(command.third_duty)]


@given(st.floats(0.0, 2.0 * pi), st.floats(0.0, 2.0 * pi), st.floats(0.1, 0.98))
def test_dead_time_near_the_voltage_limit_takes_no_voltage(
    angle: float, voltage_angle: float, depth: float
) -> None:
    """A leg that switches loses 0.015, and one at a rail nothing, so that 0.98 can be had between two legs."""
    dead = 0.015
    voltages = [depth / 3.0**0.5 * cos(voltage_angle - k * 2.0 * pi / 3.0) for k in range(3)]
    middle = 0.5 * (max(voltages) + min(voltages))
    ratios = tuple(0.5 + voltage - middle for voltage in voltages)
    currents = np.array([-10.0 * sin(angle - k * 2.0 * pi / 3.0) for k in range(3)])
    found = np.array(compensated(with_drops(0.0, 0.0, dead), ratios, angle, 0.0))
    lost = np.where((found > 0.0) & (found < 1.0), dead * np.clip(currents / 0.01, -1.0, 1.0), 0.0)
    assert np.diff(found - lost) == pytest.approx(np.diff(ratios), abs=1e-12)
    assert np.all((found == 0.0) | (found >= 0.001)), "a counter of ten bits rounds this pulse away"
    assert found.max() < 1.0, "the gap between two periods at the upper rail loses its dead time"


@pytest.mark.parametrize("degrees", [-12.0, -5.0, -2.0, 2.0, 5.0, 12.0])
def test_a_current_that_passes_zero_between_the_edges_of_a_leg_loses_no_time(degrees: float) -> None:
    """The field turns by 20 degrees in a carrier period; a leg of duty ratio 0.6 has its edges at 6 degrees."""
    state = with_drops(0.0, 0.0, dead_ratio=0.02)
    state.half_carrier, state.edge_centre = 20e-6, 0.0
    # Hardly a ripple.
    state.direct_inductance = state.quadrature_inductance = 1e3
    electrical = 10.0 * pi / 180.0 / state.half_carrier
    # The first phase's current passes zero, falling, at angle 0.
    found = compensated(state, (0.6, 0.5, 0.4), degrees * pi / 180.0, electrical)[0]
    signs = [float(np.sign(-sin((degrees + edge) * pi / 180.0))) for edge in (-6.0, 6.0)]
    assert found == pytest.approx(0.6 + 0.02 * 0.5 * sum(signs), abs=1e-12)


@pytest.mark.parametrize("name", ["foc", "predictive-flux", "direct-torque"])
@pytest.mark.parametrize("degrees", [-8.0, 8.0])
def test_the_bridge_is_compensated_for_the_currents_in_the_middle_of_the_period(
    name: str, degrees: float
) -> None:
    """The field turns by 20 degrees in a control period, so that a current soon has the other sign."""
    regulate = {"foc": regulate_currents, "predictive-flux": regulate_flux, "direct-torque": regulate_torque}[
        name
    ]
    per_period = 20.0 * pi / 180.0
    sense: Any = duty_sense_record(np.zeros(3)).view(np.recarray)[0]
    sense.supply_voltage = NAMEPLATE.supply_voltage
    sense.speed = per_period / (NAMEPLATE.control_period * NAMEPLATE.pole_pairs)
    sense.angle = (degrees * pi / 180.0 - 1.5 * per_period) / NAMEPLATE.pole_pairs
    plate = {"magnet_flux": 1e-3, "direct_inductance": 3e-3, "quadrature_inductance": 3e-3}
    found = []
    for dead_time in (0.0, 1e-6):
        state = reset_with(name, dead_time=dead_time, **plate)
        command: Any = duty_command_record().view(np.recarray)[0]
        # The first phase's current passes zero, falling, at angle 0.
        regulate(state, sense, command, 0.0, 5.0, 0.0, 5.0)
        found.append(float(command.first_duty))
    lost = 1e-6 / NAMEPLATE.control_period
    assert found[1] - found[0] == pytest.approx(-lost if degrees > 0.0 else lost)


def test_two_switches_take_their_drops_of_the_voltage() -> None:
    sense: Any = duty_sense_record(np.zeros(3)).view(np.recarray)[0]
    sense.supply_voltage = 48.0
    assert voltage_limit(with_drops(1.5, 0.7), sense) == pytest.approx(45.0 / 3.0**0.5)
    sense.supply_voltage = 0.0
    assert voltage_limit(with_drops(1.5, 0.7), sense) == 0.0
