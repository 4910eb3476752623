"""The list of all runs as CSV."""

from __future__ import annotations

import csv
import io

from drivegate.checks.check import JudgedRun
from drivegate.checks.margin import Margin
from drivegate.gate.engine import _listed
from drivegate.output.run_list import runs_csv
from drivegate.results.provenance import hash_of_scenario
from drivegate_cases.scenario.scenario import load_scenario


def test_each_run_is_listed_with_seed_hash_and_margins() -> None:
    run = load_scenario("pm-ac-start").replaced(seed=7)
    margins = (
        Margin("ACC-1", 0.25, "x"),
        Margin("STP-1", -0.5, "x"),
        Margin("TIM-1", 0.1, "x", is_timed=True),
    )
    listed = [_listed(JudgedRun(run.to_mapping(), margins)), _listed(JudgedRun(run.to_mapping(), ()))]
    checks = [{"id": check} for check in ("ACC-1", "STP-1", "TIM-1", "DET-1")]
    rows = list(
        csv.DictReader(
            io.StringIO(runs_csv({"checks": checks, "run_list": [x.model_dump() for x in listed]}))
        )
    )
    assert list(rows[0]) == [
        "run",
        "scenario",
        "seed",
        "scenario_hash",
        "least_check",
        "least_margin",
        "ACC-1",
        "STP-1",
    ]
    first, second = rows
    assert (first["run"], first["scenario"], first["seed"]) == ("1", "pm-ac-start", "7")
    assert (first["least_check"], first["least_margin"], first["ACC-1"]) == ("STP-1", "-0.5", "0.25")
    assert (second["least_check"], second["ACC-1"]) == ("", "")
    assert first["scenario_hash"] == hash_of_scenario(run.to_mapping())
    assert first["scenario_hash"] != hash_of_scenario(run.replaced(seed=8).to_mapping())


def test_a_script_is_listed_too() -> None:
    script = JudgedRun({"kind": "script", "name": "hardly any change", "rows": []}, ())
    assert (_listed(script).name, _listed(script).seed) == ("hardly any change", 0)


def test_a_result_of_earlier_versions_has_an_empty_list() -> None:
    assert runs_csv({"checks": [{"id": "ACC-1"}]}).splitlines() == [
        "run,scenario,seed,scenario_hash,least_check,least_margin"
    ]
