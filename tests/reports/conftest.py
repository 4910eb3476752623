"""What the tests of the reports share: result documents of a candidate that passes and of one that fails."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import pytest

from drivegate.builtin_loading import BuiltinController
from drivegate.recording import thinned
from drivegate.scenario_run import run_scenario
from drivegate_cases.scenario import load_scenario
from drivegate_models.builtin_controllers import SEARCHES
from drivegate_reports.conformance import page

Document = dict[str, Any]


def _check(identifier: str, **changes: Any) -> Document:
    scenario = load_scenario("fig5-search").to_mapping()
    check = {
        "id": identifier,
        "requirement": f"The requirement of {identifier}.",
        "source": "P6",
        "subject": "candidate",
        "level": "required",
        "limit": "k1 = 5 rpm",
        "verdict": "pass",
        "margin": 0.4,
        "measured": "speed error 3 rpm",
        "runs": 12,
        "message": "speed error 3 rpm; met in all 12 runs",
        "scenario": scenario,
        "counterexample": scenario if changes.get("verdict") == "fail" else None,
    }
    return check | changes


def _document(**changes: Any) -> Document:
    document = {
        "schema": 1,
        "kind": "check",
        "candidate": {
            "name": "golden section",
            "kind": "python",
            "specification": "golden.py:Golden Section",
            "hash": "0123abcd",
            "declaration": {"profile": "outcome", "estimates_power": True},
        },
        "verdict": "pass",
        "exit_code": 0,
        "seed": 7,
        "effort": "default",
        "checks": [
            _check("PWR-1", subject="plant", source="P4"),
            _check("ADV-1", margin=1.0, source="P5"),
            _check("CNV-1"),
            _check("FLO-1", verdict="not applicable", margin=None, measured="", runs=0, scenario=None),
        ],
        "faults": [],
        "runs": 131,
        "set_aside": 4,
        "provenance": {"drivegate": "0.1.0", "packages": {"numpy": "2.0"}, "content_hash": "feed"},
        "timing": {"started_utc": "2030-01-01T00:00:00+00:00", "seconds": 12.5, "workers": 2},
    }
    return document | changes


@pytest.fixture
def make_document() -> Callable[..., Document]:
    """Return the factory of result documents; keywords replace keys."""
    return _document


@pytest.fixture
def make_check() -> Callable[..., Document]:
    """Return the factory of outcomes of a check; keywords replace keys."""
    return _check


@pytest.fixture(scope="session")
def passing() -> Document:
    """Return the result of a candidate that passes."""
    return _document()


@pytest.fixture(scope="session")
def failing() -> Document:
    """Return the result of a candidate that fails two checks, one of them advisory, and has a fault."""
    failed = {
        "verdict": "fail",
        "margin": -3.2,
        "measured": "speed error 21 rpm",
        "message": "lost at 1500 rpm",
    }
    fault = {
        "kind": "exception",
        "message": "ZeroDivisionError: division by zero",
        "phase": "step",
        "error": "ZeroDivisionError",
        "traceback": "line 12, in step\n    angle = 1 / 0\n",
        "step": 2400,
        "time_s": 1.2,
        "sense": {"speed": 157.0, "phase_currents": [1.0, -1.0]},
    }
    checks = [_check("CNV-1", **failed), _check("CUR-1", **failed, level="advisory"), _check("ADV-1")]
    return _document(verdict="exception", exit_code=1, checks=checks, faults=[fault])


@pytest.fixture(scope="session")
def lock_up() -> dict[str, list[float]]:
    """Return the signals of the controller `published` in the scenario in which it locks up."""
    run = run_scenario(load_scenario("lock-up"), BuiltinController(SEARCHES["published"]), trace_every=1)
    return thinned(run.trace)


@pytest.fixture(scope="session")
def recorded(lock_up: dict[str, list[float]]) -> Document:
    """Return a result of schema 2 with margins and recordings: one check fails, another is met in the same run."""
    scenario = load_scenario("lock-up").to_mapping()
    recording = {"trace": 0, "start_s": 6.2, "end_s": scenario["duration_s"]}
    shared = {"scenario": scenario, "recording": recording, "waiver": None}
    failed = _check(
        "CNV-1",
        **shared,
        verdict="fail",
        margin=-46.3,
        measured="speed error 236 rpm",
        message="speed error 236 rpm; fails in 2 of 4 runs",
        margins=[-46.3, -3.0, 0.1, 0.9],
        found={"margin": -46.3, "measured": "speed error 236 rpm", "size": 3, "runs": 11},
    )
    failed["counterexample"] = scenario
    met = _check("CMD-1", **shared, margin=0.0, margins=[0.0, 0.0, 1.0], found=None)
    waiver = {"reason": "a known weakness", "owner": "drives", "expires": "2030-01-01", "margin": -60.0}
    waived = _check("CNV-3", verdict="waived", margin=-2.0, margins=[-2.0], found=None, waiver=waiver)
    return _document(
        schema=2,
        verdict="fail",
        exit_code=1,
        checks=[failed, met, waived],
        traces=[lock_up],
        corpus_runs=0,
        fixed=[],
        baseline=None,
    )


@pytest.fixture(scope="session")
def recorded_page(recorded: Document) -> str:
    """Return the page of the result with recordings."""
    return page(recorded)


@pytest.fixture(scope="session")
def passing_page(passing: Document) -> str:
    """Return the page of the candidate that passes."""
    return page(passing)


@pytest.fixture(scope="session")
def failing_page(failing: Document) -> str:
    """Return the page of the candidate that fails."""
    return page(copy.deepcopy(failing))
