"""Runs that are drawn on the same panels one after the other: each as if the panels were its own."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from drivegate_reports.conformance.figures.run_panels import new_run_panels, reused_run_panels
from drivegate_reports.conformance.runs import shown_runs
from drivegate_reports.page.style import house_style


def with_another_run(document: Any) -> Any:
    """Add a check whose run has other signals: greater ones, over a range of their own."""
    changed = copy.deepcopy(document)
    check = copy.deepcopy(next(check for check in changed["checks"] if check.get("recording")))
    trace = changed["traces"][check["recording"]["trace"]]
    other = {name: [3.7 * value + 11.0 for value in values] for name, values in trace.items()}
    changed["traces"].append(other | {"time_s": trace["time_s"]})
    check["id"], check["recording"]["trace"] = "NEW-1", len(changed["traces"]) - 1
    changed["checks"].append(check)
    return changed


@pytest.mark.nightly
def test_a_run_on_panels_that_were_drawn_on_before_has_the_same_bytes(
    recorded: Any, duty_result: Any
) -> None:
    for document in map(with_another_run, (recorded, duty_result)):
        on_its_own = shown_runs.__wrapped__(document)  # type: ignore[attr-defined]
        assert len({run.figure.name for run in on_its_own.values()}) > 1
        assert shown_runs(document) == on_its_own


def test_panels_are_reused_only_where_each_figure_is_written_before_the_next() -> None:
    with house_style():
        assert new_run_panels()[0] is not new_run_panels()[0]
        with reused_run_panels():
            reused = new_run_panels()[0]
            assert new_run_panels()[0] is reused
        assert new_run_panels()[0] is not reused
