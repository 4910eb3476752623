"""Runs through Hall switches: the windows rest on what they give, all else that is observed stays true."""

from __future__ import annotations

import math
from typing import Any

import pytest

from drivegate import Command, Nameplate, Sense
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.current.run import plant_sensors
from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import with_dropout
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.machine import ledger

STAR = load_drive("star-3-phase")
PLAIN = steady_scenario(STAR, 1000.0, power_share=0.8, constant_power=False).replaced(duration_s=2.0)
WORST: dict[str, Any] = {"kind": "hall", "placement_error_deg": 15.0, "hysteresis_deg": 15.0, "clock_s": 1e-3}
EXACT: dict[str, Any] = {"kind": "hall", "placement_error_deg": 0.0, "hysteresis_deg": 0.0, "clock_s": 1e-9}


class Constant:
    """Answers the same throughout, and notes the speed that it senses."""

    def __init__(self, degrees: float) -> None:
        self._degrees = degrees
        self.speeds: list[float] = []

    def reset(self, nameplate: Nameplate) -> None:
        self.speeds.clear()

    def step(self, sense: Sense) -> Command:
        self.speeds.append(sense.speed)
        return Command(20.0, math.radians(self._degrees))


def locked(rpm: float, sensors: dict[str, Any] | str, degrees: float) -> ClosedLoopRun:
    scenario = Scenario(
        name="locked",
        drive=STAR,
        duration_s=0.5,
        speed_rpm=((0.0, rpm),),
        initial_speed_rpm=rpm,
        load={"kind": "locked"},
        sensors=sensors,
    )
    return run_scenario(scenario, PythonController(Constant(degrees)))


def reference_run(scenario: Scenario) -> ClosedLoopRun:
    return run_scenario(scenario, load_controller(resolve_candidate("reference")))


@pytest.mark.parametrize(("rpm", "degrees"), [(300.0, 0.0), (900.0, 3.0), (1400.0, 40.0), (1400.0, 89.0)])
def test_a_late_edge_is_less_advance_than_was_commanded(rpm: float, degrees: float) -> None:
    late = locked(rpm, EXACT | {"hysteresis_deg": 5.0}, degrees)
    exact = locked(rpm, EXACT, degrees)
    ideal = locked(rpm, "ideal", degrees)
    # All but the number of events, of which a tick more or less makes another one.
    assert exact.totals[: ledger.EVENTS] == pytest.approx(ideal.totals[: ledger.EVENTS], rel=1e-3), (
        "switches without an error change the plant"
    )
    impulse = late.totals[ledger.IMPULSE]
    if degrees >= 5.0:
        less = locked(rpm, "ideal", degrees - 5.0)
        assert impulse == pytest.approx(less.totals[ledger.IMPULSE], rel=1e-3)
    assert impulse != pytest.approx(ideal.totals[ledger.IMPULSE], rel=1e-3), "the angle's error does nothing"


@pytest.mark.parametrize("drive", ["star-3-phase", "fan-3-phase"])
@pytest.mark.parametrize("seed", [1, 2])
def test_every_period_closes_whatever_the_windows_do(drive: str, seed: int) -> None:
    """With errors that take the advance below zero, and past a quarter of a cycle."""
    document = load_drive(drive)
    rating = document.rating
    for speed in (0.02 * rating.base_speed_rpm, 1.1 * rating.base_speed_rpm, rating.overspeed_rpm):
        scenario = steady_scenario(document, round(speed), power_share=0.3, constant_power=False)
        scenario = scenario.replaced(duration_s=0.6, sensors=WORST, seed=seed)
        for degrees in (0.0, 90.0):
            run = run_scenario(scenario, PythonController(Constant(degrees)))
            assert run.observed.exchange_error < 1e-9, f"{drive}, {speed:g} rpm, {degrees:g}°"


def test_a_run_is_a_function_of_its_scenario() -> None:
    scenario = PLAIN.replaced(sensors="hall", seed=7)
    first, again = reference_run(scenario), reference_run(scenario)
    assert (first.digest, list(first.totals)) == (again.digest, list(again.totals))
    assert first.digest != reference_run(scenario.replaced(seed=8)).digest, "the seed draws nothing"


def test_each_edge_has_its_own_error_within_what_is_stated() -> None:
    lags = plant_sensors(PLAIN.replaced(sensors=WORST, seed=7)).hall.lags
    assert len(set(lags)) == 6
    assert all(0.0 <= math.degrees(lag) <= 30.0 for lag in lags)
    none = plant_sensors(PLAIN.replaced(sensors=WORST | {"placement_error_deg": 0.0}, seed=7)).hall.lags
    assert [math.degrees(lag) for lag in none] == pytest.approx([15.0] * 6)


def test_a_lost_speed_reads_zero_and_the_windows_go_on() -> None:
    instance, plain = Constant(10.0), Constant(10.0)
    scenario = PLAIN.replaced(sensors="hall", duration_s=1.0)
    lost = with_dropout(scenario, "speed", 0.4, 0.1).replaced(duration_s=1.0)
    run = run_scenario(lost, PythonController(instance))
    assert set(instance.speeds[800:1000]) == {0.0}
    assert instance.speeds[799] > 0.0 < instance.speeds[1000]
    other = run_scenario(scenario, PythonController(plain))
    assert list(run.totals) == list(other.totals), "what a controller reads moves the windows"


def test_a_shaft_at_rest_starts_by_itself() -> None:
    """From every sector, without a speed and an edge to begin with."""
    for angle in range(0, 360, 20):
        scenario = PLAIN.replaced(
            sensors="hall",
            seed=angle,
            initial_speed_rpm=0.0,
            initial_angle_deg=float(angle),
            duration_s=0.5,
        )
        instance = Constant(0.0)
        run = run_scenario(scenario, PythonController(instance))
        assert instance.speeds[0] == 0.0
        assert run.observed.speed_final > 5.0, f"the shaft stays at {angle}°"
