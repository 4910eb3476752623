"""Finished runs made by hand, so that a test can put what was observed exactly on either side of a limit."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.run import observed_windows
from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.profile import dwell_torque, dwells
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.current.records import COMMAND, SENSE
from drivegate_models.loop import closed_loop, observation
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.machine import ledger, shaft_ledger

MakeRecord = Callable[..., CurrentRecord]
AssertLimit = Callable[[str, CurrentRecord, CurrentRecord], None]

SCENARIO: dict[str, Any] = {
    "schema": 2,
    "name": "by-hand",
    "drive": "paper-5-phase",
    "duration_s": 10.0,
    "speed_rpm": [[0.0, 1500.0]],
    "load": {"kind": "constant_torque", "torque_nm": 9.8, "factor": [[0.0, 1.0]]},
}
DIGEST = 1234567


def scenario_with(**changes: Any) -> Scenario:
    return parse_document({**SCENARIO, **changes}, Scenario, "a scenario of the tests")


def record_with(
    scenario: Scenario | None = None,
    *,
    run: Mapping[str, float] | None = None,
    totals: Mapping[str, float] | None = None,
    window: Mapping[str, Any] | None = None,
    windows: list[Mapping[str, Any]] | None = None,
    declaration: Declaration | None = None,
    repeated: tuple[int, ...] = (),
) -> CurrentRecord:
    """A run of which nothing is known but what is given; by default it has converged on its references."""
    scenario = scenario or scenario_with()
    observed = observed_windows(scenario)
    finished_windows = []
    by_end = {dwell.end: dwell for dwell in dwells(scenario)}
    for index, (_, end) in enumerate(observed):
        dwell = by_end[end]
        values = {
            "CURRENT_SUM": 40.0,
            "MEANS": [(40.0, 0.0, 0.92)],
            "TORQUE": dwell_torque(scenario, dwell),
            "SPEED": dwell.speed_rpm * math.pi / 30.0,
            "ANGLE": 0.92,
            "ANGLE_LOWEST": 0.92,
            "ANGLE_HIGHEST": 0.92,
            **(window or {}),
            **(windows[index] if windows else {}),
        }
        fields = dict.fromkeys(observation.WindowObservation._fields, 0.0)
        fields |= {name.lower(): value for name, value in values.items()}
        fields["means"] = np.array(values["MEANS"])
        finished_windows.append(observation.WindowObservation(**fields))
    observations = np.zeros(1, observation.RUN_RECORD)
    for name, value in (run or {}).items():
        observations[0][name.lower()] = value
    integrals = np.zeros(ledger.ENTRIES)
    for name, value in (totals or {}).items():
        integrals[getattr(ledger, name)] = value
    finished = closed_loop.ClosedLoopRun(
        status=COMPLETED,
        digest=DIGEST,
        totals=integrals,
        shaft=np.zeros(shaft_ledger.ENTRIES),
        observed=observation.observed_run(observations),
        windows=tuple(finished_windows),
        trace=np.zeros(0, observation.TRACE_RECORD),
        last_sense=np.zeros(1, SENSE),
        last_currents=np.zeros(5),
        last_command=np.zeros(1, COMMAND),
    )
    return CurrentRecord(scenario, finished, declaration or Declaration(estimates_power=True), repeated)


@pytest.fixture
def scenario() -> Callable[..., Scenario]:
    """Change keys of a steady run at 1500 rpm and 9.8 N·m."""
    return scenario_with


@pytest.fixture
def record() -> MakeRecord:
    """Make a finished run from what was observed in it."""
    return record_with


@pytest.fixture
def checks() -> Mapping[str, Check]:
    """All checks by their identifiers."""
    return {check.id: check for check in CHECKS}


@pytest.fixture
def assert_limit(checks: Mapping[str, Check]) -> AssertLimit:
    """Assert that a check is met by one run and missed by another."""

    def assert_limit(identifier: str, passing: CurrentRecord, failing: CurrentRecord) -> None:
        __tracebackhide__ = True
        met, missed = (checks[identifier].evaluate(record) for record in (passing, failing))
        assert met is not None, f"{identifier} does not apply to the passing run"
        assert missed is not None, f"{identifier} does not apply to the failing run"
        assert met.met, f"{identifier} fails on its limit: {met.value} ({met.measured})"
        assert not missed.met, f"{identifier} passes beyond its limit: {missed.value} ({missed.measured})"
        assert missed.check == met.check == identifier

    return assert_limit
