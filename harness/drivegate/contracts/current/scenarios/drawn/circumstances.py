"""Drawn circumstances of a run: its beginning, restarts, a plant unlike its nameplate, real sensors, and faults."""

from __future__ import annotations

from typing import Final

from hypothesis import strategies as st

from drivegate.contracts.current.scenarios.building import lifted_scenario
from drivegate.contracts.current.scenarios.drawn.changes import load_step_scenarios
from drivegate.contracts.current.scenarios.drawn.steps import Drawn, change_times, nonzero, steady_runs
from drivegate.scenarios.changes import (
    CLOCKS_S,
    moments,
    stepped,
    with_beginning,
    with_current_error,
    with_drift,
    with_dropout,
    with_glitch,
    with_imbalance,
    with_lost_samples,
    with_real_sensors,
    with_restarts,
    with_scales,
)
from drivegate.scenarios.drive_scale import SpeedRange, scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.plant import NOMINAL
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import has_encoder, real_sensors

PERIODS_US: Final = (500, 400, 250, 200, 160, 125, 100, 80, 50)
"""Control periods that are drawn, of which a tenth of a second is a whole number (µs)."""
ROTOR_STEP_DEG: Final = 12
"""Step of the rotor's angle at the start (electrical degrees)."""
_ANGLES: Final = 360 // ROTOR_STEP_DEG


def beginning_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
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


def restart_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw resets of the running controller, one or twenty in a row."""
    return st.builds(
        lambda often, at, run: with_restarts(run, *_times(run, at, often)),
        st.booleans(),
        change_times(drive),
        steady_runs(drive, speed_range),
    )


def phase_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
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
    lost = st.builds(
        lambda often, phase, at, run: with_lost_samples(run, phase, _times(run, at, often)),
        st.booleans(),
        phases,
        change_times(drive),
        runs,
    )
    return st.one_of(gains, offsets, lost)


def _times(run: Scenario, at: float, often: bool) -> tuple[float, ...]:
    return moments(at, every_s=scale_of(run.drive).repeated_every_s) if often else (at,)


def _any_runs(drive: DriveDocument, speed_range: SpeedRange | None) -> Drawn:
    """Draw steady runs, those at rated power apart, and load steps."""
    return st.one_of(
        steady_runs(drive, speed_range),
        steady_runs(drive, speed_range, lightest=0),
        load_step_scenarios(drive, speed_range),
    )


def parameter_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw plants whose parameters are not the nameplate's, one of them or several."""
    friction_step = scale_of(drive).torque_step_nm
    values = {
        "resistance": _factors(-5, 10, 0.1),
        "inductance": _factors(-4, 4, 0.05),
        "emf_constant": _factors(-5, 5, 0.01),
        "friction_added_n_m": st.integers(0, 5).map(lambda count: tidy(friction_step * count)),
    }
    nominal = NOMINAL.model_dump()
    single = [
        st.fixed_dictionaries({key: value.filter(nominal[key].__ne__)}) for key, value in values.items()
    ]
    factors = st.one_of(*single, st.fixed_dictionaries(values))
    return st.builds(lambda values, run: with_scales(run, **values), factors, _any_runs(drive, speed_range))


def _factors(lowest: int, highest: int, step: float) -> st.SearchStrategy[float]:
    return st.integers(lowest, highest).map(lambda count: round(1.0 + step * count, 2))


def sensor_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw runs through the sensors that the drive has."""
    return _seen(_any_runs(drive, speed_range))


def _seen(runs: Drawn) -> Drawn:
    """Put the drive's own sensors before runs."""
    return st.builds(lambda seed, run: with_real_sensors(run, seed), st.integers(0, 999), runs)


def fault_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw lost signals, drift and lifted wheels, and false edges and unequal halves where a drive can have them."""
    runs, step = steady_runs(drive, speed_range), scale_of(drive).dropout_step_s
    lost = st.builds(
        lambda signal, at, steps, run: with_dropout(run, signal, at, tidy(step * steps)),
        st.sampled_from(("speed", "currents", "supply")),
        change_times(drive),
        st.integers(1, 20),
        st.one_of(runs, _seen(runs)),
    )
    false_edges = st.builds(
        lambda at, counts, run: with_glitch(run, counts, at), change_times(drive), nonzero(50), _seen(runs)
    )
    encoders = (false_edges,) if has_encoder(real_sensors(drive), drive) else ()
    unequal = st.builds(
        lambda at, percent, run: with_imbalance(run, stepped(0.0, percent / 100.0, at)),
        change_times(drive),
        nonzero(5),
        runs,
    )
    supplies = (unequal,) if drive.has_split_supply else ()
    lifts = st.builds(
        lambda run, at, halves, lifted: lifted_scenario(run, at, scale_of(drive).units(0.5 * halves), lifted),
        runs,
        change_times(drive),
        st.integers(1, 10),
        st.sampled_from((0.3, 0.5)),
    )
    return st.one_of(lost, *encoders, *supplies, _drifts(drive, runs), lifts)


def _drifts(drive: DriveDocument, runs: Drawn) -> Drawn:
    scale = scale_of(drive)

    def build(at: float, over: int, amounts: tuple[int, int], run: Scenario) -> Scenario:
        warmer, weaker = amounts
        resistance = stepped(1.0, round(1.0 + 0.05 * warmer, 2), at, over_s=scale.units(over))
        emf_constant = stepped(1.0, round(1.0 - 0.01 * weaker, 2), at, over_s=scale.units(over))
        return with_drift(
            run,
            resistance=resistance if warmer else None,
            emf_constant=emf_constant if weaker else None,
        )

    amounts = st.one_of(
        st.tuples(st.integers(1, 8), st.just(0)),
        st.tuples(st.just(0), st.integers(1, 5)),
        st.tuples(st.integers(1, 8), st.integers(1, 5)),
    )
    return st.builds(build, change_times(drive), st.integers(1, 10), amounts, runs)
