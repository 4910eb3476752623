"""What `load-observer` takes for a failure: each residual by its code, and what is none."""

from __future__ import annotations

from cmath import rect
from collections.abc import Callable
from math import nan, pi, tau
from typing import Any

import numpy as np
import pytest

from drivegate_models.contract.current.signals import PM_AC
from drivegate_models.contract.duty.records import duty_nameplate_record, duty_sense_record
from drivegate_models.contract.duty.signals import SPEED_REFERENCE, DutyNameplate
from drivegate_models.controllers.duty.load_observer import LOAD_OBSERVER_STATE
from drivegate_models.controllers.duty.residuals import (
    CURRENT_FAULT,
    PHASE_FAULT,
    POSITION_FAULT,
    STALL_FAULT,
    VOLTAGE_FAULT,
    detect_failure,
    reset_detector,
    watch_currents,
)

pytestmark = pytest.mark.kernel

PERIOD = 1e-4
POLE_PAIRS = 2
LIMIT = 7.0
PEAK = 3.0
SPEED = 150.0
EMF = POLE_PAIRS * SPEED * 0.0879
RATED_TORQUE, GREATEST_TORQUE = 1.5, 2.4
PLATE = DutyNameplate(
    kind=PM_AC,
    reference_kind=SPEED_REFERENCE,
    pole_pairs=POLE_PAIRS,
    updates=1,
    update_delay=0,
    supply_voltage=120.0,
    base_speed=230.0,
    highest_speed=690.0,
    rated_power=230.0 * RATED_TORQUE,
    current_limit=LIMIT,
    control_period=PERIOD,
    dead_time=0.0,
    resistance=0.57,
    direct_inductance=8.72e-3,
    quadrature_inductance=8.72e-3,
    magnet_flux=0.0879,
    inertia=0.002,
    core_loss_conductance=0.0,
)
MACHINE = {
    **{
        name: getattr(PLATE, name)
        for name in (
            "control_period",
            "pole_pairs",
            "current_limit",
            "resistance",
            "direct_inductance",
            "quadrature_inductance",
            "magnet_flux",
        )
    },
    "full_current": LIMIT,
    "greatest_torque": GREATEST_TORQUE,
    "regulates_speed": 1,
    "along_voltage": nan,
    "across_voltage": nan,
}


class Drive:
    """A turning shaft with balanced currents at their references, and the detector."""

    def __init__(self, speed: float = SPEED, hall: int = -1) -> None:
        stored = np.zeros(1, LOAD_OBSERVER_STATE)
        self.machine: Any = stored["machine"].view(np.recarray)[0]
        for name, value in MACHINE.items():
            self.machine[name] = value
        self.state: Any = stored.view(np.recarray)[0]
        reset_detector(self.state, duty_nameplate_record(PLATE).view(np.recarray)[0])
        self.currents = np.zeros(3)
        self.sensed = duty_sense_record(self.currents)
        self.sense: Any = self.sensed.view(np.recarray)[0]
        self.sense.reference = 100.0
        self.sense.hall = hall
        self.sense.speed = speed
        self.sense.angle = 0.0
        self.sense.supply_voltage = 120.0
        self.true_angle = 0.0
        self.true_speed = speed
        # A voltage that the machine does not explain (V), and the current in a step (A), both in the rotor frame.
        self.missed = 0j
        self.current_at: Callable[[int], complex] = lambda _: 1j * PEAK

    def steps_to_fault(self, steps: int, change: Callable[[int], None] = lambda k: None) -> tuple[int, int]:
        """Step on at the true speed, a change applied in each step; return the code and the step in which it came."""
        machine = self.machine
        for k in range(steps):
            before = rect(1.0, POLE_PAIRS * self.true_angle)
            self.true_angle = (self.true_angle + self.true_speed * PERIOD) % tau
            self.sense.angle = self.true_angle
            now = rect(1.0, POLE_PAIRS * self.true_angle)
            last, current = self.current_at(k - 1) * before, self.current_at(k) * now
            flux = machine.magnet_flux * (now - before) + machine.direct_inductance * (current - last)
            voltage = 0.5 * machine.resistance * (last + current) + flux / PERIOD + self.missed * now
            if k > 0:
                machine.along_voltage[0], machine.across_voltage[0] = voltage.real, voltage.imag
            self.currents[:] = [(current * rect(1.0, -phase * tau / 3.0)).real for phase in range(3)]
            change(k)
            seen = current * rect(1.0, -POLE_PAIRS * self.sense.angle)
            if detect_failure(self.state, self.sense, seen.real, seen.imag):
                return int(self.state.fault), k
            watch_currents(self.state, 69.0, seen.real, seen.imag, 0.0, PEAK)
        return 0, steps


