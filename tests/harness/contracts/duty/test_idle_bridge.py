"""A candidate that reads `enable` is stepped before each run with the bridge off; any other one is not."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.harness.candidates.native.duty_sources import duty_source

from drivegate.candidates.fault import Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.contract import Witness
from drivegate.contracts.duty.idle_bridge import WAITING_PERIODS
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.running import recorded
from drivegate.gate.witnesses import judged_witness
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario

SHORT = torque_scenario(load_drive("pm-ac-interior"), 600.0, (0.0,)).replaced(duration_s=0.02)
PYTHON = """
from drivegate import DutyCommand

class Mine:
    def reset(self, nameplate):
        self.off = self.still = 0

    def step(self, sense):
        if not sense.enable:
            self.off += 1
            self.still += sense.speed == 0.0
            return DutyCommand((1.0, 0.0, 0.0))
        return DutyCommand((0.5, 0.5, 0.5), torque=self.off, speed=self.still)
"""
C = """
    static int64_t off, still;
    if (self->steps == 1) off = still = 0;
    off += !sense->enable;
    still += sense->speed == 0.0;
    if (!sense->enable) { command->duty_ratios[0] = NAN; command->legs[1] = 9; }
    command->torque = (double)off;
    command->speed = (double)still;
    if (self->steps == 5)"""


def counted(loaded: JudgedCandidate, scenario: Scenario) -> tuple[int, int, int]:
    """Run once; return the numbers of steps with the bridge off, of those at standstill, and of commands."""
    record = recorded(loaded, scenario, loaded.controller())
    first = record.run.commands[0]
    assert (record.run.commands["torque"] == first["torque"]).all()
    assert record.run.column("peak_current")[0] == 0.0, "what it commands before the run never acts"
    return int(first["torque"]), int(first["speed"]), len(record.run.commands)


def written(folder: Path, kind: str, keys: str) -> str:
    """Write a candidate of a kind with a manifest; return its path."""
    name = f"mine.{'py' if kind == 'python' else 'c'}"
    text = PYTHON if kind == "python" else duty_source().replace("    if (self->steps == 5)", C)
    (folder / name).write_text(text, encoding="utf-8")
    entry = f"{name}:Mine" if kind == "python" else name
    lines = f'schema = 1\nname = "mine"\nkind = "{kind}"\nentry = "{entry}"\ncontract = "duty"\n{keys}\n'
    (folder / "candidate.toml").write_text(lines, encoding="utf-8")
    return str(folder / "candidate.toml")


def run(manifest: str) -> tuple[int, int, int]:
    """Run the candidate in a process of its own, whose commands are played back here."""
    with Judge(resolve_candidate(manifest)) as judge:
        ended = judge.run(Job(counted, SHORT))
    assert not isinstance(ended, Fault), ended
    return ended


@pytest.mark.parametrize("kind", ["python", "c"])
def test_it_is_stepped_with_the_bridge_off_before_each_run(tmp_path: Path, kind: str) -> None:
    periods, resting = SHORT.control_periods, round(0.013 / SHORT.control_period_s)
    assert run(written(tmp_path, kind, "")) == (0, 0, periods)
    assert run(written(tmp_path, kind, "reads_enable = true")) == (WAITING_PERIODS, 0, periods)
    both = "reads_enable = true\ncalibration_time_s = 0.013"
    assert run(written(tmp_path, kind, both)) == (WAITING_PERIODS + resting, resting, periods)


def test_a_witness_does_not_wait_for_a_bridge_that_it_does_not_read(tmp_path: Path) -> None:
    declared = resolve_candidate(written(tmp_path, "python", "reads_enable = true")).declaration
    judged = judged_witness(Witness("foc", ("pm-ac",)), SHORT, declared)
    assert judged.candidate.declaration == declared.with_bridge_on()
