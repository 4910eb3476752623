"""What happened in a run, in the words of its contract."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.recorded_trace import recorded_trace, trace_of_run
from drivegate_cases.scenario.scenario import Scenario


def account_of(document: Mapping[str, Any], check: Mapping[str, Any]) -> tuple[str, ...]:
    """Describe the run that a result shows for a check; nothing where its signals were not recorded."""
    trace = recorded_trace(document, check)
    return () if trace is None else contract_of(trace.scenario.drive).account(trace)


def account_of_run(scenario: Scenario, run: Any, judged_s: tuple[float, float]) -> tuple[str, ...]:
    """Describe a finished run."""
    trace = trace_of_run(scenario, run, judged_s)
    return () if trace is None else contract_of(scenario.drive).account(trace)
