"""Kinds of candidates that serve the contract of duty ratios give the same commands; the others say so."""

from __future__ import annotations

from collections.abc import Callable
from math import pi, tau
from pathlib import Path

import numpy as np
import pytest
from tests.harness.candidates.native.duty_sources import duty_source

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.run import DUTY_RATIOS
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.kinds import drive_for
from drivegate.drives.running import recorded
from drivegate.gate.plan import time_steps
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario, load_scenario
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

INTERIOR = load_drive("pm-ac-interior")
SHORT = torque_scenario(INTERIOR, 600.0, (0.0,)).replaced(duration_s=0.02)

PYTHON = """
from math import sin
from drivegate import DutyCommand

class Mine:
    def reset(self, nameplate):
        self.pole_pairs, self.flux, self.steps = nameplate.pole_pairs, nameplate.magnet_flux, 0

    def step(self, sense):
        self.steps += 1
        electrical = self.pole_pairs * sense.speed
        share = min(electrical * self.flux / sense.supply_voltage, 0.5)
        angle = self.pole_pairs * sense.angle
        ratios = [0.5 - share * sin(angle - leg * 2.0943951023931953) for leg in range(3)]
        if self.steps == 5:
            {fifth_step}
        return DutyCommand(ratios)
"""
NUMBA = """
from math import sin
import numpy as np
from drivegate import NumbaController

def reset(state, nameplate):
    state.pole_pairs = nameplate.pole_pairs
    state.flux = nameplate.magnet_flux

def step(state, sense, command):
    share = min(state.pole_pairs * sense.speed * state.flux / sense.supply_voltage, 0.5)
    angle = state.pole_pairs * sense.angle
    command.first_duty = 0.5 - share * sin(angle)
    command.second_duty = 0.5 - share * sin(angle - 2.0943951023931953)
    command.third_duty = 0.5 - share * sin(angle - 2 * 2.0943951023931953)

mine = NumbaController(
    np.dtype([("pole_pairs", np.float64), ("flux", np.float64)]), reset=reset, step=step, contract="duty"
)
"""
PLAIN = """
from drivegate import Command, DutyCommand

class Mine:
    def reset(self, nameplate):
        pass

    def step(self, sense):
        return DutyCommand((0.5, 0.5, 0.5))

class Other(Mine):
    def step(self, sense):
        return Command(1.0, 0.0)
"""
PROGRAM = """
import json, sys
from math import sin

for line in sys.stdin:
    message = json.loads(line)
    if "message" in message:
        answer = {"drivegate": 1}
    elif "reset" in message:
        plate, answer = message["reset"], {"ready": True}
    else:
        sense = message["sense"]
        pairs = plate["pole_pairs"]
        share = min(pairs * sense["speed"] * plate["magnet_flux"] / sense["supply_voltage"], 0.5)
        angle = pairs * sense["angle"]
        answer = {"duty_ratios": [0.5 - share * sin(angle - leg * 2.0943951023931953) for leg in range(3)]%s}
    print(json.dumps(answer), flush=True)
"""

SHOWN_C = """#include "drivegate_duty.h"
#include <stddef.h>
int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }
int64_t drivegate_state_size(void) { return 8; }
int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *plate) { return 0; }
void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    command->duty_ratios[0] = 0.5 + sense->angle / 4096.0;
    command->duty_ratios[1] = 0.5 + (double)sense->encoder_count / 1048576.0;
    command->duty_ratios[2] = 0.5 + (double)sense->hall / 4096.0;
}
"""
SHOWN_PYTHON = """
from drivegate import DutyCommand

class Mine:
    def reset(self, nameplate):
        pass

    def step(self, sense):
        return DutyCommand((
            0.5 + sense.angle / 4096.0, 0.5 + sense.encoder_count / 1048576.0, 0.5 + sense.hall / 4096.0
        ))
"""
SHOWN_NUMBA = """
import numpy as np
from drivegate import NumbaController

def reset(state, nameplate):
    state.steps = 0

def step(state, sense, command):
    command.first_duty = 0.5 + sense.angle / 4096.0
    command.second_duty = 0.5 + sense.encoder_count / 1048576.0
    command.third_duty = 0.5 + sense.hall / 4096.0

mine = NumbaController(np.dtype([("steps", np.int64)]), reset=reset, step=step, contract="duty")
"""
SHOWN_PROGRAM = """
import json, sys

for line in sys.stdin:
    message = json.loads(line)
    if "message" in message:
        answer = {"drivegate": 1}
    elif "reset" in message:
        answer = {"ready": True}
    else:
        sense = message["sense"]
        answer = {"duty_ratios": [
            0.5 + sense["angle"] / 4096.0,
            0.5 + sense.get("encoder_count", -1) / 1048576.0,
            0.5 + sense.get("hall", -1) / 4096.0,
        ]}
    print(json.dumps(answer), flush=True)
"""
"""Controllers that answer with the place of the shaft, as they are shown it."""


