"""Every field of the contract of duty ratios is what its documentation states, turning either way and past a turn."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import pi
from typing import Final

import numpy as np
import pytest
from tests.models.duty_runs import PERIOD
from tests.models.pm_ac.conftest import SURFACE
from tests.models.pm_ac.recorded_senses import Recorded, motoring, recorded
from tests.models.pm_ac.test_sensing import HALL_STATES, converters, encoder, hall
from tests.models.schedules import schedule_of

from drivegate_models.contract.duty.records import DUTY_SENSE
from drivegate_models.loop.schedule import Course
from drivegate_models.machine.rotor_frame import phase_currents, shaft_angles
from drivegate_models.pm_ac.plant.drive import PmAcDrive, make_pm_ac_drive
from drivegate_models.pm_ac.sensing import DutySensors, real_duty_sensors

TURN: Final = 2.0 * pi
STEPS: Final = 720
"""More than two turns of the shaft."""
START: Final = 2.5
"""Electrical angle at the start (rad)."""
LINES: Final = 50
SECTOR: Final = pi / 3.0
SPEEDS: Final = (200.0, -200.0)
POSITIONS: Final = ("exact", "encoder", "hall")


def drive_of(pole_pairs: int) -> PmAcDrive:
    """Return a machine of so many pole pairs, whose currents settle within some milliseconds."""
    return make_pm_ac_drive(**(SURFACE | {"pole_pairs": pole_pairs, "resistance": 0.8}))


def sensors_of(position: str, pole_pairs: int, speed: float) -> DutySensors | None:
    """Return sensors of a position whose currents have no error but steps of 5 uA."""
    exact = converters(converter_bits=24, current_range=40.0)
    if position == "encoder":
        return real_duty_sensors(exact, encoder=encoder(LINES, speed, START / pole_pairs))
    if position == "hall":
        return real_duty_sensors(exact, hall=hall(pole_pairs, speed, START))
    return None


@cache
def run_of(position: str, speed: float, pole_pairs: int = 3) -> Recorded:
    """Return a run of more than two turns at a speed that is held, while the link's voltage falls."""
    drive = drive_of(pole_pairs)
    supply = Course(np.array([0.0, STEPS * PERIOD]), 0.5 * drive.link_voltage * np.array([1.0, 0.9]))
    schedule = schedule_of(speed, supply)
    return recorded(
        drive,
        speed,
        STEPS,
        motoring(drive),
        schedule=schedule,
        initial_angle=START,
        sensors=sensors_of(position, pole_pairs, speed),
    )


def true_angles(shown: Recorded) -> np.ndarray:
    """Return the shaft's angles at the start of the periods, within a turn (rad)."""
    return np.asarray(shown.turned(START / shown.drive.pole_pairs) % TURN)


def apart(first: np.ndarray, second: np.ndarray) -> float:
    """Return by how much angles differ at most (rad)."""
    return float(np.abs((first - second + pi) % TURN - pi).max())


def has_its_size(shown: Recorded, _position: str) -> None:
    assert (shown.senses["struct_size"] == DUTY_SENSE.itemsize).all()


def is_the_start_of_the_period(shown: Recorded, _position: str) -> None:
    assert shown.senses["time"] == pytest.approx(np.arange(STEPS) * PERIOD, abs=1e-15)


def is_the_speed_that_is_asked_for(shown: Recorded, _position: str) -> None:
    assert (shown.senses["reference"] == shown.column("speed_reference")).all()


def are_currents_into_the_machine_now(shown: Recorded, position: str) -> None:
    assert (shown.senses["phase_currents"] == shown.senses["phase_currents"][0]).all()
    before = [shown.column(name)[:-1].copy() for name in ("direct", "quadrature")]
    now = phase_currents(*before, shown.column("angle")[1:].copy())
    tolerance = 1e-9 if position == "exact" else 5e-6
    assert shown.currents[1:] == pytest.approx(now, abs=tolerance)
    assert not shown.currents[0].any()
    # Currents that flow in along a voltage ahead of the magnet drive the shaft on.
    angle = shown.drive.pole_pairs * true_angles(shown)[1:, None] - np.arange(3) * TURN / 3.0
    across = (-np.sin(angle) * shown.currents[1:]).sum(axis=1) * 2.0 / 3.0
    torque = 1.5 * shown.drive.pole_pairs * shown.drive.magnet_flux * across
    assert np.abs(torque[-300:]).min() > 0.05
    assert torque[-300:] == pytest.approx(shown.column("torque")[-300:], rel=0.05)


def is_the_whole_link_now(shown: Recorded, position: str) -> None:
    tolerance = 0.0 if position == "exact" else 2e-5
    assert shown.senses["supply_voltage"] == pytest.approx(shown.column("link"), abs=tolerance)
    assert shown.senses["supply_voltage"][0] == pytest.approx(shown.drive.link_voltage, abs=tolerance)
    assert shown.senses["supply_voltage"][-1] < 0.91 * shown.drive.link_voltage


def is_the_mean_of_the_period_before(shown: Recorded, _position: str) -> None:
    mean = shown.column("input_power") / shown.column("link")
    assert shown.senses["supply_current"][0] == 0.0
    assert shown.senses["supply_current"][1:] == pytest.approx(mean[:-1], rel=1e-12)
    assert shown.senses["supply_current"][-300:].min() > 0.0, "a drive that motors takes it from the link"


