"""The comparison of two candidates step by step as plain data."""

from __future__ import annotations

import struct
from dataclasses import asdict
from math import degrees, isfinite
from typing import Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.studies.diff.diff import FIRST, Difference, StepComparison
from drivegate.studies.diff.jobs import BITWISE, Rule
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
    candidates: tuple[Candidate, Candidate], scenario: Scenario, rule: Rule, comparison: StepComparison
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
        "difference": None if found is None else _difference(found, rule),
        "fault": reported,
        "files": [],
    }


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
    judged = name in rule.judged
    one_bits, other_bits = (bits_of(number) for number in (first, second))
    return {
        "field": name,
        "unit": UNITS[name],
        "first": first,
        "second": second,
        "first_bits": f"{one_bits & 0xFFFF_FFFF_FFFF_FFFF:016x}",
        "second_bits": f"{other_bits & 0xFFFF_FFFF_FFFF_FFFF:016x}",
        "difference": second - first,
        "ulps": units_in_the_last_place(first, second),
        "differs": judged and bool(differs(first, second, one_bits, other_bits, rule.tolerance)),
    }


def bits_of(number: float) -> int:
    """Give the bits of a double."""
    return int.from_bytes(struct.pack("<d", number), "little", signed=True)


def in_words(field: dict[str, Any]) -> str:
    """Tell how far apart two numbers are."""
    first, second = field["first"], field["second"]
    if field["ulps"] is None:
        neither = not isfinite(first) and not isfinite(second)
        return "" if neither else "one of them makes none"
    if field["ulps"] == 0:
        return "" if field["first_bits"] == field["second_bits"] else "the sign of zero"
    return f"{field['difference']:+.3g} ({field['ulps']} ULP)"


def units_in_the_last_place(one: float, other: float) -> int | None:
    """Count the doubles from one number to another."""
    if not (isfinite(one) and isfinite(other)):
        return None
    return abs(_place(one) - _place(other))


def _place(number: float) -> int:
    """Give the place of a double on the line of all doubles, zero at zero."""
    bits = bits_of(number)
    return bits if bits >= 0 else -(bits & 0x7FFF_FFFF_FFFF_FFFF)
