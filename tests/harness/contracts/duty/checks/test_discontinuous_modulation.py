"""RIP-4 judges discontinuous modulation by its own ideal where it is declared, and names the key where it is not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.harness.contracts.duty.checks.conftest import CHECKS, Run, judged

from drivegate.candidates.declaration import Declaration
from drivegate.contracts.contract import Witness
from drivegate.contracts.duty.informed import InformedController
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.run import DUTY_RATIOS
from drivegate.contracts.duty.scenarios.building import torque_of, torque_scenario
from drivegate.drives.running import recorded
from drivegate.gate.witness_runs import judged_witness
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.pm_ac.modulation_kind import ModulationKind
from drivegate_models.pm_ac.plant.drive import PmAcDrive

Levels = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def _at_peaks(ratios: NDArray[np.float64]) -> NDArray[np.float64]:
    """Clamp the leg whose voltage is the farthest from the neutral."""
    highest, lowest = np.max(ratios, axis=1), np.min(ratios, axis=1)
    is_upper = highest + lowest > 2.0 * np.mean(ratios, axis=1)
    return np.where(is_upper, 1.0 - highest, -lowest)


SHIFTS: dict[ModulationKind, Levels] = {
    "dpwm-min": lambda ratios: -np.min(ratios, axis=1),
    "dpwm-max": lambda ratios: 1.0 - np.max(ratios, axis=1),
    "dpwm-1": _at_peaks,
}
"""The zero sequence that each kind adds to duty ratios, shape (n, 3) to (n,)."""


@pytest.fixture(scope="session")
def steps(run: Run, interior: PmAcDocument) -> DutyRecord:
    speed = 0.6 * interior.rating.base_speed_rpm
    return run(
        torque_scenario(interior, speed, [torque_of(interior, speed, part) for part in (0.3, 0.6, 0.9)])
    )


def shifted(record: DutyRecord, kind: ModulationKind) -> DutyRecord:
    """Make the record of a run whose duty ratios had another zero sequence, which no current shows in the mean."""
    commands = record.run.commands.copy()
    ratios = np.stack([commands[name] for name in DUTY_RATIOS], axis=1)
    for leg, name in enumerate(DUTY_RATIOS):
        commands[name] = ratios[:, leg] + SHIFTS[kind](ratios)
    return replace(record, run=replace(record.run, commands=commands))


@pytest.mark.parametrize("kind", SHIFTS)
def test_each_kind_is_judged_by_its_own_ideal(kind: ModulationKind, steps: DutyRecord) -> None:
    clamped = shifted(steps, kind)
    undeclared = judged("RIP-4", clamped)
    declared = judged("RIP-4", replace(clamped, declaration=Declaration(modulation=kind)))
    assert undeclared is not None
    assert declared is not None
    assert not undeclared.met, undeclared.measured
    assert "a leg is clamped nearly always" in undeclared.measured
    assert "'modulation'" in undeclared.measured
    assert declared.met, declared.measured
    assert f"of ideal {kind} modulation" in declared.measured


def test_ripple_of_other_faults_names_no_modulation(steps: DutyRecord) -> None:
    commands = steps.run.commands.copy()
    commands["first_duty"] += 0.02 * np.where(np.arange(len(commands)) % 4 < 2, 1.0, -1.0)
    margin = judged("RIP-4", replace(steps, run=replace(steps.run, commands=commands)))
    assert margin is not None
    assert not margin.met
    assert "clamped" not in margin.measured


def test_a_faulty_controller_does_not_pass_by_a_declaration(steps: DutyRecord) -> None:
    clamped = shifted(steps, "dpwm-min")
    commands = clamped.run.commands.copy()
    commands["first_duty"] += 0.03 * np.where(np.arange(len(commands)) % 4 < 2, 1.0, 0.0)
    faulty = replace(
        clamped,
        run=replace(clamped.run, commands=commands),
        declaration=Declaration(modulation="dpwm-min"),
    )
    margin = judged("RIP-4", faulty)
    assert margin is not None
    assert not margin.met, margin.measured


class FlatBottom(InformedController):
    """The informed controller with the leg of the lowest voltage on the lower rail."""

    def _ratios(
        self, drive: PmAcDrive, voltage: complex, currents: complex, link: float
    ) -> tuple[float, float, float]:
        first, second, third = super()._ratios(drive, voltage, currents, link)
        lowest = min(first, second, third)
        return first - lowest, second - lowest, third - lowest


@cache
def flat_bottom(name: str, modulation: ModulationKind) -> DutyRecord:
    drive = load_drive(name).replaced(settling_s=0.1)
    assert isinstance(drive, PmAcDocument)
    speed = 0.5 * drive.rating.base_speed_rpm
    scenario = torque_scenario(drive, speed, [torque_of(drive, speed, share) for share in (0.4, 0.8)])
    witness = Witness("flat-bottom", (drive.kind,), made_for=FlatBottom)
    candidate = judged_witness(witness, scenario, Declaration(modulation=modulation))
    record = recorded(candidate, scenario, candidate.controller())
    assert isinstance(record, DutyRecord)
    return record


@pytest.mark.parametrize("name", ["pm-ac-interior", "pm-ac-msl", "pm-ac-2kw"])
def test_a_controller_that_clamps_the_lowest_leg_passes_where_it_declares_that(name: str) -> None:
    undeclared, declared = (judged("RIP-4", flat_bottom(name, kind)) for kind in ("continuous", "dpwm-min"))
    assert undeclared is not None
    assert declared is not None
    assert not undeclared.met, undeclared.measured
    assert "a leg is clamped nearly always" in undeclared.measured
    assert declared.met, declared.measured
    for check in ("ACC-1", "OVC-1"):
        margin = CHECKS[check].evaluate(flat_bottom(name, "dpwm-min"))
        assert margin is not None
        assert margin.met, margin.measured
