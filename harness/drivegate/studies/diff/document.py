"""The comparison of two candidates step by step as plain data."""

from __future__ import annotations

from dataclasses import asdict
from math import degrees
from typing import Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.studies.diff.diff import Difference
from drivegate.studies.diff.duty.comparison import DutyDifference
from drivegate.studies.diff.duty.document import duty_difference
from drivegate.studies.diff.field import bits_of, number_field
from drivegate.studies.diff.jobs import BITWISE, Rule
from drivegate.studies.diff.outcome import FIRST, StepComparison
from drivegate.studies.diff.record import commands_of
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.exchange import OUTPUTS
from drivegate_models.loop.given_steps import SCALARS
from drivegate_models.loop.step_recording import differs
from drivegate_models.units import RPM

SCHEMA: Final = 1
EQUAL: Final = "equal"
DIFFERENT: Final = "different"

UNITS: Final = {"current_reference": "A", "advance_angle": "rad", "input_power": "W"}
"""Units of a command's fields."""


def document_of(
    candidates: tuple[Candidate, Candidate],
    scenario: Scenario,
    rule: Rule,
    comparison: StepComparison[Difference] | StepComparison[DutyDifference],
) -> dict[str, Any]:
    """Write a comparison as plain data."""
    found, fault = comparison.difference, comparison.fault
    verdict = EQUAL if found is None else DIFFERENT
    reported = None
    if fault is not None:
        verdict = fault.kind.value
        who = candidates[0 if comparison.faulted == FIRST else 1].name
        reported = (
            {"candidate": who, "place": comparison.faulted} | asdict(fault) | {"kind": fault.kind.value}
        )
    return {
        "schema": SCHEMA,
        "kind": "diff",
        "verdict": verdict,
        "exit_code": 0 if verdict == EQUAL else 1,
        "candidates": [
            {"name": candidate.name, "kind": candidate.kind, "hash": candidate.content_hash}
            for candidate in candidates
        ],
        "scenario": scenario.name,
        "drive": scenario.drive.identity(),
        "control_period_s": scenario.control_period_s,
        "tolerance": None if rule.tolerance == BITWISE else rule.tolerance,
        "compared": list(rule.judged),
        "steps_planned": scenario.control_periods,
        "steps_equal": comparison.steps,
        "difference": None if found is None else _told(found, rule),
        "fault": reported,
        "files": [],
    }


def _told(found: Difference | DutyDifference, rule: Rule) -> dict[str, Any]:
    return duty_difference(found, rule) if isinstance(found, DutyDifference) else _difference(found, rule)


def _difference(found: Difference, rule: Rule) -> dict[str, Any]:
    here = found.step - found.begin
    steps = [_step(found, index, rule) for index in range(len(found.answers))]
    plant = found.plant
    return {
        "step": found.step,
        "time_s": found.sense.time,
        "sense": found.sense._asdict(),
        "plant": {
            "speed": plant.speed,
            "speed_rpm": plant.speed * RPM,
            "electrical_angle_deg": degrees(plant.angle),
            "phase_currents": plant.phase_currents,
            "half_supply_voltage": plant.half_supply_voltage,
        },
        "commands": steps[here]["commands"] if here < len(steps) else [],
        "before": steps[:here],
        "after": steps[here + 1 :],
    }


def _step(found: Difference, index: int, rule: Rule) -> dict[str, Any]:
    row = found.rows[index].tolist()
    first, second = commands_of(found.rows[index : index + 1])[0], found.answers[index]
    return {
        "step": found.begin + index,
        "sense": dict(zip(SCALARS, row, strict=False))
        | {"phase_currents": row[len(SCALARS) + len(OUTPUTS) :]},
        "commands": [
            _field(name, float(one), float(other), rule)
            for name, one, other in zip(OUTPUTS, first, second, strict=True)
        ],
    }


def _field(name: str, first: float, second: float, rule: Rule) -> dict[str, Any]:
    one_bits, other_bits = (bits_of(number) for number in (first, second))
    found = name in rule.judged and bool(differs(first, second, one_bits, other_bits, rule.tolerance))
    return number_field(name, UNITS[name], first, second, differs=found)
