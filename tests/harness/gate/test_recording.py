"""Recordings: few points that keep what a run did, each scenario once, in the result document."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.harness.made import made_outcome

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.contracts.current.columns import RECORDED
from drivegate.contracts.current.figures import recorded_signals
from drivegate.contracts.recorded_trace import MOST_POINTS, thinned
from drivegate.gate.recording import (
    RecordPlan,
    recording_plans,
    run_recorded,
    with_recordings,
)
from drivegate.results.document import CheckSection, RecordingSection
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.loop.observation import TRACE_RECORD


def outcome(check: str, scenario: dict[str, Any] | None, **changes: Any) -> CheckSection:
    return made_outcome(check, "pass", margin=0.5, scenario=scenario, **changes)


def test_means_over_equal_stretches_are_kept() -> None:
    trace = np.zeros(24_000, TRACE_RECORD)
    trace["time_s"] = np.arange(24_000) * 0.0005
    trace["speed_rpm"] = np.linspace(1000.0, 2000.0, 24_000)
    columns = thinned(recorded_signals(SimpleNamespace(trace=trace)))
    assert set(columns) == set(RECORDED) - {"half_supply_v"}, "a constant supply is not kept"
    assert {len(values) for values in columns.values()} == {MOST_POINTS}
    assert columns["speed_rpm"][0] == pytest.approx(1001.6, abs=0.1), "the mean of the first stretch"
    assert columns["time_s"][-1] == pytest.approx(11.97975)
    assert columns["speed_rpm"] == sorted(columns["speed_rpm"])


def test_a_short_trace_is_kept_as_it_is() -> None:
    trace = np.arange(3.0 * len(TRACE_RECORD)).view(TRACE_RECORD)
    columns = thinned(recorded_signals(SimpleNamespace(trace=trace)))
    assert columns["time_s"] == trace["time_s"].tolist()
    assert "half_supply_v" in columns, "a supply that changes is kept"


def test_checks_that_look_at_one_scenario_share_a_recording() -> None:
    first, other = (load_scenario(name).to_mapping() for name in ("lock-up", "fig5-search"))
    outcomes = (
        outcome("CNV-1", first, counterexample=other),
        outcome("CNV-2", first),
        outcome("CMD-1", other),
        outcome("TIM-1", None),
        outcome("FLO-1", {"kind": "script", "rows": []}),
    )
    plans = recording_plans(outcomes)
    assert [(plan.scenario["name"], plan.checks, plan.failed) for plan in plans] == [
        ("fig5-search", ("CNV-1", "CMD-1"), ("CNV-1",)),
        ("lock-up", ("CNV-2",), ()),
    ]


def test_a_run_is_recorded_with_the_stretch_that_was_judged() -> None:
    scenario = load_scenario("lock-up").to_mapping()
    plan = RecordPlan(scenario, ("CUR-1", "CNV-1"), ("CUR-1", "CNV-1"))
    with Judge(resolve_candidate("published")) as worker:
        ended = worker.run(Job(run_recorded, plan))
    assert not isinstance(ended, Fault)
    begin, finish = ended.windows["CUR-1"]
    assert finish - begin < 0.2, "the whole run is judged, and what is shown is its greatest current"
    start, end = ended.windows["CNV-1"]
    assert 6.0 < start < end == 20.0, "only what follows on the time to converge is judged"
    assert ended.columns["speed_rpm"][-1] == pytest.approx(1264.0, abs=1.0), "it locks up"
    outcomes, traces = with_recordings((outcome("CNV-1", scenario), outcome("PWR-1", scenario)), [ended])
    assert set(ended.closeups) == {"CNV-1", "CUR-1"}
    closeup = ended.closeups["CNV-1"]
    assert closeup["moment"]["start_s"] == start
    assert closeup["moment"]["column"] == "speed_rpm", "it loses the speed"
    assert closeup["columns"]["time_s"][0] == pytest.approx(start, abs=0.05)
    assert outcomes[0].recording == RecordingSection.model_construct(
        trace=0, start_s=start, end_s=end, closeup=closeup
    )
    assert outcomes[1].recording is None
    assert traces == (ended.columns,)


def test_a_fault_leaves_a_check_without_recording() -> None:
    scenario = load_scenario("lock-up").to_mapping()
    fault = Fault(FaultKind.EXCEPTION, "it raised", "step")
    outcomes, traces = with_recordings((outcome("CNV-1", scenario),), [fault])
    assert outcomes[0].recording is None
    assert traces == ()
