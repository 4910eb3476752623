"""Firmware of five styles meets the required checks; with one line changed it fails the check that names the fault."""

from __future__ import annotations

import shutil
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.checks.margin import Margin
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.running import recorded
from drivegate.gate.plan import NOTHING_DECLARED
from drivegate.studies.new import write_candidate
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.sensors import SHUNTS

FOLDER = Path(__file__).parents[4] / "examples" / "firmware"
DRIVE = load_drive("pm-ac-interior")
CONTRACT = contract_of(DRIVE)
SCENARIOS = {scenario.name: scenario for scenario in CONTRACT.fixed_scenarios(DRIVE, NOTHING_DECLARED)}
FOLDERS = MappingProxyType({"image": "interrupt", "registers": "interrupt"})
MANIFESTS = MappingProxyType({"image": "image.toml", "registers": "registers.toml"})


class Seeded(NamedTuple):
    """A fault of one line, with the check that it fails."""

    style: str
    file: str
    line: str
    fault: str
    check: str
    scenario: str


NO_DELAY = Seeded(
    "embedded-coder",
    "model/controller.c",
    "    angle += electrical * rtP.Lead;\n",
    "",
    "FWK-3",
    "6000rpm-torque-0-2.387-0Nm",
)
NO_DECAY = Seeded(
    "interrupt",
    "firmware.c",
    "#define DECAY 32 ",
    "#define DECAY 0 ",
    "RIP-4",
    "1040rpm-torque-1.364Nm-restart",
)
STUCK_INTEGRAL = Seeded(
    "interrupt",
    "firmware.c",
    "possible + 0.002F * most_torque",
    "possible",
    "ACC-1",
    "3280rpm-1.019Nm-30-100%-restart",
)
WRONG_SIGN = Seeded(
    "objects",
    "motor_control.cpp",
    "- electrical * motor.quadrature_inductance * current.quadrature",
    "+ electrical * motor.quadrature_inductance * current.quadrature",
    "DEC-1",
    "1040rpm-torque-0-2.046-1.137-0.2274-0Nm",
)
WRONG_CHANNEL = Seeded(
    "interrupt", "firmware.c", "ADC1->JDR3", "ADC1->JDR2", "ACC-1", "1040rpm-torque-1.364Nm-clock-2147.4s"
)
NO_ANTI_WINDUP = Seeded(
    "crate",
    "src/foc.rs",
    "            regulator.integral -= regulator.step * excess * *output / regulator.gain;\n",
    "",
    "STP-1",
    "1050rpm-torque-0.5684-1.137-2.274Nm",
)
WRONG_SCALE = Seeded(
    "image", "firmware.c", "/ 3.0F, beta", "/ 2.0F, beta", "RIP-4", "1040rpm-torque-1.364Nm-clock-2147.4s"
)

WRONG_REGISTER = Seeded(
    "registers",
    "registers.toml",
    "TIM1.CCR3 /",
    "TIM1.CCR2 /",
    "ACC-1",
    "1040rpm-torque-1.364Nm-clock-2147.4s",
)


def margins_of(seeded: Seeded, folder: Path, line: str) -> dict[str, Margin]:
    """Build the firmware with one line as given, run one scenario, and judge the run."""
    if seeded.style == "embedded-coder":
        write_candidate(seeded.style, "mine", folder, datetime.now(UTC).date())
    else:
        shutil.copytree(
            FOLDER / FOLDERS.get(seeded.style, seeded.style),
            folder,
            ignore=shutil.ignore_patterns("target", "*.elf"),
        )
    file = folder / seeded.file
    text = file.read_text(encoding="utf-8")
    assert text.count(seeded.line) == 1
    file.write_text(text.replace(seeded.line, line), encoding="utf-8")
    candidate = resolve_candidate(str(folder / MANIFESTS.get(seeded.style, "candidate.toml")))
    loaded = own_candidate(candidate)
    record = recorded(loaded, SCENARIOS[seeded.scenario], loaded.controller())
    return {margin.check: margin for margin in judged(record, CONTRACT.checks).margins}


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "seeded",
    [
        pytest.param(NO_DECAY, id="interrupt-handler-that-measures-offsets-while-current-flows"),
        pytest.param(
            STUCK_INTEGRAL, id="interrupt-handler-whose-integral-waits-at-the-voltage-limit-for-good"
        ),
        pytest.param(NO_DELAY, id="generated-code-without-delay-compensation"),
        pytest.param(
            WRONG_SIGN,
            id="objects-with-a-sign-wrong-on-the-d-axis",
            marks=[pytest.mark.needs("c++"), pytest.mark.nightly],
        ),
        pytest.param(WRONG_CHANNEL, id="interrupt-handler-with-the-wrong-converter-channel"),
        pytest.param(
            NO_ANTI_WINDUP,
            id="crate-without-anti-windup",
            marks=[pytest.mark.needs("cargo"), pytest.mark.nightly],
        ),
        pytest.param(
            WRONG_SCALE, id="image-with-a-wrong-Clarke-scale", marks=pytest.mark.needs("arm-none-eabi-gcc")
        ),
        pytest.param(
            WRONG_REGISTER,
            id="registers-with-a-wrong-compare-channel",
            marks=[pytest.mark.needs("arm-none-eabi-gcc"), pytest.mark.nightly],
        ),
    ],
)
def test_a_fault_of_one_line_fails_its_check(seeded: Seeded, tmp_path: Path) -> None:
    margins = margins_of(seeded, tmp_path / "right", seeded.line)
    assert [m.measured for m in margins.values() if not m.met and not m.advisory] == []
    assert margins[seeded.check].met
    assert not margins_of(seeded, tmp_path / "wrong", seeded.fault)[seeded.check].met


def test_the_interrupt_handler_measures_the_offsets_of_its_currents(tmp_path: Path) -> None:
    folder = tmp_path / "interrupt"
    shutil.copytree(FOLDER / "interrupt", folder, ignore=shutil.ignore_patterns("*.elf"))
    candidate = resolve_candidate(str(folder / "candidate.toml"))
    offset = torque_scenario(DRIVE, 1000.0, (1.5,)).replaced(
        sensors=SHUNTS.model_copy(update={"current_offset_a": 0.2}), seed=3
    )
    swings = []
    for declaration in (candidate.declaration.with_bridge_on(), candidate.declaration):
        loaded = own_candidate(replace(candidate, declaration=declaration))
        torque = recorded(loaded, offset, loaded.controller()).run.column("torque")[-2000:]
        swings.append(torque.max() - torque.min())
    assert swings[1] < 0.25 * swings[0], "only standstill with the bridge off shows them"
