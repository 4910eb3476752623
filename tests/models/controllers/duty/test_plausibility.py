"""What field-oriented control holds its sensors and its machine to: each fault by its code and in its time."""

from __future__ import annotations

from cmath import rect
from collections.abc import Callable
from math import cos, nan, pi, tau
from typing import Any

import numpy as np
import pytest

from drivegate_models.contract.current.signals import PM_AC
from drivegate_models.contract.duty.records import (
    duty_command_record,
    duty_nameplate_record,
    duty_sense_record,
)
from drivegate_models.contract.duty.signals import LEG_OFF, SPEED_REFERENCE, DutyNameplate
from drivegate_models.controllers.duty.missing_phase import watch_approach
from drivegate_models.controllers.duty.plausibility import (
    CURRENT_FAULT,
    PHASE_FAULT,
    SHAFT_FAULT,
    STALL_FAULT,
    detect_fault,
    hold_safe_state,
    reset_plausibility,
    watch_flux,
)
from drivegate_models.controllers.duty.state import foc_state

pytestmark = pytest.mark.kernel

PERIOD = 1e-4
POLE_PAIRS = 2
LIMIT = 7.0
BASE_SPEED = 230.0
GREATEST_TORQUE = 2.4
RATED_TORQUE = 1.5
INERTIA = 0.002
NAMEPLATE = DutyNameplate(
    kind=PM_AC,
    reference_kind=SPEED_REFERENCE,
    pole_pairs=POLE_PAIRS,
    updates=1,
    update_delay=1,
    supply_voltage=122.5,
    base_speed=BASE_SPEED,
    highest_speed=3.0 * BASE_SPEED,
    rated_power=BASE_SPEED * RATED_TORQUE,
    current_limit=LIMIT,
    control_period=PERIOD,
    dead_time=0.0,
    resistance=0.57,
    direct_inductance=8.72e-3,
    quadrature_inductance=22.78e-3,
    magnet_flux=0.0879,
    inertia=INERTIA,
    core_loss_conductance=0.0,
)


class Drive:
    """A shaft at a speed with balanced currents, and what is made of them, step by step."""

    def __init__(self, speed: float, *, peak: float = 3.0, reference: float = 100.0, hall: int = -1) -> None:
        self.state: Any = foc_state("foc").view(np.recarray)[0]
        self.state.pole_pairs = POLE_PAIRS
        self.state.control_period = PERIOD
        self.state.current_limit = LIMIT
        self.state.full_current = LIMIT
        self.state.greatest_torque = GREATEST_TORQUE
        self.state.regulates_speed = 1
        reset_plausibility(self.state, duty_nameplate_record(NAMEPLATE).view(np.recarray)[0])
        self.currents = np.zeros(3)
        self.sensed = duty_sense_record(self.currents)
        self.sense: Any = self.sensed.view(np.recarray)[0]
        self.sense.reference = reference
        self.sense.hall = hall
        self.sense.speed = speed
        self.sense.angle = 0.0
        self.peak = peak
        # The balanced currents are those of the reference.
        self.state.direct_aim = peak
        self.state.magnet_flux = NAMEPLATE.magnet_flux

    def turn(self, angle_speed: float) -> None:
        """Turn the shaft for a period, with the field; its angle stays within a turn."""
        self.sense.angle = (self.sense.angle + angle_speed * PERIOD) % tau
        field = POLE_PAIRS * self.sense.angle
        self.currents[:] = [self.peak * cos(field - phase * tau / 3.0) for phase in range(3)]

    def steps_to_fault(self, steps: int, change: Callable[[int], None] = lambda k: None) -> tuple[int, int]:
        """Step on at the speed, a change applied in each step; return the code and the step in which it came."""
        for k in range(steps):
            self.turn(self.sense.speed)
            change(k)
            if detect_fault(self.state, self.sense):
                return int(self.state.fault), k
        return 0, steps


@pytest.mark.parametrize("speed", [300.0, -300.0, 3.0])
def test_a_drive_in_order_is_left_alone_turn_after_turn(speed: float) -> None:
    assert Drive(speed).steps_to_fault(1000) == (0, 1000)


@pytest.mark.parametrize(("steps", "fault"), [(2, 0), (3, CURRENT_FAULT)])
def test_a_sum_of_currents_counts_once_it_has_lasted(steps: int, fault: int) -> None:
    drive = Drive(300.0)

    def shift(k: int) -> None:
        if 20 <= k < 20 + steps:
            drive.currents[1] += 0.06 * LIMIT

    assert drive.steps_to_fault(60, shift) == (fault, 22 if fault else 60)


def test_a_small_sum_of_currents_is_an_offset() -> None:
    drive = Drive(300.0)

    def shift(k: int) -> None:
        drive.currents[1] += 0.04 * LIMIT

    assert drive.steps_to_fault(200, shift)[0] == 0


