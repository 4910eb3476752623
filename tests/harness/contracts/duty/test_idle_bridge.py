"""A candidate that reads `enable` is stepped before each run with the bridge off; any other one is not."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from tests.harness.candidates.native.duty_sources import duty_source

from drivegate.candidates.fault import Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.catalogue import check_of
from drivegate.contracts.contract import Witness
from drivegate.contracts.duty.likely_causes import likely_causes
from drivegate.contracts.duty.run import WAITING_PERIODS
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.running import recorded
from drivegate.gate.witness_runs import judged_witness
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
            return DutyCommand((float("nan"), 0.0, 0.0), legs=(9, 9, 9))
        return DutyCommand((0.5, 0.5, 0.5), torque=self.off, speed=self.still)
"""
PROGRAM = """
import json, sys

for line in sys.stdin:
    message = json.loads(line)
    if "message" in message:
        answer = {"drivegate": 1}
    elif "reset" in message:
        off = still = 0
        answer = {"ready": True}
    else:
        sense = message["sense"]
        off += not sense["enable"]
        still += sense["speed"] == 0.0
        answer = {"duty_ratios": [0.5, 0.5, 0.5], "torque": off, "speed": still}
    print(json.dumps(answer), flush=True)
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


PLAIN = """
from math import cos, sin, sqrt
from drivegate import DutyCommand

def rotated(phases, angle):
    first, second, third = phases
    along, across = (2.0 * first - second - third) / 3.0, (second - third) / sqrt(3.0)
    return cos(angle) * along + sin(angle) * across, cos(angle) * across - sin(angle) * along

class Mine:
    \"\"\"Two PI regulators without any voltage that is added beforehand, as much public firmware has them.\"\"\"

    preloads = {preloads}

    def reset(self, nameplate):
        self.plate, self.integrals = nameplate, (0.0, 0.0)

    def step(self, sense):
        plate = self.plate
        angle = plate.pole_pairs * sense.angle
        if not sense.enable:
            if self.preloads:
                self.integrals = rotated(sense.phase_voltages, angle)
            return DutyCommand((0.5, 0.5, 0.5))
        direct, quadrature = rotated(sense.phase_currents, angle)
        gains = [0.2 * value / plate.control_period for value in (plate.direct_inductance, plate.quadrature_inductance)]
        # No torque is asked for.
        errors = (-direct, -quadrature)
        along, across = (gain * error + held for gain, error, held in zip(gains, errors, self.integrals))
        self.integrals = [held + 0.02 * gain * error for held, gain, error in zip(self.integrals, gains, errors)]
        angle += plate.pole_pairs * sense.speed * (plate.update_delay + 0.5) * plate.control_period
        length, turn = sense.supply_voltage, 2.0943951023931953
        return DutyCommand([
            0.5 + (cos(angle - leg * turn) * along - sin(angle - leg * turn) * across) / length for leg in range(3)
        ])
