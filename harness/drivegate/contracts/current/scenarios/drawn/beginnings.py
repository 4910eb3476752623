"""Drawn control periods, clocks and rotor angles, restarts in mid-run, and current sensors of single phases."""

from __future__ import annotations

from typing import Final

from hypothesis import strategies as st

from drivegate.contracts.current.scenarios.drawn.changes import load_step_scenarios
from drivegate.contracts.current.scenarios.drawn.steps import change_times, nonzero, steady_runs
from drivegate.scenarios.changes import (
    CLOCKS_S,
    moments,
    with_beginning,
    with_current_error,
    with_dropout,
    with_restarts,
)
from drivegate.scenarios.drive_scale import SpeedRange, scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

PERIODS_US: Final = (500, 400, 250, 200, 160, 125, 100, 80, 50)
"""Control periods that are drawn, of which a tenth of a second is a whole number (µs)."""
ROTOR_STEP_DEG: Final = 12
"""Step of the rotor's angle at the start (electrical degrees)."""
_ANGLES: Final = 360 // ROTOR_STEP_DEG


def beginning_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None = None
) -> st.SearchStrategy[Scenario]:
    """Draw control periods of 50 to 500 µs, clocks that do not begin at 0, and rotor angles."""
    runs = st.one_of(steady_runs(drive, speed_range), load_step_scenarios(drive, speed_range))
    periods = st.sampled_from(PERIODS_US)
    clocks, angles = st.sampled_from(CLOCKS_S), st.integers(0, _ANGLES - 1)
    single = [
        st.tuples(periods.filter(lambda period: period != PERIODS_US[0]), st.just(CLOCKS_S[0]), st.just(0)),
        st.tuples(st.just(PERIODS_US[0]), clocks.filter(bool), st.just(0)),
        st.tuples(st.just(PERIODS_US[0]), st.just(CLOCKS_S[0]), angles.filter(bool)),
    ]
    return st.builds(
        lambda beginning, run: with_beginning(
            run,
            control_period_s=beginning[0] / 1e6,
            clock_start_s=beginning[1],
            initial_angle_deg=float(ROTOR_STEP_DEG * beginning[2]),
        ),
        st.one_of(*single, st.tuples(periods, clocks, angles)),
        runs,
    )


def restart_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None = None
) -> st.SearchStrategy[Scenario]:
    """Draw resets of the running controller, one or twenty in a row."""
    return st.builds(
        lambda often, at, run: with_restarts(run, *_times(run, at, often)),
        st.booleans(),
        change_times(drive),
        steady_runs(drive, speed_range),
    )


def phase_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None = None
) -> st.SearchStrategy[Scenario]:
    """Draw current sensors of one phase with a wrong gain or offset, or with samples that are lost."""
    runs, offset_step = steady_runs(drive, speed_range), scale_of(drive).offset_step_a
    phases = st.integers(1, drive.machine.phases)
    gains = st.builds(
        lambda phase, steps, run: with_current_error(run, phase, gain=round(1.0 + 0.02 * steps, 2)),
        phases,
        nonzero(10),
        runs,
    )
    offsets = st.builds(
        lambda phase, steps, run: with_current_error(run, phase, offset_a=tidy(offset_step * steps)),
        phases,
        nonzero(10),
        runs,
    )
    return st.one_of(
        gains, offsets, st.builds(_with_lost_samples, st.booleans(), phases, change_times(drive), runs)
    )


def _times(run: Scenario, at: float, often: bool) -> tuple[float, ...]:
    return moments(at, every_s=scale_of(run.drive).repeated_every_s) if often else (at,)


def _with_lost_samples(often: bool, phase: int, at: float, run: Scenario) -> Scenario:
    for time in _times(run, at, often):
        run = with_dropout(run, "currents", time, run.control_period_s, phase=phase)
    return run
