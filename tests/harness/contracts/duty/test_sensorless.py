"""Runs without a position sensor: what is sensed, who is refused, and that `foc-sensorless` turns the shaft."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from drivegate import DutyCommand, DutySense
from drivegate.candidates.builtin.duty_loading import DutyController
from drivegate.candidates.declaration import NOTHING_DECLARED, Declaration
from drivegate.candidates.fault import CandidateFault
from drivegate.candidates.python.bridge import PythonController
from drivegate.contracts.duty.checks.accuracy import ROB_5
from drivegate.contracts.duty.checks.sensorless.steady import SLS_8
from drivegate.contracts.duty.checks.starting import STA_1
from drivegate.contracts.duty.contract import DUTY
from drivegate.contracts.duty.run import refusal_of
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.contracts.duty.scenarios.sensorless import least_rpm, slowly_loaded
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import with_scales
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.failure_kind import FAILURE_KINDS
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.duty.records import duty_command_record
from drivegate_models.contract.duty.signals import LEG_OFF
from drivegate_models.errors import InputError
from drivegate_models.loop.exchange import NOT_FINITE
from drivegate_models.pm_ac.closed_loop import prepared_duty_loop
from drivegate_models.units import RADIANS_PER_RPM


def drive_of(name: str) -> PmAcDocument:
    drive = load_drive(name).with_overrides(["sensing.position=none"])
    assert isinstance(drive, PmAcDocument)
    return drive


TWO_KW = drive_of("pm-ac-2kw")
LEAST_RPM = TWO_KW.least_speed_rpm
RATED_NM = TWO_KW.rating.rated_torque_nm


def speed_run(
    *speeds: tuple[float, float],
    end_s: float,
    torque_nm: float = 0.0,
    drive: PmAcDocument = TWO_KW,
    **more: Any,
) -> Scenario:
    load = ConstantTorqueLoad(kind="constant_torque", torque_nm=torque_nm)
    return Scenario(name="run", drive=drive, speed_rpm=speeds, duration_s=end_s, load=load, **more)


class Idle:
    """A candidate that keeps the bridge off and remembers what it sensed."""

    def __init__(self) -> None:
        self.senses: list[DutySense] = []

    def reset(self, nameplate: Any) -> None:
        self.nameplate = nameplate

    def step(self, sense: DutySense) -> DutyCommand:
        self.senses.append(sense)
        return DutyCommand((0.5, 0.5, 0.5), (LEG_OFF, LEG_OFF, LEG_OFF))


@pytest.mark.parametrize("sensors", ["ideal", "shunts"])
def test_nothing_shows_the_shaft(sensors: str) -> None:
    idle = Idle()
    run = speed_run((0.0, 500.0), end_s=2e-3, initial_speed_rpm=500.0).replaced(sensors=sensors)
    run_scenario(run, PythonController(idle))
    for sense in idle.senses:
        assert math.isnan(sense.angle)
        assert math.isnan(sense.speed)
        assert (sense.hall, sense.encoder_count) == (-1, -1)
    assert idle.nameplate.position == 3
    # The terminals still show the EMF of the turning shaft.
    voltages = np.array([sense.phase_voltages for sense in idle.senses])
    assert np.ptp(voltages[-1]) > 50.0


def test_a_controller_that_needs_the_angle_is_refused_in_one_sentence() -> None:
    with pytest.raises(
        InputError, match="'foc' needs the shaft's angle, but this drive has no position sensor"
    ):
        run_scenario(speed_run((0.0, 500.0), end_s=1e-3), DutyController("foc"))


def test_a_candidate_that_uses_the_angle_is_told_why_it_failed() -> None:
    command = duty_command_record()[0]
    told = "; this drive has no position sensor, so angle and speed are NaN"
    assert refusal_of(command, NOT_FINITE, has_sensor=False) == refusal_of(command, NOT_FINITE) + told


class Unready(Idle):
    """A candidate whose duty ratios follow the angle."""

    def step(self, sense: DutySense) -> DutyCommand:
        return DutyCommand((0.5 + 0.1 * sense.angle, 0.5, 0.5))


def test_a_python_candidate_that_uses_the_angle_is_told_why_it_failed() -> None:
    with pytest.raises(CandidateFault, match="but all must be finite; this drive has no position sensor"):
        run_scenario(speed_run((0.0, 500.0), end_s=1e-3), PythonController(Unready()))


def test_checks_of_a_sensor_do_not_apply() -> None:
    for check in (STA_1, ROB_5):
        assert check.reason_not_applicable(Declaration(), TWO_KW) == "the drive has no position sensor"
        assert check.reason_not_applicable(Declaration(), load_drive("pm-ac-2kw")) is None


def test_no_fixed_run_needs_a_sensor() -> None:
    for run in fixed_scenarios(TWO_KW, detected=FAILURE_KINDS):
        assert run.failure is None or run.failure.kind not in ("lost-position", "lost-edge", "slip"), run.name


CONTROLLER = DutyController("foc-sensorless")


def electrical_error_deg(result: Any, drive: PmAcDocument) -> Any:
    error = drive.machine.pole_pairs * result.commands["angle"] - result.column("angle")
    return np.degrees(np.mod(error + np.pi, 2.0 * np.pi) - np.pi)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("angle_deg", [0.0, 90.0, 180.0, 300.0])
def test_it_starts_under_half_of_rated_torque(angle_deg: float, sense: float) -> None:
    wanted = 2.0 * sense * LEAST_RPM
    run = speed_run((0.0, wanted), end_s=1.8, torque_nm=0.5 * RATED_NM, initial_angle_deg=angle_deg)
    result = run_scenario(run, CONTROLLER)
    speed = sense * result.column("speed") / RADIANS_PER_RPM
    assert speed[result.column("time") < TWO_KW.start_time_s].max() > LEAST_RPM
    assert speed[-1] == pytest.approx(2.0 * LEAST_RPM, rel=0.01)
    assert np.max(result.column("peak_current")) < 1.05 * TWO_KW.rating.current_limit_a
    assert abs(electrical_error_deg(result, TWO_KW)[-100:]).max() < 5.0
    assert np.all(result.commands["fault"] == 0)


@pytest.mark.parametrize("speed_rpm", [2.0 * LEAST_RPM, 1300.0, -2000.0])
def test_it_takes_over_a_turning_shaft(speed_rpm: float) -> None:
    result = run_scenario(speed_run((0.0, speed_rpm), end_s=0.3, initial_speed_rpm=speed_rpm), CONTROLLER)
    assert np.max(result.column("peak_current")) < 1.05 * TWO_KW.rating.current_limit_a
    assert result.column("speed")[-1] / RADIANS_PER_RPM == pytest.approx(speed_rpm, rel=0.01)
    assert abs(electrical_error_deg(result, TWO_KW)[-100:]).max() < 5.0


def test_it_reverses_through_standstill() -> None:
    points = ((0.0, 600.0), (0.2, 600.0), (1.2, -600.0))
    run = speed_run(*points, end_s=1.8, torque_nm=0.3 * RATED_NM, initial_speed_rpm=600.0)
    result = run_scenario(run, CONTROLLER)
    assert result.column("speed")[-1] / RADIANS_PER_RPM == pytest.approx(-600.0, rel=0.01)
    assert np.max(result.column("peak_current")) < 1.05 * TWO_KW.rating.current_limit_a


def test_it_turns_its_legs_off_when_the_rotor_locks() -> None:
    run = speed_run((0.0, 800.0), end_s=1.2, torque_nm=0.3 * RATED_NM, initial_speed_rpm=800.0)
    locked = run.replaced(failure={"kind": "locked-rotor", "time_s": 0.5, "phase": 1})
    result = run_scenario(locked, CONTROLLER)
    late = result.commands[result.column("time") > 1.0]
    assert np.all(late["fault"] == 7)
    assert np.all(late["first_leg"] == LEG_OFF)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("name", "scale", "factor", "share"),
    [
        ("pm-ac-interior", "resistance", 1.3, 0.8),
        ("pm-ac-surface", "inductance", 0.8, -0.8),
        ("pm-ac-hub", "emf_constant", 0.9, 0.8),
    ],
)
def test_it_bears_a_load_on_another_machine_than_the_nameplate(
    name: str, scale: str, factor: float, share: float
) -> None:
    drive = drive_of(name)
    run = with_scales(slowly_loaded(drive, least_rpm(drive, 2.0), share), **{scale: factor})
    assert DUTY.unfair_because(run) is None
    margin = SLS_8.evaluate(DUTY.record(prepared_duty_loop, NOTHING_DECLARED, run, CONTROLLER))
    assert margin is not None
    assert margin.met, margin
