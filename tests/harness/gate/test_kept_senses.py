"""What the controller of a failing run saw is kept next to what was true, and shown."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import Record
from drivegate.containment.judge import Judge, own_candidate
from drivegate.containment.messages import Job
from drivegate.contracts.duty.scenarios.building import with_edges
from drivegate.contracts.recorded_trace import shown_signals
from drivegate.drives.running import recorded
from drivegate.gate.recording import Recorded, RecordPlan, run_recorded
from drivegate.studies.simulate import trace_frame
from drivegate_cases.scenario.scenario import Scenario, load_scenario

EXACT = load_scenario("pm-ac-speed-step").replaced(duration_s=0.3, speed_rpm=1000.0)
SENSED = EXACT.replaced(sensors={"kind": "shunts", "position": "encoder", "encoder_error_deg": 5.0}, seed=3)


def record(scenario: Scenario, candidate: str) -> Record:
    loaded = own_candidate(resolve_candidate(candidate))
    return recorded(loaded, scenario, loaded.controller(), trace_every=1, keeps_steps=True)


def test_senses_are_those_of_the_run_and_change_nothing() -> None:
    kept = record(SENSED, "foc")
    assert kept.steps is not None
    plain = recorded(loaded := own_candidate(resolve_candidate("foc")), SENSED, loaded.controller())
    assert plain.run.digest == kept.run.digest
    assert kept.steps["command"].tobytes() == kept.run.commands.tobytes(), "bit for bit"
    assert np.array_equal(kept.steps["sense"]["time"], kept.run.column("time"))


def test_sensed_angle_and_currents_stand_next_to_the_true_ones() -> None:
    columns = shown_signals(record(SENSED, "foc"))
    assert np.mean(columns["sensed_angle_error_deg"]) == pytest.approx(5.0, abs=0.5), (
        "the encoder is turned by 5°"
    )
    settled = slice(2000, None)
    true, sensed = (
        columns[name][settled] for name in ("quadrature_current_a", "sensed_quadrature_current_a")
    )
    assert np.mean(sensed) == pytest.approx(np.mean(true) * np.cos(np.radians(5.0)), abs=0.25)
    assert {len(values) for values in columns.values()} == {SENSED.control_periods}


def test_what_was_sensed_exactly_is_not_kept_twice() -> None:
    columns = shown_signals(record(EXACT, "foc"))
    assert not {"sensed_speed_rpm", "sensed_angle_error_deg", "sensed_link_voltage_v"} & set(columns)
    assert columns["sensed_direct_current_a"][1:] == pytest.approx(columns["direct_current_a"][:-1], abs=1e-9)


def test_a_trace_has_the_phases_too() -> None:
    kept = record(SENSED, "foc")
    frame = trace_frame(SENSED, kept.run, kept.steps)
    assert {"sensed_phase_1_a", "sensed_phase_3_a", "sensed_shaft_angle_deg", "sensed_speed_rpm"} <= set(
        frame
    )
    currents = load_scenario("fig5-search").replaced(duration_s=0.5, sensors={"kind": "mcs96"})
    kept = record(currents, "reference")
    frame = trace_frame(currents, kept.run, kept.steps)
    assert {"sensed_speed_rpm", "sensed_current_sum_a", "sensed_phase_5_a"} <= set(frame)
    assert np.array_equal(frame["sensed_speed_rpm"], frame["measured_speed_rpm"])


@pytest.mark.parametrize("failed", [(), ("ACC-1",)])
def test_a_result_has_them_of_failing_runs_alone_whoever_ran(failed: tuple[str, ...]) -> None:
    plan = RecordPlan(SENSED.to_mapping(), ("ACC-1",), failed)
    own = run_recorded(own_candidate(resolve_candidate("foc")), plan)
    assert ("sensed_quadrature_current_a" in own.columns) is bool(failed)
    assert {len(values) for values in own.columns.values()} == {300}, "few points, whatever the length"


def test_a_candidate_in_its_own_process_and_with_its_bridge_off_at_first_saw_the_same(tmp_path: Any) -> None:
    """Steps before the run, at rest and with turning shaft, are none of those that are kept."""
    turning = with_edges(EXACT, "hall", 1).replaced(turns_before=3)
    (tmp_path / "candidate.toml").write_text(
        'schema = 1\nname = "idle"\nkind = "python"\nentry = "idle.py:Idle"\ncontract = "duty"\n'
        "reads_enable = true\ncalibration_time_s = 0.01\n"
    )
    (tmp_path / "idle.py").write_text(
        "from drivegate import DutyCommand\n\n\n"
        "class Idle:\n"
        "    def reset(self, nameplate):\n        pass\n\n"
        "    def step(self, sense):\n        return DutyCommand((0.5, 0.5, 0.5))\n"
    )
    with Judge(resolve_candidate(str(tmp_path / "candidate.toml"))) as judge:
        ended = judge.run(Job(run_recorded, RecordPlan(turning.to_mapping(), ("ACC-1",), ("ACC-1",))))
    assert isinstance(ended, Recorded), ended
    times = np.array(ended.columns["time_s"])
    assert times[0] < 0.01
    assert len(ended.columns["sensed_direct_current_a"]) == len(times)
    assert max(map(abs, ended.columns["sensed_angle_error_deg"])) < 61.0, (
        "within a sector of the Hall switches"
    )