def hold_angle(drive: Drive) -> Callable[[int], None]:
    """Return what keeps the angle from step 10 on while the speed goes on."""
    kept: list[float] = []

    def stick(k: int) -> None:
        if k >= 10:
            kept.append(drive.sense.angle)
            drive.sense.angle = kept[0]

    return stick


def drive_of_unexplained_flux(share: float) -> Drive:
    """Return a drive with a flux that voltages do not explain, by its share of the magnet's; 45 % are resistive."""
    drive = Drive(300.0)
    drive.state.resistance = 5.7
    drive.state.along_drift = share * NAMEPLATE.magnet_flux
    return drive


@pytest.mark.parametrize(("share", "fault"), [(0.4, 0), (0.5, SHAFT_FAULT)])
def test_a_flux_that_no_data_explain_is_that_of_a_wrong_angle(share: float, fault: int) -> None:
    drive = drive_of_unexplained_flux(share)
    assert drive.steps_to_fault(100) == (fault, 5 if fault else 100)


def test_an_angle_that_stands_while_the_speed_goes_on_is_seen_within_a_quarter_radian() -> None:
    drive = drive_of_unexplained_flux(0.3)
    fault, step = drive.steps_to_fault(200, hold_angle(drive))
    assert fault == SHAFT_FAULT
    # 0.06 rad electrical a period: the fourth or fifth misses a quarter, with what is forgotten meanwhile.
    assert 14 <= step <= 16


def test_an_angle_ahead_of_the_mean_speed_of_an_encoder_is_right_if_it_agrees_with_the_flux() -> None:
    drive = drive_of_unexplained_flux(0.2)
    assert drive.steps_to_fault(200, hold_angle(drive))[0] == 0


@pytest.mark.parametrize(
    ("angle_speed", "slip", "seen"), [(60.0, 0.0, 0.0), (60.0, 0.79, 0.766), (0.0, 0.0, 0.372)]
)
def test_a_flux_at_a_wrong_angle_is_not_explained_by_the_voltage(
    angle_speed: float, slip: float, seen: float
) -> None:
    drive = Drive(60.0)
    drive.state.direct_inductance = drive.state.quadrature_inductance = NAMEPLATE.direct_inductance
    drive.state.resistance = NAMEPLATE.resistance
    drive.state.along_drift = 0.0
    drive.state.along_voltage[:] = nan
    # A shaft at 60 rad/s without current, whose voltage is the change of the magnet's flux.
    step = 60.0 * POLE_PAIRS * PERIOD
    largest = 0.0
    for k in range(100):
        # The angle is right until the change, with which it slips, or stands from then on.
        shown = (
            step * min(k, 50)
            + (max(k - 50, 0) * angle_speed * POLE_PAIRS * PERIOD)
            + (slip if k > 50 else 0.0)
        )
        drive.sense.angle = shown / POLE_PAIRS
        watch_flux(drive.state, drive.sense, 0.0, 0.0)
        largest = max(largest, abs(complex(drive.state.along_drift, drive.state.across_drift)))
        change = NAMEPLATE.magnet_flux / PERIOD * (rect(1.0, step * (k + 1)) - rect(1.0, step * k))
        drive.state.along_voltage[0], drive.state.across_voltage[0] = change.real, change.imag
    assert largest / NAMEPLATE.magnet_flux == pytest.approx(seen, abs=0.02)


def test_the_steps_of_hall_switches_are_no_lost_angle() -> None:
    drive = Drive(300.0, hall=1)
    assert drive.steps_to_fault(200, hold_angle(drive))[0] != SHAFT_FAULT


def slowing(drive: Drive, share: float) -> Callable[[int], None]:
    """Return what slows the shaft down at a share of what torque and inertia are trusted with."""
    step = share * 2.0 / 0.3 * GREATEST_TORQUE / INERTIA * PERIOD

    def slow(_: int) -> None:
        drive.sense.speed = max(drive.sense.speed - step, 0.0)

    return slow


@pytest.mark.parametrize(("share", "fault"), [(0.9, 0), (5.0, SHAFT_FAULT)])
def test_a_shaft_that_stops_faster_than_it_can_is_locked(share: float, fault: int) -> None:
    drive = Drive(300.0, reference=0.0)
    assert drive.steps_to_fault(800, slowing(drive, share))[0] == fault


@pytest.mark.parametrize(("torque", "fault"), [(-GREATEST_TORQUE, 0), (RATED_TORQUE, SHAFT_FAULT)])
def test_a_braked_shaft_may_reverse_between_the_edges_of_its_encoder(torque: float, fault: int) -> None:
    """The shown speed is one from before the last edge, and then falls at once to what the time since then allows."""
    drive = Drive(0.1 * BASE_SPEED, reference=-100.0)
    drive.state.torque = torque
    last = 10.0 * PERIOD * drive.sense.speed

    def reverse(step: int) -> None:
        if step >= 10:
            drive.sense.angle = last
        if step >= 45:
            drive.sense.speed = 0.03 * BASE_SPEED

    assert drive.steps_to_fault(80, reverse)[0] == fault


