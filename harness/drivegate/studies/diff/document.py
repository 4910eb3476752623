"""The comparison of two candidates step by step as plain data."""

from __future__ import annotations

import struct
from dataclasses import asdict
from math import isfinite
from typing import Any, Final

from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.contract import Contract
from drivegate.studies.diff.diff import BITWISE, FIRST, Difference, Rule, StepComparison, differing
from drivegate_cases.scenario.scenario import Scenario

SCHEMA: Final = 1
EQUAL: Final = "equal"
DIFFERENT: Final = "different"


def document_of(
    candidates: tuple[Candidate, Candidate], scenario: Scenario, rule: Rule, comparison: StepComparison
) -> dict[str, Any]:
    contract = contract_of(scenario.drive)
    found, fault = comparison.difference, comparison.fault
    verdict = EQUAL if found is None else DIFFERENT
    reported = None
    if fault is not None:
        verdict = fault.kind.value
        who = candidates[0 if comparison.faulted == FIRST else 1].name
        stated = {key: value for key, value in asdict(fault).items() if key != "scenario"}
        reported = {"candidate": who, "place": comparison.faulted} | stated | {"kind": fault.kind.value}
    return {
        "schema": SCHEMA,
        "kind": "diff",
        "verdict": verdict,
        "exit_code": 0 if verdict == EQUAL else 1,
        "candidates": [
            {
                "name": candidate.name,
                "kind": candidate.kind,
                "hash": candidate.content_hash,
                "step_costs": {name: cost for name, cost in costs._asdict().items() if cost},
            }
            for candidate, costs in zip(candidates, comparison.costs, strict=True)
        ],
        "scenario": scenario.name,
        "drive": scenario.drive.identity(),
        "control_period_s": scenario.control_period_s,
        "tolerance": None if rule.tolerance == BITWISE else rule.tolerance,
        "compared": list(rule.judged(contract.outputs)),
        "steps_planned": scenario.control_periods,
        "steps_equal": comparison.steps,
        "difference": None if found is None else _difference(found, contract, rule),
        "fault": reported,
        "files": [],
    }


def _difference(found: Difference, contract: Contract, rule: Rule) -> dict[str, Any]:
    here = found.step - found.begin
    steps = [_step(found, index, contract, rule) for index in range(len(found.answers))]
    sense = _sense(found, here, contract)
    return {
        "step": found.step,
        "time_s": sense["time"],
        "sense": sense,
        "plant": found.plant,
        "commands": steps[here]["commands"],
        "before": steps[:here],
        "after": steps[here + 1 :],
    }


def _sense(found: Difference, index: int, contract: Contract) -> dict[str, Any]:
    row = found.rows[index]
    sense: dict[str, Any] = contract.layout.sensed(row["sense"], row["currents"])._asdict()
    return sense


def _step(found: Difference, index: int, contract: Contract, rule: Rule) -> dict[str, Any]:
    commands, answers = found.rows["command"][index : index + 1], found.answers[index : index + 1]
    return {
        "step": found.begin + index,
        "sense": _sense(found, index, contract),
        "commands": [
            _field(name, unit, commands[name], answers[name], rule)
            for name, (_, unit) in contract.outputs.items()
        ],
    }


def _field(name: str, unit: str, one: NDArray[Any], other: NDArray[Any], rule: Rule) -> dict[str, Any]:
    """Write a field of both commands as plain data, a number to the last bit."""
    first, second = one[0].item(), other[0].item()
    bits: list[str | None] = [None, None]
    if one.dtype.kind == "f":
        bits = [f"{_bits_of(number) & 0xFFFF_FFFF_FFFF_FFFF:016x}" for number in (first, second)]
    return {
        "field": name,
        "unit": unit,
        "first": first,
        "second": second,
        "first_bits": bits[0],
        "second_bits": bits[1],
        "difference": second - first,
        "ulps": units_in_the_last_place(first, second) if one.dtype.kind == "f" else None,
        "differs": name not in rule.ignored and bool(differing(one, other, rule.tolerance)[0]),
    }


def _bits_of(number: float) -> int:
    return int.from_bytes(struct.pack("<d", number), "little", signed=True)


def in_words(field: dict[str, Any]) -> str:
    """Describe how far apart two numbers are."""
    first, second = field["first"], field["second"]
    if field["ulps"] is None and isinstance(first, int):
        return f"{field['difference']:+d}" if field["difference"] else ""
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
    """Return the place of a double on the line of all doubles, zero at zero."""
    bits = _bits_of(number)
    return bits if bits >= 0 else -(bits & 0x7FFF_FFFF_FFFF_FFFF)