@pytest.mark.parametrize("speed", [SPEED, -SPEED, 1.0, 0.0])
@pytest.mark.parametrize("hall", [-1, 1])
def test_a_drive_in_order_is_left_alone(speed: float, hall: int) -> None:
    assert Drive(speed, hall).steps_to_fault(500) == (0, 500)


@pytest.mark.parametrize(
    ("added", "steps", "fault"), [(0.035, 99, CURRENT_FAULT), (0.025, 99, 0), (0.5, 2, 0)]
)
def test_a_sum_of_currents_is_no_error_of_their_sensors(added: float, steps: int, fault: int) -> None:
    """The currents have 1.71 A to 1.9 A of a limit of 7 A, of which their sensors miss 2 % and 1.5 % of the limit."""
    drive = Drive()

    def add(k: int) -> None:
        drive.currents[0] += added * LIMIT if 20 <= k < 20 + steps else 0.0

    assert drive.steps_to_fault(200, add) == (fault, 22 if fault else 200)


@pytest.mark.parametrize(
    ("share", "hall", "overdue", "fault"),
    [(1.1, -1, 0, VOLTAGE_FAULT), (0.9, -1, 0, 0), (1.1, 1, 0, 0)],
)
def test_a_missed_voltage_is_more_than_other_data_explain(
    share: float, hall: int, overdue: int, fault: int
) -> None:
    """That is 30 % of the EMF, 35 % of the inductive voltage, the resistive one and 1 % of the link."""
    drive = Drive(hall=hall)
    drive.machine.is_overdue = overdue
    inductive = POLE_PAIRS * SPEED * 8.72e-3 * PEAK
    allowed = 0.3 * EMF + 0.35 * inductive + 0.57 * PEAK + 0.01 * 120.0
    drive.missed = share * allowed * (0.6 + 0.8j)
    found, step = drive.steps_to_fault(200)
    assert found == fault
    if fault:
        # A mean over 8 periods comes to 1 / 1.1 of it after 18 of them, and must last.
        assert step == pytest.approx(23, abs=2)


@pytest.mark.parametrize(("share", "fault"), [(0.3, 0), (1.0, VOLTAGE_FAULT)])
def test_another_inductance_explains_its_share_of_the_voltage_that_changes_the_current(
    share: float, fault: int
) -> None:
    drive = Drive()
    step, ramp = 0.8, range(20, 36)
    drive.current_at = lambda k: 1j * (6.0 - step * min(max(k - ramp.start, 0), len(ramp)))

    def miss(k: int) -> None:
        drive.missed = 1j * share * 8.72e-3 * step / PERIOD if k in ramp else 0j

    assert drive.steps_to_fault(ramp.stop, miss)[0] == fault


@pytest.mark.parametrize(("share", "fault"), [(1.3, 0), (1.5, VOLTAGE_FAULT)])
def test_dead_time_takes_a_vector_of_three_legs_while_the_currents_have_no_sign(
    share: float, fault: int
) -> None:
    drive = Drive(speed=0.0)
    drive.machine.dead_ratio = 0.1
    drive.state.base_speed = 0.0
    # Its currents are little beside this.
    drive.machine.full_current = 100.0
    drive.missed = complex(share * 0.1 * 120.0 + 0.01 * 120.0 + 0.57 * PEAK)
    assert drive.steps_to_fault(60)[0] == fault


@pytest.mark.parametrize(("off", "fault"), [(0.16, VOLTAGE_FAULT), (0.14, 0)])
def test_an_angle_off_the_observed_shaft_is_confirmed_by_half_as_much_voltage(off: float, fault: int) -> None:
    drive = Drive()
    drive.missed = 0.4 * EMF
    drive.state.angle_missed = off / POLE_PAIRS
    assert drive.steps_to_fault(50) == (fault, 2 if fault else 50)


def test_an_encoder_that_is_lost_hides_no_speed_that_it_does_not_resolve() -> None:
    """What the link leaves uncertain and a twentieth of base speed are together more than the EMF."""
    speed = 46.0
    drive = Drive(speed)
    drive.sense.supply_voltage = 450.0
    # So little current of so much shows no missing phase.
    drive.machine.current_limit = drive.machine.full_current = 100.0

    def lose(k: int) -> None:
        if k >= 50:
            # It shows what the time since its last edge allows.
            drive.sense.angle, drive.sense.speed = 50 * speed * PERIOD, speed / (k - 48)

    fault, step = drive.steps_to_fault(400, lose)
    assert fault == VOLTAGE_FAULT
    assert (step - 50) * POLE_PAIRS * speed * PERIOD < pi / 2.0, "while the torque has its sense"


