"""A check of a faulty controller from Python: its verdicts, its counterexample and its traces."""

from __future__ import annotations

import numpy as np
import pandas
import pytest

import drivegate


@pytest.fixture(scope="module")
def checked() -> drivegate.CheckResult:
    """A faulty controller, judged by one check that it fails."""
    return drivegate.check(
        "faulty:stuck-weakening",
        drive="pm-ac-interior",
        effort="quick",
        workers=1,
        only=["FWK-2"],
        stop_at_first=True,
    )


def test_a_check_returns_verdicts_traces_and_counterexamples(checked: drivegate.CheckResult) -> None:
    assert (checked.verdict, checked.passed, checked.failed) == ("fail", False, ("FWK-2",))
    assert checked.folder is None
    row = checked.checks.loc["FWK-2"]
    assert row["verdict"] == "fail"
    assert row["margin"] < 0.0
    trace = checked.trace("FWK-2")
    assert isinstance(trace, pandas.DataFrame)
    assert trace["time_s"].is_monotonic_increasing
    assert checked.counterexample("FWK-2").check == "FWK-2"
    with pytest.raises(drivegate.InputError, match="there is no counterexample of 'STP-1'; there are FWK-2"):
        checked.counterexample("STP-1")
    with pytest.raises(drivegate.InputError, match="the nearest is 'FWK-2'"):
        checked.trace("FWK-9")


def test_its_counterexample_is_replayed_and_simulated(checked: drivegate.CheckResult) -> None:
    stored = checked.counterexample("FWK-2")
    again = drivegate.replay(stored)
    assert again.verdict == "still fails"
    assert again.margin == stored.margin
    assert drivegate.replay(stored, "foc").verdict == "fixed"
    run = drivegate.simulate("faulty:stuck-weakening", stored.scenario)
    assert run.fault is None
    assert np.array_equal(run.trace["direct_current_a"], again.trace["direct_current_a"])
    assert len(run.windows) > 0
    assert run.summary
