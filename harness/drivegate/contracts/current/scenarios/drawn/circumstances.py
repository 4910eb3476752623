"""Drawn plants that differ from the nameplate, sensors that are not ideal, and faults."""

from __future__ import annotations

from hypothesis import strategies as st

from drivegate.contracts.current.scenarios.drawn.changes import load_step_scenarios
from drivegate.contracts.current.scenarios.drawn.steps import change_times, nonzero, steady_runs
from drivegate.scenarios.changes import (
    stepped,
    with_drift,
    with_dropout,
    with_glitch,
    with_imbalance,
    with_real_sensors,
    with_scales,
)
from drivegate.scenarios.drive_scale import SpeedRange, scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.plant import NOMINAL
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import has_encoder, real_sensors


def _any_runs(drive: DriveDocument, speed_range: SpeedRange | None) -> st.SearchStrategy[Scenario]:
    """Draw steady runs, those at rated power apart, and load steps."""
    return st.one_of(
        steady_runs(drive, speed_range),
        steady_runs(drive, speed_range, lightest=0),
        load_step_scenarios(drive, speed_range),
    )


def parameter_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None = None
) -> st.SearchStrategy[Scenario]:
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


def sensor_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None = None
) -> st.SearchStrategy[Scenario]:
    """Draw runs through the sensors that the drive has."""
    return _seen(_any_runs(drive, speed_range))


def _seen(runs: st.SearchStrategy[Scenario]) -> st.SearchStrategy[Scenario]:
    """Put the drive's own sensors before runs."""
    return st.builds(lambda seed, run: with_real_sensors(run, seed), st.integers(0, 999), runs)


def fault_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None = None
) -> st.SearchStrategy[Scenario]:
    """Draw signals lost for a moment and drift, and false edges and unequal halves on drives that can have them."""
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
    return st.one_of(lost, *encoders, *supplies, _drifts(drive, runs))


def _drifts(drive: DriveDocument, runs: st.SearchStrategy[Scenario]) -> st.SearchStrategy[Scenario]:
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
