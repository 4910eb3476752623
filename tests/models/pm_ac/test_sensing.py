"""Shunts with their blind windows, encoder and Hall switches, each by itself and in closed loop."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.models.duty_runs import COLUMN, PERIOD, course, nameplate_of, rating, reset_controller

from drivegate_models.contract.duty.records import DUTY_SENSE
from drivegate_models.contract.duty.signals import LEG_HIGH, LEG_LOW, LEG_OFF, LEG_PWM
from drivegate_models.controllers.duty.foc import step_function
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.schedule import steady
from drivegate_models.loop.sensing.converters import Converters, real_converters
from drivegate_models.loop.sensing.encoder import (
    Encoder,
    encoder_count,
    encoder_speed,
    lose_count,
    turn_encoder,
    turning_encoder,
)
from drivegate_models.loop.sensing.hall import (
    EDGES,
    Hall,
    hall_angle,
    hall_bits,
    hall_speed,
    lose_switching,
    turn_hall,
    turning_hall,
)
from drivegate_models.machine.load import CONSTANT_TORQUE, Load
from drivegate_models.pm_ac.closed_loop import DutyRun, prepared_duty_loop
from drivegate_models.pm_ac.loop_inputs import DutyLoopInputs
from drivegate_models.pm_ac.plant.drive import CENTRED, FALLING, RISING, PmAcDrive
from drivegate_models.pm_ac.sensing import (
    DC_LINK,
    IN_LINE,
    LOW_SIDE,
    DutySensors,
    low_side_ratio,
    low_time,
    real_duty_sensors,
    show_phase_currents,
    show_shaft,
)

Factory = Callable[..., PmAcDrive]
HALL_STATES = (1, 3, 2, 6, 4, 5)


def converters(seed: int = 1, **changes: Any) -> Converters:
    """Return converters of 12 bits with the noise of usual ones, but for what is changed."""
    values: dict[str, Any] = {
        "current_range": 10.0,
        "current_gain_spread": 0.0,
        "current_offset": 0.0,
        "current_noise": 0.0,
        "voltage_range": 200.0,
        "voltage_noise": 0.0,
        "converter_bits": 12,
    }
    return real_converters(np.random.default_rng(seed), np.ones(3), np.zeros(3), **(values | changes))


def encoder(lines: int, speed: float, angle: float = 0.0) -> Encoder:
    """Return an encoder on a shaft that turns from an angle."""
    return turning_encoder(
        lines=lines,
        speed_window=2e-3,
        clock=1e-8,
        control_period=PERIOD,
        initial_speed=speed,
        initial_angle=angle,
        glitches=np.zeros((0, 2)),
    )


def hall(pole_pairs: int, speed: float, angle: float = 0.0) -> Hall:
    """Return Hall switches in their places on a shaft that turns."""
    return turning_hall(
        pole_pairs=pole_pairs,
        placement_errors=np.zeros(6),
        greatest_error=0.0,
        hysteresis=0.0,
        clock=1e-7,
        initial_angle=angle,
        initial_speed=speed,
    )


def seen(sensors: DutySensors, ratios: tuple[float, float, float], alignment: int = CENTRED) -> list[float]:
    currents = np.array([3.0, -1.0, -2.0])
    show_phase_currents(sensors, currents, alignment, np.array(ratios), PERIOD)
    return [round(float(current), 2) for current in currents]


@pytest.mark.kernel
@pytest.mark.parametrize(
    ("alignment", "ratio", "time"),
    [
        (CENTRED, 0.9, 0.05),
        (FALLING, 0.9, 0.1),
        (RISING, 0.9, 0.0),
        (RISING, 0.0, 1.0),
        (CENTRED, 0.0, 1.0),
        (CENTRED, 1.2, 0.0),
    ],
)
def test_the_lower_switch_is_on_before_the_end_of_a_period(alignment: int, ratio: float, time: float) -> None:
    assert low_time(alignment, ratio, PERIOD) == pytest.approx(time * PERIOD, abs=1e-18)


@pytest.mark.kernel
def test_a_leg_that_is_held_shows_what_its_lower_switch_does() -> None:
    assert [low_side_ratio(0.3, mode) for mode in (LEG_PWM, LEG_HIGH, LEG_LOW, LEG_OFF)] == [
        0.3,
        1.0,
        0.0,
        1.0,
    ]


@pytest.mark.kernel
def test_in_line_shunts_see_all_phases_through_gains_offsets_and_steps() -> None:
    exact = real_duty_sensors(converters(), shunt=IN_LINE)
    assert seen(exact, (1.0, 1.0, 1.0)) == [3.0, -1.0, -2.0]
    biased = converters()._replace(gains=np.array([1.1, 1.0, 1.0]), offsets=np.array([0.0, 0.2, 0.0]))
    assert seen(real_duty_sensors(biased), (0.5, 0.5, 0.5)) == [3.3, -0.8, -2.0]
    currents = np.array([1.23456, 20.0, -20.0])
    coarse = real_duty_sensors(converters(converter_bits=5))
    show_phase_currents(coarse, currents, CENTRED, np.full(3, 0.5), PERIOD)
    assert list(currents) == pytest.approx([1.25, 10.0, -10.0])


@pytest.mark.kernel
def test_low_side_shunts_leave_a_blind_phase_to_the_other_two() -> None:
    sensors = real_duty_sensors(
        converters()._replace(offsets=np.array([0.3, 0.0, 0.0])), shunt=LOW_SIDE, window=5e-6
    )
    assert seen(sensors, (0.5, 0.5, 0.5)) == [3.3, -1.0, -2.0]
    # 10 % low, a half of it before the sampling instant, is just enough; less is not.
    assert seen(sensors, (0.899, 0.5, 0.5)) == [3.3, -1.0, -2.0]
    assert seen(sensors, (0.901, 0.5, 0.5)) == [3.0, -1.0, -2.0]
    assert seen(sensors, (0.5, 0.95, 0.5)) == [3.3, -1.3, -2.0]
    # At the peak of the carrier no lower switch is on, and what was seen last goes on.
    assert seen(sensors, (0.5, 0.5, 0.5), RISING) == [3.3, -1.3, -2.0]


@pytest.mark.kernel
def test_a_shunt_in_the_link_sees_the_outer_legs_while_each_is_alone() -> None:
    sensors = real_duty_sensors(
        converters()._replace(offsets=np.array([0.1, 0.2, 0.3])), shunt=DC_LINK, window=5e-6
    )
    # First and third leg are alone for long enough; the second one, in the middle, follows from them.
    assert seen(sensors, (0.8, 0.5, 0.2)) == [3.1, -1.4, -1.7]
    # The third leg's interval is too short: it and the second one go on from before.
    assert seen(sensors, (0.8, 0.25, 0.2)) == [3.1, -1.4, -1.7]


@pytest.mark.kernel
def test_the_noise_follows_from_its_seed() -> None:
    shown = []
    for seed in (1, 1, 2):
        sensors = real_duty_sensors(converters(seed, current_noise=0.1, converter_bits=16))
        currents = np.zeros((200, 3))
        for row in currents:
            show_phase_currents(sensors, row, CENTRED, np.full(3, 0.5), PERIOD)
        shown.append(currents)
    assert np.array_equal(shown[0], shown[1])
    assert not np.array_equal(shown[0], shown[2])
    assert shown[0].std() == pytest.approx(0.1, rel=0.1)


@pytest.mark.kernel
@pytest.mark.parametrize("speed", [30.0, -30.0])
def test_an_encoder_counts_and_times_edges_either_way(speed: float) -> None:
    turning = encoder(100, abs(speed))
    for step in range(100):
        turn_encoder(turning, step, step * PERIOD, PERIOD, speed)
    turned = 100 * PERIOD * speed
    assert encoder_count(turning) == math.floor(turned / turning.edge_angle)
    assert encoder_speed(turning) == pytest.approx(speed, rel=1e-4)
    for step in range(100, 300):
        turn_encoder(turning, step, step * PERIOD, PERIOD, 0.0)
    assert abs(encoder_speed(turning)) < turning.edge_angle / (150 * PERIOD), "without edges it comes to rest"


@pytest.mark.kernel
@pytest.mark.parametrize("speed", [30.0, -30.0, 0.5])
def test_an_encoder_that_misses_an_edge_is_off_by_it_for_good(speed: float) -> None:
    whole, missing = encoder(100, abs(speed)), encoder(100, abs(speed))
    for turning in (whole, missing):
        for step in range(400):
            if step == 50 and turning is missing:
                lose_count(turning)
            turn_encoder(turning, step, step * PERIOD, PERIOD, speed)
    assert encoder_count(whole) - encoder_count(missing) == math.copysign(1.0, speed)
    if abs(speed) > 1.0:
        assert encoder_speed(missing) == encoder_speed(whole), "behind the window the speed is right again"


def test_the_middle_between_two_edges_is_shown() -> None:
    turning = encoder(100, 30.0, angle=0.25)
    sensors = real_duty_sensors(converters(), encoder=turning)
    sense = np.zeros(1, DUTY_SENSE)
    for step in range(57):
        turn_encoder(turning, step, step * PERIOD, PERIOD, 30.0)
    sense[0]["supply_voltage"] = 96.03
    show_shaft(sensors, sense[0], 57, PERIOD)
    assert sense[0]["angle"] == pytest.approx(0.25 + 57 * PERIOD * 30.0, abs=0.5 * turning.edge_angle)
    assert sense[0]["encoder_count"] == encoder_count(turning)
    assert sense[0]["supply_voltage"] == pytest.approx(96.03, abs=0.5 * 200.0 / 4096)


@pytest.mark.kernel
def test_hall_switches_change_one_bit_an_edge() -> None:
    switches = hall(2, 50.0)
    angle, bits, errors = 0.0, [], []
    for step in range(700):
        turn_hall(switches, step * PERIOD, PERIOD, 50.0)
        angle += 2.0 * 50.0 * PERIOD
        errors.append(math.remainder(hall_angle(switches, (step + 1) * PERIOD) - angle, 2.0 * math.pi))
        if not bits or bits[-1] != hall_bits(switches):
            bits.append(hall_bits(switches))
    begin = bits.index(1)
    assert bits[begin : begin + 7] == [*HALL_STATES, 1]
    assert max(map(abs, errors)) < 1e-3, "at a steady speed the timer follows the angle"
    resting = hall(2, 0.0, 1.0)
    assert hall_angle(resting, 0.0) == pytest.approx(math.pi / 3.0), "at rest it is the middle of the sector"


@pytest.mark.kernel
def test_hall_switches_that_miss_an_edge_keep_their_state_for_a_sector_and_change_by_two() -> None:
    whole, missing = hall(2, 50.0), hall(2, 50.0)
    states: list[tuple[int, int]] = []
    speeds = []
    for step in range(1400):
        if step == 250:
            lose_switching(missing)
        for switches in (whole, missing):
            turn_hall(switches, step * PERIOD, PERIOD, 50.0)
        both = (HALL_STATES.index(hall_bits(whole)), HALL_STATES.index(hall_bits(missing)))
        if not states or states[-1] != both:
            states.append(both)
        speeds.append(hall_speed(missing))
    apart = [place for place, (first, second) in enumerate(states) if first != second]
    assert len(apart) == 1, "it is off for one sector alone"
    (place,) = apart
    before, behind = states[place - 1][1], states[place + 1][1]
    assert states[place][1] == before
    assert (behind - before) % EDGES == 2
    assert min(speeds[:260]) == pytest.approx(50.0, rel=1e-4)
    assert min(speeds) == pytest.approx(25.0, rel=0.05), "two sectors without an edge halve the speed"
    assert speeds[-600:] == pytest.approx([50.0] * 600, rel=1e-3), "the time of the lost edge is made up for"


def run_foc(drive: PmAcDrive, sensors: DutySensors | None, speed: float, torque: float) -> DutyRun:
    state = reset_controller("foc", nameplate_of(drive))
    return prepared_duty_loop(
        DutyLoopInputs(
            drive=drive,
            load=Load(CONSTANT_TORQUE, torque),
            schedule=course(drive, steady(speed), steady(1.0)),
            control_period=PERIOD,
            duration=1.0,
            initial_speed=speed,
            sensors=sensors,
        ),
        SteppedController(step_function().address, state.ctypes.data),
    ).run()


def currents_of(run: DutyRun) -> np.ndarray:
    assert run.status == COMPLETED
    return run.trace[-4000:, [COLUMN["direct"], COLUMN["quadrature"]]]


def test_an_encoder_of_more_edges_distorts_less(interior: Factory) -> None:
    drive = interior()
    speed = 0.5 * rating(drive)[0]
    unrest = []
    for lines in (1024, 100, 25):
        run = run_foc(drive, real_duty_sensors(converters(), encoder=encoder(lines, speed)), speed, 1.2)
        assert run.trace[-4000:, COLUMN["speed"]].mean() == pytest.approx(speed, rel=1e-3)
        unrest.append(float(np.std(currents_of(run), axis=0).max()))
    assert 2.0 * unrest[0] < unrest[1] < 0.5 * unrest[2], f"{unrest} A with 4096, 400 and 100 edges"
    assert unrest[0] < 0.02


def test_it_runs_by_hall_switches_alone(interior: Factory) -> None:
    drive = interior()
    speed = 0.5 * rating(drive)[0]
    run = run_foc(drive, real_duty_sensors(converters(), hall=hall(drive.pole_pairs, speed)), speed, 1.2)
    assert run.trace[-4000:, COLUMN["speed"]].mean() == pytest.approx(speed, rel=1e-2)
    assert np.std(currents_of(run), axis=0).max() < 0.2


def test_an_offset_of_one_shunt_makes_torque_ripple_at_the_frequency_of_the_currents(
    interior: Factory,
) -> None:
    drive = interior()
    speed = 0.25 * rating(drive)[0]
    torques = []
    for offset in (0.0, 0.3):
        shunts = converters()._replace(offsets=np.array([offset, 0.0, 0.0]))
        torques.append(run_foc(drive, real_duty_sensors(shunts), speed, 1.2).trace[-4000:, COLUMN["torque"]])
    assert np.std(torques[1]) > 5.0 * np.std(torques[0])
    spectrum = np.abs(np.fft.rfft(torques[1] - torques[1].mean()))
    frequency = np.argmax(spectrum) / (4000 * PERIOD)
    assert frequency == pytest.approx(drive.pole_pairs * speed / (2.0 * math.pi), rel=0.05)


def test_a_blind_window_costs_nothing_while_the_duty_ratios_leave_it(interior: Factory) -> None:
    drive = interior()
    speed = 0.3 * rating(drive)[0]
    runs = [
        run_foc(drive, real_duty_sensors(converters(), shunt=shunt, window=window), speed, 1.2)
        for shunt, window in ((IN_LINE, 0.0), (LOW_SIDE, 2e-6), (LOW_SIDE, 4e-5))
    ]
    assert runs[0].trace.tobytes() == runs[1].trace.tobytes()
    assert runs[0].trace.tobytes() != runs[2].trace.tobytes()
