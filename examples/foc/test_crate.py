"""The crate `foc` 0.3.0 takes measurement minus setpoint: the gate finds it, and negative gains make up for it."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.scenarios.building import torque_of, torque_scenario
from drivegate.drives.running import recorded
from drivegate.isolation.layers import roots_named
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument

HERE = Path(__file__).parent


@pytest.mark.parametrize(("features", "meets"), [("", False), (" --features negative_gains", True)])
def test_its_regulators_drive_the_current_away_unless_gains_are_negative(
    features: str, meets: bool, tmp_path: Path
) -> None:
    """The regulators as they are fail three checks on a step of torque, and meet them with negative gains."""
    target = tmp_path / "foc"
    shutil.copytree(HERE, target, ignore=shutil.ignore_patterns("target"))
    shutil.copytree(HERE.parent / "firmware" / "crate", tmp_path / "firmware" / "crate")
    subprocess.run(["cargo", "fetch", "--quiet"], cwd=target, check=True)
    manifest = target / "candidate.toml"
    command = "cargo build --release"
    manifest.write_text(manifest.read_text().replace(command, f"{command}{features}", 1), encoding="utf-8")
    with roots_named([str(tmp_path / "firmware")]):
        loaded = own_candidate(resolve_candidate(str(manifest)))
    drive = load_drive("pm-ac-surface")
    assert isinstance(drive, PmAcDocument)
    speed = 0.1 * drive.rating.base_speed_rpm
    run = torque_scenario(drive, speed, [torque_of(drive, speed, share) for share in (0.0, 0.3)])
    record = recorded(loaded, run, loaded.controller())
    margins = {margin.check: margin for margin in judged(record, contract_of(drive).checks).margins}
    for check in ("STP-1", "RIP-4", "OVC-1"):
        assert margins[check].met is meets, margins[check].measured