@pytest.mark.parametrize(("periods", "fault"), [(5, SHAFT_FAULT), (4, 0)])
def test_a_slow_speed_that_vanishes_at_once_is_lost_although_the_shaft_could_soon_stop(
    periods: int, fault: int
) -> None:
    # Torque and inertia could slow it below 5 % of base speed, where nothing is checked, within three periods.
    slow = 0.06 * BASE_SPEED
    drive = Drive(slow, reference=0.0)

    def vanish(step: int) -> None:
        drive.sense.speed = 0.0 if 10 <= step < 10 + periods else slow

    assert drive.steps_to_fault(30, vanish)[0] == fault


@pytest.mark.parametrize(
    ("torque", "reference", "regulates", "fault"),
    [
        (GREATEST_TORQUE, 100.0, 1, STALL_FAULT),
        (-GREATEST_TORQUE, -100.0, 1, STALL_FAULT),
        (1.25 * RATED_TORQUE, 100.0, 1, STALL_FAULT),
        (1.15 * RATED_TORQUE, 100.0, 1, 0),
        (GREATEST_TORQUE, 0.0, 1, 0),
        (GREATEST_TORQUE, 100.0, 0, 0),
    ],
)
def test_a_shaft_stalls_that_is_to_turn_and_stands_under_more_torque_than_any_load(
    torque: float, reference: float, regulates: int, fault: int
) -> None:
    drive = Drive(0.0, reference=reference)
    drive.state.regulates_speed = regulates
    drive.state.torque = torque
    found, step = drive.steps_to_fault(600)
    assert found == fault
    if fault:
        assert (step + 1) * PERIOD == pytest.approx(300 * PERIOD, abs=2.0 * PERIOD)


def between_edges(**state: float) -> Drive:
    """Return a drive whose Hall switches have shown no edge for longer than a lost one explains."""
    drive = Drive(100.0, hall=1)
    values = {"is_overdue": 1, "edge_rate": POLE_PAIRS * 100.0, "resistance": 0.57, "magnet_flux": 0.0879}
    for name, value in {
        **values,
        "quadrature_inductance": 22.78e-3,
        "direct_inductance": 8.72e-3,
        **state,
    }.items():
        drive.state[name] = value
    return drive


RESISTIVE = 0.57 * 3.0
INDUCED = POLE_PAIRS * 100.0 * 0.0879


@pytest.mark.parametrize(
    ("state", "fault"),
    [
        ({"quadrature_voltage": RESISTIVE + INDUCED}, SHAFT_FAULT),
        ({"quadrature_voltage": RESISTIVE + 0.3 * INDUCED}, 0),
        ({"quadrature_voltage": RESISTIVE}, 0),
        # The current rises by 0.05 A in a period, for which the inductance takes 11.4 V.
        ({"quadrature_voltage": RESISTIVE + 11.4, "quadrature_before": 2.95}, 0),
        # The current along the magnet's axis takes two fifths of the flux.
        ({"quadrature_voltage": RESISTIVE + 0.4 * INDUCED, "direct_seen": -4.0}, SHAFT_FAULT),
        ({"quadrature_voltage": RESISTIVE + INDUCED, "is_overdue": 0}, 0),
    ],
    ids=["turning", "slow", "standing", "rising", "weakened", "in time"],
)
def test_a_position_is_lost_where_no_edge_comes_and_the_magnet_still_induces(
    state: dict[str, float], fault: int
) -> None:
    drive = between_edges(**{"quadrature_seen": 3.0, "quadrature_before": 3.0, **state})
    assert drive.steps_to_fault(10)[0] == fault


def test_hall_switches_show_a_speed_at_their_edges_alone() -> None:
    drive = Drive(100.0, reference=0.0, hall=1)

    def wait_for_an_edge(k: int) -> None:
        # 100 rad/s may be 4 rad/s after 20 ms without an edge.
        drive.sense.speed = 100.0 if k < 200 else 4.0

    assert drive.steps_to_fault(400, wait_for_an_edge)[0] == 0
    exact = Drive(100.0, reference=0.0)
    assert exact.steps_to_fault(400, slowing(exact, 5.0))[0] == SHAFT_FAULT


