"""The comparison of two candidates step by step as plain data."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, Final

from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.contract import Contract
from drivegate.studies.diff.diff import FIRST, Difference, StepComparison
from drivegate.studies.diff.field import number_field, whole_field
from drivegate.studies.diff.rule import BITWISE, Rule, differing
from drivegate_cases.scenario.scenario import Scenario

SCHEMA: Final = 1
EQUAL: Final = "equal"
DIFFERENT: Final = "different"


def document_of(
    candidates: tuple[Candidate, Candidate], scenario: Scenario, rule: Rule, comparison: StepComparison
) -> dict[str, Any]:
    """Write a comparison as plain data."""
    contract = contract_of(scenario.drive)
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
    sense: dict[str, Any] = contract.layout().sensed(row["sense"], row["currents"])._asdict()
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
    differs = name not in rule.ignored and bool(differing(one, other, rule.tolerance)[0])
    write = number_field if one.dtype.kind == "f" else whole_field
    return write(name, unit, one[0].item(), other[0].item(), differs=differs)