@pytest.mark.parametrize("lost_periods", [3, 400])
def test_the_angle_of_an_encoder_shows_a_stop_before_its_mean_speed_does(lost_periods: int) -> None:
    """The speed is a mean over 20 periods, whose change explains the EMF that it hides; three samples get lost."""
    speed = 46.0
    drive = Drive(speed)
    drive.machine.current_limit = drive.machine.full_current = 100.0

    def lose(k: int) -> None:
        drive.sense.speed = speed
        if 50 <= k < 50 + lost_periods:
            drive.sense.angle = 50 * speed * PERIOD
            drive.sense.speed *= max(1.0 - (k - 50) / 20.0, 0.0)

    fault, step = drive.steps_to_fault(400, lose)
    if lost_periods == 3:
        assert fault == 0
    else:
        assert fault == VOLTAGE_FAULT
        assert step - 50 < 20


def test_a_phase_that_does_not_follow_its_reference_is_missing() -> None:
    drive = Drive()

    def open_phase(_: int) -> None:
        # The error of the flux is not just rounding, and does not shrink.
        drive.state.shrinks = 0
        drive.currents[1] = -0.5 * drive.currents[1]
        drive.currents[2] = -drive.currents[0] - drive.currents[1]

    fault, step = drive.steps_to_fault(200, open_phase)
    assert fault == PHASE_FAULT
    # The reference of the phase is above half of the amplitude for two thirds of half a turn of 105 periods.
    assert 11 <= step <= 11 + 105


@pytest.mark.parametrize(("supply", "fault"), [(40.0, 0), (120.0, PHASE_FAULT)])
def test_at_the_voltage_limit_currents_against_their_references_prove_no_missing_phase(
    supply: float, fault: int
) -> None:
    drive = Drive()
    drive.sense.supply_voltage = supply
    drive.current_at = lambda _: 1j * PEAK * rect(1.0, -1.5)

    def approach(_: int) -> None:
        # The error of the flux is not just rounding, and does not shrink.
        drive.state.shrinks = 0

    assert drive.steps_to_fault(200, approach)[0] == fault


def test_at_the_voltage_limit_a_phase_without_current_is_missing() -> None:
    drive = Drive()
    drive.sense.supply_voltage = 40.0

    def open_phase(_: int) -> None:
        drive.state.shrinks = 0
        drive.currents[:] = drive.currents[0], 0.0, -drive.currents[0]

    fault, step = drive.steps_to_fault(200, open_phase)
    assert fault == PHASE_FAULT
    assert step <= 24 + 105


@pytest.mark.parametrize(("approach", "fault"), [(0.02, 0), (0.0, PHASE_FAULT)])
def test_no_phase_is_missing_while_the_currents_approach_their_references(
    approach: float, fault: int
) -> None:
    """Current flows before the first reference: at high speed the diodes carry it."""
    drive = Drive()
    drive.current_at = lambda k: 1j * PEAK * (approach * k - 1.0)
    assert drive.steps_to_fault(60)[0] == fault


@pytest.mark.parametrize(("jump_deg", "fault"), [(45.0, POSITION_FAULT), (-120.0, POSITION_FAULT), (3.0, 0)])
def test_an_angle_that_jumps_is_that_of_a_magnet_that_slips_and_no_false_edge(
    jump_deg: float, fault: int
) -> None:
    drive = Drive()

    def slip(k: int) -> None:
        drive.sense.angle += jump_deg * pi / 180.0 / POLE_PAIRS if k >= 50 else 0.0

    assert drive.steps_to_fault(100, slip) == (fault, 50 if fault else 100)


def test_an_angle_that_stands_while_a_speed_is_shown_is_lost_within_a_sixth_of_a_turn() -> None:
    drive = Drive()

    def stand(k: int) -> None:
        # No voltage shows it.
        drive.machine.along_voltage[0] = nan
        if k == 50:
            drive.true_speed = 0.0

    fault, step = drive.steps_to_fault(200, stand)
    assert fault == POSITION_FAULT
    assert (step - 50) * POLE_PAIRS * SPEED * PERIOD < 1.1


def test_a_lost_sample_of_the_speed_is_no_lost_position() -> None:
    drive = Drive()

    def lose(k: int) -> None:
        drive.sense.speed = 0.0 if k % 20 == 10 else SPEED

    assert drive.steps_to_fault(200, lose)[0] == 0


@pytest.mark.parametrize(
    ("torque", "reference", "regulates", "fault"),
    [
        (GREATEST_TORQUE, 100.0, 1, STALL_FAULT),
        (-1.25 * RATED_TORQUE, -100.0, 1, STALL_FAULT),
        (1.15 * RATED_TORQUE, 100.0, 1, 0),
        (GREATEST_TORQUE, 0.0, 1, 0),
        (GREATEST_TORQUE, 100.0, 0, 0),
    ],
)
def test_a_shaft_stalls_under_more_torque_than_any_load(
    torque: float, reference: float, regulates: int, fault: int
) -> None:
    drive = Drive(0.0)
    drive.sense.reference = reference
    drive.machine.regulates_speed = regulates
    drive.state.torque = torque
    assert drive.steps_to_fault(400) == (fault, 249 if fault else 400)
