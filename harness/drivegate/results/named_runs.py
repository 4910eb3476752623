"""The runs of a kept result by their names: fixed scenarios, the worst of each check, and counterexamples."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drivegate_cases.documents.document import parse_document
from drivegate_cases.documents.wording import nearest, one_line
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError


def scenario_named(result: Mapping[str, Any], name: str, where: str) -> Scenario:
    """Find a run by its name, or by its check: then the counterexample, or the worst run where there is none."""
    runs = _runs(result)
    if name not in runs:
        raise InputError(
            f"{where} keeps no run '{one_line(name)}', the nearest is '{nearest(name, runs)}'; it keeps the fixed "
            "scenarios, and of each check the worst run and the counterexample, also under the check's name"
        )
    if runs[name].get("kind") == "script":
        raise InputError(
            f"the run '{one_line(name)}' is a script, which no plant runs; replay its counterexample"
        )
    return parse_document(runs[name], Scenario, f"{where}, the run '{one_line(name)}'")


def _runs(result: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """Return every run under its name; where two have one name, the fixed scenario wins, then the worst run."""
    runs: dict[str, Mapping[str, Any]] = {run["name"]: run["scenario"] for run in result["fixed"]}
    for check in result["checks"]:
        kept = [scenario for scenario in (check["scenario"], check["counterexample"]) if scenario is not None]
        for scenario in kept:
            runs.setdefault(str(scenario["name"]), scenario)
        if kept:
            runs[check["id"]] = kept[-1]
    return runs