def run_once(loaded: JudgedCandidate, scenario: Scenario) -> CurrentRecord:
    return recorded(loaded, scenario, loaded.controller())


def ended(specification: str, scenario: Scenario = SHORT) -> CurrentRecord | Fault:
    with Judge(resolve_candidate(specification)) as judge:
        return judge.run(Job(run_once, scenario))


def python_source(folder: Path, fifth_step: str = "pass") -> str:
    file = folder / "mine.py"
    file.write_text(PYTHON.format(fifth_step=fifth_step), encoding="utf-8")
    return f"{file}:Mine"


def test_every_kind_gives_the_same_commands_by_the_same_algorithm(
    tmp_path: Path, build_fmu: Callable[..., Path]
) -> None:
    (tmp_path / "mine.c").write_text(duty_source(), encoding="utf-8")
    (tmp_path / "compiled.py").write_text(NUMBA, encoding="utf-8")
    (tmp_path / "program.py").write_text(PROGRAM % "", encoding="utf-8")
    names = {
        "c": str(tmp_path / "mine.c"),
        "python": python_source(tmp_path),
        "numba": f"{tmp_path / 'compiled.py'}:mine",
        "exec": f"exec:python3 {tmp_path / 'program.py'}",
        "fmu": str(build_fmu([tmp_path / "mine.c"], tmp_path / "mine.fmu", fmi=3, contract="duty")),
    }
    digests = {}
    for kind, name in names.items():
        record = ended(name)
        assert isinstance(record, DutyRecord), f"{kind}: {record}"
        digests[kind] = record.run.digest
    assert len(set(digests.values())) == 1, f"the kinds answer differently: {digests}"


def shown_places(specification: str, runs: list[Scenario]) -> list[np.ndarray]:
    """Return angle, count and Hall states that a controller was shown in runs, from its answers, each shape (3, n)."""
    shown = []
    with Judge(resolve_candidate(specification)) as judge:
        for run in runs:
            record = judge.run(Job(run_once, run))
            assert isinstance(record, DutyRecord), f"{specification}: {record}"
            ratios = np.stack([record.run.commands[leg] for leg in DUTY_RATIOS])
            shown.append(np.round((ratios - 0.5) * [[4096.0], [1048576.0], [4096.0]], 9))
    return shown


def test_every_kind_is_shown_the_same_place_of_the_shaft_over_more_than_a_turn(tmp_path: Path) -> None:
    positions = ("exact", "encoder", "hall")
    drives = [
        INTERIOR.with_overrides(["machine.pole_pairs=4", f"sensing.position={one}"]) for one in positions
    ]
    runs = [
        torque_scenario(duty_document(drive), 600.0, (0.0,)).replaced(duration_s=0.16) for drive in drives
    ]
    sources = {
        "c.c": SHOWN_C,
        "python.py": SHOWN_PYTHON,
        "compiled.py": SHOWN_NUMBA,
        "program.py": SHOWN_PROGRAM,
    }
    for name, source in sources.items():
        (tmp_path / name).write_text(source, encoding="utf-8")
    shown = shown_places(f"{tmp_path / 'c.c'}", runs)
    for other in ("python.py:Mine", "compiled.py:mine"):
        assert np.array_equal(shown_places(f"{tmp_path / other}", runs), shown), other
    assert np.array_equal(shown_places(f"exec:python3 {tmp_path / 'program.py'}", runs), shown), "a program"
    true = np.arange(shown[0].shape[1]) * INTERIOR.control_period_s * 600.0 * RADIANS_PER_RPM
    for position, (angle, count, hall) in zip(positions, shown, strict=True):
        apart = np.abs((angle - true + pi) % tau - pi)
        assert apart.max() < {"exact": 1e-8, "encoder": 1e-3, "hall": 1e-3}[position], position
        assert np.count_nonzero(np.diff(angle) < 0.0) == 1, "it starts again once in 1.6 turns"
        assert (np.ptp(count) > 4080.0) == (position == "encoder"), "edges of 1024 lines"
        assert set(hall) == ({1.0, 2.0, 3.0, 4.0, 5.0, 6.0} if position == "hall" else {-1.0})