def is_not_sensed(shown: Recorded, _position: str) -> None:
    assert np.isnan(shown.senses["winding_temperature"]).all(), "the drive has no thermal data"


def are_not_sensed(shown: Recorded, _position: str) -> None:
    assert np.isnan(shown.senses["mean_voltages"]).all(), "the drive does not state them"


def is_that_of_the_bridge(shown: Recorded, _position: str) -> None:
    assert (shown.senses["source_current"] == shown.senses["supply_current"]).all(), "the link is ideal"


def is_the_angle_of_the_shaft(shown: Recorded, position: str) -> None:
    angle = shown.senses["angle"]
    # An encoder shows the middle between two edges, and switches an angle that its timer extrapolates.
    tolerance = {"exact": 1e-11, "encoder": 0.5001 * TURN / (4 * LINES), "hall": 0.02}[position]
    settled = slice(100, None) if position == "hall" else slice(None)
    assert apart(angle[settled], true_angles(shown)[settled]) < tolerance
    assert (angle >= 0.0).all()
    assert (angle < TURN).all()
    assert np.ptp(angle) > 0.98 * TURN
    step = np.diff(angle[settled]) * np.sign(shown.column("speed")[0])
    wraps = step < -pi
    assert wraps.sum() in (1, 2, 3), "it starts again once a turn of the shaft"
    assert (step[~wraps] >= 0.0).all()


def is_the_speed_of_the_shaft(shown: Recorded, position: str) -> None:
    speed = shown.column("speed")
    settled = slice(100, None) if position == "hall" else slice(None)
    relative = 0.0 if position == "exact" else 2e-3
    assert shown.senses["speed"][settled] == pytest.approx(speed[settled], rel=relative, abs=0.0)


def are_the_states_of_the_switches(shown: Recorded, position: str) -> None:
    if position != "hall":
        assert (shown.senses["hall"] == -1).all()
        return
    electrical = shown.drive.pole_pairs * true_angles(shown)
    place = (electrical - pi / 6.0) / SECTOR
    clear = np.abs(place - np.round(place)) > 1e-6
    states = np.array(HALL_STATES)[np.floor(place).astype(int) % 6]
    assert (shown.senses["hall"] == states)[clear].all()


def counts_from_the_shafts_angle_zero(shown: Recorded, position: str) -> None:
    count = shown.senses["encoder_count"]
    if position != "encoder":
        assert (count == -1).all()
        return
    edges = 4 * LINES
    assert (count >= 0).all()
    assert (count < edges).all()
    assert shown.senses["angle"] == pytest.approx((count + 0.5) * TURN / edges, abs=1e-12)
    assert set(count) >= {0, edges - 1}


def has_no_flag(shown: Recorded, _position: str) -> None:
    assert not shown.senses["trip"].any()


def are_the_terminals_at_the_rails(shown: Recorded, _position: str) -> None:
    voltages = shown.senses["phase_voltages"]
    # The first answer acts from the second step on, with all lower switches on between two pulses.
    assert np.ptp(voltages[:2], axis=1).min() > 1.0
    assert voltages[:2].min(axis=1) == pytest.approx(0.0, abs=1e-12)
    assert not voltages[2:].any()


def is_always_set(shown: Recorded, _position: str) -> None:
    assert (shown.senses["enable"] == 1).all()


SENSED: Final[dict[str, Callable[[Recorded, str], None]]] = {
    "struct_size": has_its_size,
    "time": is_the_start_of_the_period,
    "reference": is_the_speed_that_is_asked_for,
    "phase_currents": are_currents_into_the_machine_now,
    "supply_voltage": is_the_whole_link_now,
    "supply_current": is_the_mean_of_the_period_before,
    "source_current": is_that_of_the_bridge,
    "winding_temperature": is_not_sensed,
    "angle": is_the_angle_of_the_shaft,
    "speed": is_the_speed_of_the_shaft,
    "hall": are_the_states_of_the_switches,
    "encoder_count": counts_from_the_shafts_angle_zero,
    "trip": has_no_flag,
    "phase_voltages": are_the_terminals_at_the_rails,
    "mean_voltages": are_not_sensed,
    "enable": is_always_set,
}
"""What is asserted of each field of a Sense."""


@pytest.mark.parametrize("speed", SPEEDS, ids=["forward", "backward"])
@pytest.mark.parametrize("position", POSITIONS)
@pytest.mark.parametrize("field", DUTY_SENSE.names)
def test_a_field_of_the_sense_is_what_it_is_documented_as(field: str, position: str, speed: float) -> None:
    assert field in SENSED, f"nothing is asserted of the field '{field}'"
    SENSED[field](run_of(position, speed), position)


@pytest.mark.parametrize("pole_pairs", [1, 7, 12])
@pytest.mark.parametrize("speed", SPEEDS, ids=["forward", "backward"])
def test_the_angle_runs_through_a_turn_at_any_number_of_pole_pairs(pole_pairs: int, speed: float) -> None:
    for position in POSITIONS:
        is_the_angle_of_the_shaft(run_of(position, speed, pole_pairs), position)


def test_a_recorded_run_has_the_same_angles_of_the_shaft() -> None:
    for speed in SPEEDS:
        shown = run_of("exact", speed, 7)
        assert apart(shaft_angles(shown.column("angle"), 7), shown.senses["angle"]) < 1e-11
