"""The figure of a failing run shows the value that its check states, whatever the check."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import pytest
from tests.harness.conftest import AlteredController
from tests.harness.contracts.reading import is_read, read_off

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import Check, Record
from drivegate.containment.judge import own_candidate
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.catalogue import contract_named
from drivegate.drives.running import recorded
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario

CHECKS = {check.id: check for check in contract_named("current").checks}
STEADY_MEANS = ("CNV-2",)
NO_SIGNAL = ("PWR-1", "NEU-1", "DET-1", "TIM-1", "FLO-1")
"""Checks of the plant, of repetitions, of time and of scripts, which no signal of a run shows."""
# Limits that every controller misses.
TIGHT = {
    "speed_tolerance_rpm": 0.005,
    "angle_tolerance_deg": 2e-4,
    "power_tolerance_percent": 1e-3,
    "ripple_percent": 1.0,
    "closed_loop_ripple_percent": 1.0,
    "current_limit_a": 12.0,
}
RATED = {"kind": "constant_power", "power_w": 1500.0, "factor": [[0.0, 1.0]]}
HEAVIER = {"kind": "constant_torque", "torque_nm": 9.8, "factor": {"steps": [[0.0, 0.6], [9.5, 1.0]]}}


@cache
def _drive(tight: tuple[str, ...]) -> dict[str, Any]:
    mapping = load_drive("paper-5-phase").to_mapping()
    for key in tight:
        table = "rating" if key == "current_limit_a" else "requirements"
        mapping[table] = {**mapping[table], key: TIGHT[key]}
    return mapping


def _scenario(*tight: str, **changes: Any) -> Scenario:
    keys = {"schema": 2, "name": "shown", "duration_s": 9.5, "speed_rpm": [[0.0, 1500.0]]}
    load = {"kind": "constant_torque", "torque_nm": 9.8, "factor": [[0.0, 1.0]]}
    given = {**keys, "drive": _drive(tight), "load": load, **changes}
    return parse_document(given, Scenario, "a scenario of the tests")


def _run(scenario: Scenario, alter: Callable[[Any, Any], None] | None = None) -> Record:
    loaded = own_candidate(resolve_candidate("reference"))
    if alter is not None:
        loaded = JudgedCandidate(loaded.candidate, lambda: AlteredController("reference", alter))
    return recorded(loaded, scenario, loaded.controller(), trace_every=1, keeps_steps=True)


def _field(name: str, change: Callable[[float], float]) -> Callable[[Any, Any], None]:
    def alter(sense: Any, command: Any) -> None:
        if sense["time"] > 0.2:
            command[name] = change(command[name])

    return alter


SHORT = {"duration_s": 0.4}
FAILING: list[tuple[str, str, dict[str, Any], Callable[[Any, Any], None] | None]] = [
    ("CNV-1", "speed_tolerance_rpm", {}, None),
    ("CNV-1", "angle_tolerance_deg", {}, None),
    ("CNV-3", "power_tolerance_percent", {"load": HEAVIER, "duration_s": 19.0}, None),
    ("ROB-1", "angle_tolerance_deg", {"scales": {"resistance": 1.5}}, None),
    ("ROB-2", "angle_tolerance_deg", {"sensors": "mcs96"}, None),
    (
        "ROB-3",
        "speed_tolerance_rpm",
        {"dropouts": [{"signal": "speed", "start_s": 1.0, "duration_s": 0.001}], "duration_s": 11.0},
        None,
    ),
    ("CPW-1", "speed_tolerance_rpm", {"load": RATED}, None),
    ("CPW-2", "speed_tolerance_rpm", {"load": RATED, "speed_rpm": 1900.0}, None),
    ("RIP-1", "ripple_percent", {}, None),
    ("RIP-2", "ripple_percent", {"load": RATED}, None),
    ("RIP-3", "closed_loop_ripple_percent", {"load": RATED}, None),
    ("TRQ-1", "", {}, None),
    ("CUR-1", "current_limit_a", {**SHORT, "speed_rpm": 3000.0, "supply_v": 10.0}, None),
    (
        "ADV-1",
        "",
        {**SHORT, "initial_speed_rpm": 0.0, "speed_rpm": 300.0},
        _field("advance_angle", lambda _: math.radians(7.0)),
    ),
    ("ADV-2", "", SHORT, _field("advance_angle", lambda _: math.radians(-7.0))),
    ("CMD-1", "", SHORT, _field("current_reference", lambda _: 31.0)),
    ("PWR-2", "", SHORT, _field("input_power", lambda value: 1.5 * value)),
]


def _with_negative_torque(record: Any) -> Record:
    """Make the record of a run in whose last second the torque was once negative, as no included controller has it."""
    trace, (window,) = record.run.trace.copy(), record.run.windows
    trace["torque_lowest_nm"][-300] = -0.75
    changed = replace(record.run, trace=trace, windows=(window._replace(torque_lowest=-0.75),))
    return replace(record, run=changed)


def test_every_check_but_those_of_steady_means_is_shown_failing() -> None:
    assert {check for check, *_ in FAILING} == set(CHECKS) - {*STEADY_MEANS, *NO_SIGNAL}


@pytest.mark.parametrize(("check", "tight", "changes", "alter"), FAILING)
def test_the_stated_value_can_be_read_off_the_moment_that_is_drawn(
    check: str, tight: str, changes: dict[str, Any], alter: Callable[[Any, Any], None] | None
) -> None:
    known: Check = CHECKS[check]
    record = _run(_scenario(*filter(None, [tight]), **changes), alter)
    if check == "TRQ-1":
        record = _with_negative_torque(record)
    measured, numbers = read_off(known, record)
    assert is_read(measured, numbers), f"{measured!r} is not among {numbers}"