@pytest.mark.parametrize(
    ("fifth_step", "kind", "message"),
    [
        ("ratios[1] = float('nan')", FaultKind.INVALID_OUTPUT, "but all must be finite"),
        ("return DutyCommand(ratios, (1, 7, 1))", FaultKind.INVALID_OUTPUT, "legs are 1, 7, 1"),
        ("raise RuntimeError('broken')", FaultKind.EXCEPTION, "RuntimeError: broken"),
        ("import os; os._exit(3)", FaultKind.CRASH, "ended itself with exit status 3"),
    ],
)
def test_what_a_python_class_does_wrong_is_a_verdict_with_its_step(
    tmp_path: Path, fifth_step: str, kind: FaultKind, message: str
) -> None:
    fault = ended(python_source(tmp_path, fifth_step))
    assert isinstance(fault, Fault), fault
    assert (fault.kind, fault.phase, fault.step) == (kind, "step", 4), fault
    assert message in fault.message
    assert fault.sense is not None
    assert fault.sense["supply_voltage"] == INTERIOR.inverter.supply_voltage_v * 2


def test_steps_in_python_are_timed_as_such(tmp_path: Path) -> None:
    plan = torque_scenario(INTERIOR, 600.0, (0.0,))
    with Judge(resolve_candidate(python_source(tmp_path))) as judge:
        timed = judge.run(Job(time_steps, plan))
    assert "(Python)" in timed.runs[0].margins[0].measured


def test_a_program_answers_with_whole_json(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(PROGRAM % ', "legs": 3', encoding="utf-8")
    fault = ended(f"exec:python3 {tmp_path / 'program.py'}")
    assert isinstance(fault, Fault)
    assert "'legs' is 3, but must be a list of three numbers" in fault.message


def test_a_controller_of_the_other_contract_is_refused_in_one_sentence(tmp_path: Path) -> None:
    currents = load_scenario("fig5-search").replaced(duration_s=0.25)
    (tmp_path / "compiled.py").write_text(NUMBA, encoding="utf-8")
    (tmp_path / "plain.py").write_text(PLAIN, encoding="utf-8")
    for name in ("compiled.py:mine", "plain.py:Mine"):
        with pytest.raises(
            InputError, match="answers with duty ratios, but the drive takes a current reference"
        ):
            ended(str(tmp_path / name), currents)
    with pytest.raises(
        InputError, match=r"answers with a current reference .*, but the drive takes duty ratios"
    ):
        ended(f"{tmp_path / 'plain.py'}:Other")


@pytest.mark.parametrize(
    ("imports", "contract"),
    [
        ("from drivegate import DutyCommand, DutySense", "duty"),
        ("from drivegate import Command", "current"),
        ("from drivegate import Command, DutyCommand", None),
        ("import drivegate", None),
        ("from elsewhere import DutyCommand", None),
        ("this is no Python", None),
    ],
)
def test_a_python_file_is_of_the_contract_whose_command_it_imports(
    tmp_path: Path, imports: str, contract: str | None
) -> None:
    (tmp_path / "mine.py").write_text(f"{imports}\n", encoding="utf-8")
    assert resolve_candidate(f"{tmp_path / 'mine.py'}:Mine").contract == contract


def test_a_python_class_is_judged_on_the_drive_that_is_named_and_on_the_manifests(tmp_path: Path) -> None:
    reported = resolve_candidate(python_source(tmp_path))
    assert drive_for(reported).name == "pm-ac-interior"
    with pytest.raises(InputError, match="answers with duty ratios, but the drive 'paper-5-phase'"):
        drive_for(reported, load_drive("paper-5-phase"))
    (tmp_path / "mine.py").write_text("import drivegate\n", encoding="utf-8")
    manifest = tmp_path / "candidate.toml"
    text = 'schema = 1\nname = "mine"\nkind = "python"\nentry = "mine.py:Mine"\n'
    manifest.write_text(text, encoding="utf-8")
    open_one = resolve_candidate(str(manifest))
    assert open_one.contract is None
    assert drive_for(open_one).contract == "current"
    assert drive_for(open_one, INTERIOR) is INTERIOR
    manifest.write_text(text + 'contract = "duty"\n', encoding="utf-8")
    stated = resolve_candidate(str(manifest))
    assert drive_for(stated).name == "pm-ac-interior"
    with pytest.raises(InputError, match="answers with duty ratios, but the drive 'paper-5-phase'"):
        drive_for(stated, load_drive("paper-5-phase"))


def test_a_manifest_of_the_reference_says_that_it_gives_no_duty_ratios(tmp_path: Path) -> None:
    manifest = tmp_path / "candidate.toml"
    text = 'schema = 1\nname = "mine"\nkind = "builtin"\nentry = "reference"\n'
    manifest.write_text(text, encoding="utf-8")
    with pytest.raises(
        InputError, match="answers with a current reference and an advance angle, but the drive"
    ):
        drive_for(resolve_candidate(str(manifest)), INTERIOR)
    manifest.write_text(text + 'contract = "duty"\n', encoding="utf-8")
    with pytest.raises(
        InputError, match="the key 'contract' is 'duty', but the candidate answers with a current"
    ):
        resolve_candidate(str(manifest))
