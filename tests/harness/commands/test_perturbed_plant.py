"""A plant that is off by 1e-8 is a broken harness, exit code 3, and nobody's verdict."""

from __future__ import annotations

import ctypes
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from drivegate.contracts.catalogue import contract_named, contract_of
from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.gate.plan import NOTHING_DECLARED
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.loop.closed_loop import PreparedLoop

PERTURBATION = 1e-8
_STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


def counterexample(kind: str) -> dict[str, Any]:
    """Return one of the kind's own runs, which is said to break the plant's balance."""
    drive = load_drive(DRIVE_KINDS[kind].default_drive)
    run = contract_of(drive).fixed_scenarios(drive, NOTHING_DECLARED)[1]
    return {
        "schema": 2,
        "kind": "counterexample",
        "check": "PWR-1",
        "candidate": {"name": contract_named(DRIVE_KINDS[kind].contract).usual_candidate},
        "scenario": run.to_mapping(),
    }


def perturbed(prepared: Any, run: Callable[[Any], Any]) -> Any:
    """Run a loop in which the currents grow by themselves, as if the plant's solution were a little wrong."""
    phases = prepared.arguments[1]
    currents = getattr(phases, "rotor_currents", phases.currents)
    place = next(place for place, given in enumerate(prepared.arguments) if hasattr(given, "step_address"))
    exchange = prepared.arguments[place]
    answer = _STEP(exchange.step_address)

    def step(state: int, sense: int, command: int) -> None:
        currents[:] *= 1.0 + PERTURBATION
        answer(state, sense, command)

    callback = _STEP(step)
    address = ctypes.cast(callback, ctypes.c_void_p).value
    arguments = list(prepared.arguments)
    arguments[place] = exchange._replace(step_address=address)
    return run(replace(prepared, arguments=tuple(arguments)))


@pytest.mark.parametrize("kind", DRIVE_KINDS)
def test_a_plant_that_is_perturbed_by_1e_8_ends_with_exit_code_3(
    command: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    file = tmp_path / "PWR-1.json"
    file.write_text(json.dumps(counterexample(kind)), encoding="utf-8")
    right = command("replay", file, "--json")
    assert (right.code, right.document["verdict"]) == (0, "fixed"), right.err
    own = PreparedLoop.run
    monkeypatch.setattr(PreparedLoop, "run", lambda prepared: perturbed(prepared, own))
    wrong = command("replay", file, "--json")
    assert (wrong.code, wrong.document["exit_code"]) == (3, 3), wrong.document
    assert wrong.document["now"]["margin"] < 0.0