@pytest.mark.parametrize(("edges", "fault"), [(False, STALL_FAULT), (True, 0)])
def test_hall_switches_show_by_their_edges_whether_a_shaft_stands(edges: bool, fault: int) -> None:
    drive = Drive(5.0, hall=1)
    drive.state.torque = GREATEST_TORQUE

    def pass_edges(k: int) -> None:
        if edges and k % 500 == 499:
            drive.sense.hall = 3 if drive.sense.hall == 1 else 1

    found, step = drive.steps_to_fault(3000, pass_edges)
    assert found == fault
    if fault:
        # A tenth of the greatest torque turns the shaft by a sector in this time.
        passed = (2.0 * pi / 3.0 / POLE_PAIRS * INERTIA / (0.1 * GREATEST_TORQUE)) ** 0.5
        assert step * PERIOD == pytest.approx(passed, abs=2.0 * PERIOD)


@pytest.mark.parametrize(
    ("peak", "speed", "left", "fault"),
    [
        (3.0, 300.0, 0.0, PHASE_FAULT),
        (3.0, 60.0, 0.0, PHASE_FAULT),
        (3.0, 1200.0, 0.0, PHASE_FAULT),
        (3.0, 300.0, 0.11, PHASE_FAULT),
        (3.0, 300.0, 0.3, 0),
        (0.9, 300.0, 0.0, 0),
    ],
)
def test_a_phase_with_hardly_any_current_is_missing_where_the_others_carry_some(
    peak: float, speed: float, left: float, fault: int
) -> None:
    drive = Drive(speed, peak=peak)
    # The second phase's current is greatest, and the first one's rises.
    drive.sense.angle = tau / 3.0 / POLE_PAIRS

    def open_phase(_: int) -> None:
        # The diodes of the open leg carry a share of the expected amplitude.
        drive.currents[0] = -left * peak
        drive.currents[2] = -drive.currents[1] - drive.currents[0]

    found, step = drive.steps_to_fault(200, open_phase)
    assert found == fault
    if fault:
        # The field turns by 36 degrees in at least 5 periods.
        needed = max(pi / 5.0 / (POLE_PAIRS * speed * PERIOD), 5.0)
        assert needed - 1.0 <= step <= 1.7 * needed


@pytest.mark.parametrize(("used", "fault"), [(0.0, PHASE_FAULT), (0.55, 0)])
def test_current_against_its_reference_is_that_of_diodes_unless_the_voltage_limit_slows_it(
    used: float, fault: int
) -> None:
    drive = Drive(300.0)
    drive.sense.supply_voltage = NAMEPLATE.supply_voltage
    drive.state.along_voltage[0], drive.state.across_voltage[0] = used * NAMEPLATE.supply_voltage, 0.0
    drive.sense.angle = tau / 3.0 / POLE_PAIRS

    def conduct_through_diodes(_: int) -> None:
        drive.currents[0] = -0.9
        drive.currents[2] = -drive.currents[1] - drive.currents[0]

    assert drive.steps_to_fault(200, conduct_through_diodes)[0] == fault


@pytest.mark.parametrize(("approach", "fault"), [(0.005, 0), (0.0, PHASE_FAULT)])
def test_a_current_vector_that_stands_misses_no_phase_while_it_approaches_its_reference(
    approach: float, fault: int
) -> None:
    drive = Drive(300.0)
    drive.state.quadrature_inductance = NAMEPLATE.quadrature_inductance
    drive.state.direct_aim, drive.state.quadrature_aim = 0.0, 3.0

    def stand(k: int) -> None:
        current = 3.0 * (1.0 - approach * k)
        drive.currents[:] = [current, -current, 0.0]
        watch_approach(drive.state, 0.0, current, 0.0, -3.0)

    assert drive.steps_to_fault(100, stand)[0] == fault


@pytest.mark.parametrize(("turns", "fault"), [(False, 0), (True, PHASE_FAULT)])
def test_a_shaft_that_swings_does_not_turn_past_a_phase(turns: bool, fault: int) -> None:
    drive = Drive(0.0, reference=0.0)
    drive.state.farthest_drift = tau

    def swing(k: int) -> None:
        drive.sense.angle = 0.01 * k if turns else 0.01 * (k % 2)
        drive.currents[:] = [0.0, 2.6, -2.6]

    assert drive.steps_to_fault(100, swing)[0] == fault


def test_a_fault_is_held_for_good_with_all_legs_off() -> None:
    drive = Drive(300.0)

    def shift(k: int) -> None:
        if k < 30:
            drive.currents[0] += LIMIT

    assert drive.steps_to_fault(60, shift)[0] == CURRENT_FAULT
    drive.turn(300.0)
    assert detect_fault(drive.state, drive.sense), "the sum is zero again, and the fault stays"
    command: Any = duty_command_record().view(np.recarray)[0]
    hold_safe_state(drive.state, command)
    assert (command.first_leg, command.second_leg, command.third_leg) == (LEG_OFF,) * 3
    assert command.fault == CURRENT_FAULT
