"""What a report shows of a run: its signals over time, few enough to be kept in the result document."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.fault import Fault
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.duty.run import DutyClosedLoopRun
from drivegate.contracts.judged_window import judged_window
from drivegate.drives.kinds import kind_of
from drivegate.drives.running import recorded
from drivegate.results.result import CheckOutcome, Recording
from drivegate_cases.documents.document import parse_document
from drivegate_cases.documents.rounding import significant
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.units import RADIANS_PER_RPM

MOST_POINTS: Final = 300
"""Most points that are kept of a run, each the mean of a stretch of it."""
DUTY_COLUMNS: Final[Mapping[str, tuple[str, float]]] = {
    "time_s": ("time", 1.0),
    "speed_reference_rpm": ("speed_reference", 1.0 / RADIANS_PER_RPM),
    "speed_rpm": ("speed", 1.0 / RADIANS_PER_RPM),
    "torque_reference_nm": ("torque_reference", 1.0),
    "torque_nm": ("torque", 1.0),
    "load_torque_nm": ("load", 1.0),
    "direct_current_a": ("direct", 1.0),
    "quadrature_current_a": ("quadrature", 1.0),
    "peak_current_a": ("peak_current", 1.0),
    "input_power_w": ("input_power", 1.0),
    "link_voltage_v": ("link", 1.0),
}
"""Columns that are kept of a run of duty ratios: each with its source and what that is multiplied by."""
VOLTAGE: Final = "voltage_v"
"""A further one: the peak voltage of a phase that the duty ratios ask for."""
COLUMNS: Final = (
    "time_s",
    "speed_reference_rpm",
    "speed_rpm",
    "current_sum_a",
    "current_reference_a",
    "advance_deg",
    "torque_nm",
    "load_torque_nm",
    "half_supply_v",
)
"""Columns of the trace that are kept."""
_DIGITS: Final = 5
_MOST_ROWS: Final = 60_000


@dataclass(frozen=True)
class RecordPlan:
    """A run to be recorded.

    Attributes
    ----------
    scenario : dict
        The scenario as plain data.
    checks : tuple of str
        Checks that look at it.
    """

    scenario: dict[str, Any]
    checks: tuple[str, ...]


@dataclass(frozen=True)
class Recorded:
    """A recorded run.

    Attributes
    ----------
    columns : dict
        Lists of equal length by the name of the column.
    windows : dict
        By check, start and end of the stretch that it was judged on (s).
    """

    columns: dict[str, list[float]]
    windows: dict[str, tuple[float, float]]


def shown_scenario(outcome: CheckOutcome) -> dict[str, Any] | None:
    """Choose the run that a report shows for a check."""
    scenario = outcome.scenario if outcome.counterexample is None else outcome.counterexample
    return None if scenario is None or scenario.get("kind") == "script" else scenario


def recording_plans(outcomes: Iterable[CheckOutcome]) -> list[RecordPlan]:
    """Plan which runs are recorded: each scenario once, whatever number of checks look at it."""
    plans: list[RecordPlan] = []
    for outcome in outcomes:
        scenario = shown_scenario(outcome)
        if scenario is None:
            continue
        place = next((place for place, plan in enumerate(plans) if plan.scenario == scenario), None)
        if place is None:
            plans.append(RecordPlan(scenario, (outcome.id,)))
        else:
            plans[place] = replace(plans[place], checks=(*plans[place].checks, outcome.id))
    return plans


def recording_job(plan: RecordPlan) -> Job[Recorded]:
    """Plan the work of a recording."""
    return Job(run_recorded, plan)


def run_recorded(loaded: JudgedCandidate, plan: RecordPlan) -> Recorded:
    """Run a scenario again and keep its signals; this is what the worker process does."""
    scenario = parse_document(plan.scenario, Scenario, "the recorded scenario")
    every = -(-scenario.control_periods // _MOST_ROWS)
    record = recorded(loaded, scenario, loaded.controller(), trace_every=every)
    windows = {}
    for check in kind_of(scenario.drive).checks():
        if check.id in plan.checks:
            windows[check.id] = judged_window(check, record, check.evaluate(record))
    return Recorded(thinned_run(record.run), windows)


def thinned_run(run: ClosedLoopRun | DutyClosedLoopRun) -> dict[str, list[float]]:
    """Take the means of a run's signals over equal stretches."""
    if not isinstance(run, DutyClosedLoopRun):
        return thinned(run.trace)
    return thinned_columns(duty_columns(run))


def duty_columns(run: DutyClosedLoopRun) -> dict[str, NDArray[Any]]:
    """Give the columns of a run with duty ratios in people's units, a row for each control period."""
    columns = {name: factor * run.column(source) for name, (source, factor) in DUTY_COLUMNS.items()}
    return {**columns, VOLTAGE: run.voltages}


def thinned(trace: NDArray[Any]) -> dict[str, list[float]]:
    """Take the means of a trace over equal stretches."""
    varying = (name for name in COLUMNS if name != "half_supply_v" or np.ptp(trace[name]) != 0.0)
    return thinned_columns({name: trace[name] for name in varying})


def thinned_columns(whole: Mapping[str, NDArray[Any]]) -> dict[str, list[float]]:
    """Take the means of columns over equal stretches."""
    rows = len(next(iter(whole.values())))
    length = max(-(-rows // MOST_POINTS), 1)
    begins = np.arange(0, rows, length)
    counts = np.diff(np.append(begins, rows))
    columns = {}
    for name, values in whole.items():
        means = np.add.reduceat(values, begins) / counts
        columns[name] = [significant(mean, _DIGITS) for mean in means]
    return columns


def with_recordings(
    outcomes: Iterable[CheckOutcome], plans: Iterable[RecordPlan], endings: Iterable[Recorded | Fault]
) -> tuple[tuple[CheckOutcome, ...], tuple[dict[str, list[float]], ...]]:
    """Put what was recorded into a result."""
    traces: list[dict[str, list[float]]] = []
    places: dict[str, Recording] = {}
    for _, ending in zip(plans, endings, strict=False):
        if isinstance(ending, Recorded):
            windows: Mapping[str, tuple[float, float]] = ending.windows
            places |= {check: Recording(len(traces), *window) for check, window in windows.items()}
            traces.append(ending.columns)
    return tuple(replace(outcome, recording=places.get(outcome.id)) for outcome in outcomes), tuple(traces)
