"""One run of a candidate, and its summary in people's units."""

from __future__ import annotations

from dataclasses import asdict
from math import degrees
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.current.scenarios.windows import observed_windows
from drivegate.contracts.duty.run import DutyClosedLoopRun
from drivegate.drives.running import recorded, run_scenario
from drivegate.gate.recording import duty_columns
from drivegate.output.compiled_kernels import with_compiled_kernels
from drivegate.output.pace import tell_slow
from drivegate.studies.simulate.clamping import clamped_in_words
from drivegate.studies.simulate.duty_summary import clipped_in_words, duty_summary, duty_window_rows
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.machine import ledger
from drivegate_models.units import RPM

if TYPE_CHECKING:
    import pandas

SCHEMA: Final = 1
MOST_ROWS: Final = 1_000_000
"""Rows of a trace at most; of a longer run every n-th control period is kept."""


def simulated(candidate: Candidate, scenario: Scenario) -> ClosedLoopRun | DutyClosedLoopRun | Fault:
    """Run a candidate through a scenario."""
    with_compiled_kernels([scenario.drive])
    with Judge(candidate, on_slow=tell_slow) as judge:
        return judge.run(Job(run_once, scenario))


def run_once(loaded: JudgedCandidate, scenario: Scenario) -> ClosedLoopRun | DutyClosedLoopRun:
    """Run a scenario with a trace."""
    if scenario.drive.contract == "duty":
        return recorded(loaded, scenario, loaded.controller()).run
    every = -(-scenario.control_periods // MOST_ROWS)
    return run_scenario(scenario, loaded.controller(), trace_every=every)


def trace_frame(run: ClosedLoopRun | DutyClosedLoopRun) -> pandas.DataFrame:
    """Give a run's trace as a table."""
    import pandas

    if isinstance(run, DutyClosedLoopRun):
        return pandas.DataFrame(duty_columns(run))
    return pandas.DataFrame(run.trace)


def document_of(
    candidate: Candidate, scenario: Scenario, ended: ClosedLoopRun | DutyClosedLoopRun | Fault
) -> dict[str, Any]:
    """Summarise a run as plain data."""
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": "simulation",
        "candidate": {"name": candidate.name, "kind": candidate.kind, "hash": candidate.content_hash},
        "scenario": scenario.name,
        "drive": scenario.drive.identity(),
        "duration_s": scenario.duration_s,
        "control_period_s": scenario.control_period_s,
        "fault": None,
    }
    if isinstance(ended, Fault):
        return document | {"fault": asdict(ended) | {"kind": ended.kind.value}}
    if isinstance(ended, DutyClosedLoopRun):
        return document | {
            "summary": duty_summary(scenario, ended),
            "windows": duty_window_rows(scenario, ended, candidate.declaration),
            "clamped": clipped_in_words(ended),
        }
    return document | {
        "summary": _summary(scenario, ended),
        "windows": _windows(scenario, ended),
        "clamped": clamped_in_words(scenario, ended),
    }


def _summary(scenario: Scenario, run: ClosedLoopRun) -> dict[str, Any]:
    duration, columns = scenario.duration_s, run.trace
    errors = abs(columns["speed_rpm"] - columns["speed_reference_rpm"])
    worst = int(errors.argmax())
    return {
        "steps": run.steps,
        "speed_final_rpm": run.observed.speed_final * RPM,
        "speed_error_worst_rpm": float(errors[worst]),
        "speed_error_worst_at_s": float(columns["time_s"][worst]),
        "current_sum_mean_a": float(run.totals[ledger.MAGNITUDE]) / duration,
        "current_peak_a": float(run.totals[ledger.PEAK]),
        "torque_mean_nm": float(run.totals[ledger.IMPULSE]) / duration,
        "input_power_mean_w": run.observed.input_energy / duration,
        "shaft_power_mean_w": run.observed.shaft_energy / duration,
        "advance_mean_deg": float(columns["advance_deg"].mean()),
        "advance_final_deg": float(columns["advance_deg"][-1]),
        "current_reference_final_a": float(columns["current_reference_a"][-1]),
        "energy_residual": run.observed.exchange_error,
        "kinetic_residual_j": run.observed.kinetic_residual,
    }


def _windows(scenario: Scenario, run: ClosedLoopRun) -> list[dict[str, float]]:
    return [
        {
            "start_s": start,
            "end_s": end,
            "speed_mean_rpm": row.speed * RPM,
            "speed_error_worst_rpm": row.speed_error * RPM,
            "current_sum_mean_a": row.current_sum,
            "current_sum_spread_a": float(row.mean_highest - row.mean_lowest),
            "torque_mean_nm": row.torque,
            "input_power_mean_w": row.input_power,
            "exchanged_power_mean_w": row.exchanged_power,
            "advance_mean_deg": degrees(row.angle),
            "advance_spread_deg": degrees(row.angle_highest - row.angle_lowest),
            "current_reference_mean_a": row.reference,
            "current_peak_a": row.peak,
        }
        for (start, end), row in zip(observed_windows(scenario), run.windows, strict=True)
    ]
