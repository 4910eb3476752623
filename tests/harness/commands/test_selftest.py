"""The command that checks the checks."""

from dataclasses import replace
from types import MappingProxyType

import pytest

from drivegate.candidates.builtin.faults import catalogue
from drivegate.candidates.builtin.faults.catalogue import MUTATIONS


def test_a_fault_is_caught_by_its_check(command) -> None:
    ended = command("selftest", "--effort", "quick", "--fault", "advance-below-base", "--json")
    assert ended.code == 0, ended.out
    document = ended.document
    assert (document["schema"], document["kind"], document["passed"]) == (1, "selftest", True)
    (fault,) = document["faults"]
    assert (fault["name"], fault["named_check"], fault["caught"]) == ("advance-below-base", "ADV-1", True)
    assert fault["runs_to_first"] >= 1
    assert document["designs"] == [], "a chosen fault needs no correct designs"
    assert "faulty controllers: 1 of 1, advance-below-base: caught by ADV-1" in ended.err


def test_several_faults_are_shown_in_a_matrix(command) -> None:
    ended = command(
        "selftest", "--effort", "quick", "--workers", "2", "--fault", "drifts", "--fault", "faulty:slow-step"
    )
    assert ended.code == 0, ended.out
    assert "2 of 2 faults caught" in ended.out
    rows = {line.split()[0]: line for line in ended.out.splitlines() if "●" in line}
    assert {"drifts", "slow-step"} <= set(rows), ended.out


def test_a_fault_that_its_check_misses_ends_with_1(command, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = replace(MUTATIONS["flowchart-inverted"], check="TIM-1")
    monkeypatch.setattr(catalogue, "MUTATIONS", MappingProxyType({**MUTATIONS, wrong.name: wrong}))
    ended = command("selftest", "--effort", "quick", "--fault", wrong.name)
    assert ended.code == 1
    assert "TIM-1 misses the fault 'flowchart-inverted' with seed 0" in ended.out
    assert "0 of 1 faults caught" in ended.out


def test_an_unknown_fault_is_refused_with_the_nearest(refused) -> None:
    message = refused("selftest", "--fault", "drift")
    assert "'drift' is unknown, the nearest known one is 'drifts'" in message
