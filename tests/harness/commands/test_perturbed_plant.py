"""A plant that is off by 1e-8, or whose friction drives, is a broken harness, exit code 3, and nobody's verdict."""

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
from drivegate_models.loop.schedule import Conditions
from drivegate_models.machine import shaft_ledger

PERTURBATION = 1e-8
_STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


Perturbation = Callable[[Any, Any], None]


def grown_currents(arguments: Any, _records: Any) -> None:
    """Let the currents grow by themselves, as if the plant's solution were a little wrong."""
    phases = arguments[1]
    getattr(phases, "rotor_currents", phases.currents)[:] *= 1.0 + PERTURBATION


def lost_kinetic_energy(_arguments: Any, records: Any) -> None:
    """Leave the shaft more kinetic energy than its ledger has of the period before."""
    records.shaft[shaft_ledger.KINETIC] *= 1.0 - PERTURBATION


def driving_friction(arguments: Any, _records: Any) -> None:
    """Let a friction drive the shaft; its work is counted, but has the wrong sign."""
    schedule = next(given for given in arguments if isinstance(given, Conditions))
    schedule.friction.values[:] = -1e-3


PERTURBED = [grown_currents, lost_kinetic_energy, driving_friction]


def counterexample(kind: str) -> dict[str, Any]:
    """Return one of the kind's own runs with a free shaft, which is said to break the plant's balance."""
    drive = load_drive(DRIVE_KINDS[kind].default_drive)
    runs = contract_of(drive).fixed_scenarios(drive, NOTHING_DECLARED)[1:]
    run = next(run for run in runs if run.load.kind == "constant_torque")
    return {
        "schema": 2,
        "kind": "counterexample",
        "check": "PWR-1",
        "candidate": {"name": contract_named(DRIVE_KINDS[kind].contract).usual_candidate},
        "scenario": run.to_mapping(),
    }


def perturbed(prepared: Any, run: Callable[[Any], Any], perturbation: Perturbation) -> Any:
    """Run a loop whose plant is perturbed in every control period."""
    place = next(place for place, given in enumerate(prepared.arguments) if hasattr(given, "step_address"))
    exchange = prepared.arguments[place]
    answer = _STEP(exchange.step_address)

    def step(state: int, sense: int, command: int) -> None:
        perturbation(prepared.arguments, prepared.records)
        answer(state, sense, command)

    callback = _STEP(step)
    address = ctypes.cast(callback, ctypes.c_void_p).value
    arguments = list(prepared.arguments)
    arguments[place] = exchange._replace(step_address=address)
    return run(replace(prepared, arguments=tuple(arguments)))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("perturbation", PERTURBED)
@pytest.mark.parametrize("kind", DRIVE_KINDS)
def test_a_plant_that_is_perturbed_ends_with_exit_code_3(
    command: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, perturbation: Perturbation
) -> None:
    file = tmp_path / "PWR-1.json"
    file.write_text(json.dumps(counterexample(kind)), encoding="utf-8")
    right = command("replay", file, "--json")
    assert (right.code, right.document["verdict"]) == (0, "fixed"), right.err
    own = PreparedLoop.run
    monkeypatch.setattr(PreparedLoop, "run", lambda prepared: perturbed(prepared, own, perturbation))
    wrong = command("replay", file, "--json")
    assert (wrong.code, wrong.document["exit_code"]) == (3, 3), wrong.document
    assert wrong.document["now"]["margin"] < 0.0