"""


def peaks(loaded: JudgedCandidate, scenario: Scenario) -> tuple[list[float], str]:
    """Return the peak current of each control period of a run (A), and what OVC-1 has measured."""
    record = recorded(loaded, scenario, loaded.controller())
    margin = check_of("duty", "OVC-1").evaluate(record)
    assert margin is not None
    return [float(peak) for peak in record.run.column("peak_current")], margin.measured


def counted(loaded: JudgedCandidate, scenario: Scenario) -> tuple[int, int, int]:
    """Run once; return the numbers of steps with the bridge off, of those at standstill, and of commands."""
    record = recorded(loaded, scenario, loaded.controller())
    first = record.run.commands[0]
    assert (record.run.commands["torque"] == first["torque"]).all()
    assert record.run.column("peak_current")[0] == 0.0, "what it commands before the run never acts"
    return int(first["torque"]), int(first["speed"]), len(record.run.commands)


def written(folder: Path, kind: str, keys: str) -> str:
    """Write a candidate of a kind with a manifest; return its path."""
    name, entry, text = {
        "python": ("mine.py", "mine.py:Mine", PYTHON),
        "exec": ("mine.py", f"{sys.executable} mine.py", PROGRAM),
        "c": ("mine.c", "mine.c", duty_source().replace("    if (self->steps == 5)", C)),
    }[kind]
    (folder / name).write_text(text, encoding="utf-8")
    lines = f'schema = 1\nname = "mine"\nkind = "{kind}"\nentry = "{entry}"\ncontract = "duty"\n{keys}\n'
    (folder / "candidate.toml").write_text(lines, encoding="utf-8")
    return str(folder / "candidate.toml")


def run(manifest: str) -> tuple[int, int, int]:
    """Run the candidate in a process of its own, whose commands are played back here."""
    with Judge(resolve_candidate(manifest)) as judge:
        ended = judge.run(Job(counted, SHORT))
    assert not isinstance(ended, Fault), ended
    return ended


@pytest.mark.parametrize("kind", ["python", "exec", "c"])
def test_it_is_stepped_with_the_bridge_off_before_each_run(tmp_path: Path, kind: str) -> None:
    periods, resting = SHORT.control_periods, round(0.013 / SHORT.control_period_s)
    assert run(written(tmp_path, kind, "")) == (0, 0, periods)
    assert run(written(tmp_path, kind, "reads_enable = true")) == (WAITING_PERIODS, 0, periods)
    both = "reads_enable = true\ncalibration_time_s = 0.013"
    assert run(written(tmp_path, kind, both)) == (WAITING_PERIODS + resting, resting, periods)


def test_integrators_preloaded_from_the_terminals_begin_without_a_peak(tmp_path: Path) -> None:
    drive = load_drive("pm-ac-2kw")
    spinning = torque_scenario(drive, 780.0, (0.0,)).replaced(duration_s=0.03, restarts_s=(0.015,))
    again = round(0.015 / spinning.control_period_s) + WAITING_PERIODS
    shown, begins, again_on = round(3e-3 / spinning.control_period_s), [], []
    for preloads in (False, True):
        manifest = written(tmp_path, "python", "reads_enable = true")
        (tmp_path / "mine.py").write_text(PLAIN.format(preloads=preloads), encoding="utf-8")
        with Judge(resolve_candidate(manifest)) as judge:
            found = judge.run(Job(peaks, spinning))
        assert not isinstance(found, Fault), found
        currents, _ = found
        begins.append(max(currents[:shown]))
        again_on.append(max(currents[again : again + shown]))
        assert max(currents[again - 10 : again]) < 0.01, "the bridge is off after a restart too"
    # The rest is the ripple of the carrier.
    for greatest in (begins, again_on):
        assert greatest[1] < 0.2 * greatest[0], greatest


def test_a_fault_of_enable_is_named_as_one(tmp_path: Path) -> None:
    manifest = written(tmp_path, "python", "reads_enable = true")
    spinning = torque_scenario(load_drive("pm-ac-2kw"), 1300.0, (0.0,)).replaced(duration_s=0.02)
    with Judge(resolve_candidate(manifest)) as judge:
        found = judge.run(Job(peaks, spinning))
    assert not isinstance(found, Fault), found
    _, measured = found
    assert "ms after the bridge turns on" in measured, "without a voltage it is a short circuit"
    causes = [cause for cause, _ in likely_causes([{"id": "OVC-1", "measured": measured}])]
    assert "while 'enable' is 0" in causes[0].words


def test_a_witness_does_not_wait_for_a_bridge_that_it_does_not_read(tmp_path: Path) -> None:
    declared = resolve_candidate(written(tmp_path, "python", "reads_enable = true")).declaration
    judged = judged_witness(Witness("foc", ("pm-ac",)), SHORT, declared)
    assert judged.candidate.declaration == declared.with_bridge_on()
