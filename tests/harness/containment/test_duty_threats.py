"""What a candidate that answers with duty ratios may try against its judge: the same rows as for the other contract."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent

import pytest

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.watches import WorkerLimits
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario

SCENARIO = torque_scenario(load_drive("pm-ac-interior"), 600.0, (0.0, 1.2345)).replaced(
    duration_s=0.05,
    load={"kind": "dynamometer", "torque_reference_nm": [[0.0, 0.0], [0.04, 0.0], [0.04, 1.2345]]},
)
LIMITS = WorkerLimits(step_processor_seconds=0.5, start_processor_seconds=20.0, idle_seconds=10.0)
CANDIDATE = """
import ctypes, gc, os, struct, sys
import numpy as np
from drivegate import DutyCommand
{top}
def frames():
    frame = sys._getframe()
    while frame is not None:
        yield frame
        frame = frame.f_back
def shared():
    for frame in frames():
        for value in frame.f_locals.values():
            if type(value).__name__ == "SharedMemory":
                return value
class Mine:
    def reset(self, nameplate):
        self.count = 0
    def step(self, sense):
        self.count += 1
        if self.count == 50:
{step}
        return DutyCommand((0.5, 0.45, 0.5))
"""


def digest_of(loaded: JudgedCandidate, scenario: Scenario) -> int:
    return recorded(loaded, scenario, loaded.controller()).run.digest


@pytest.fixture
def attempt(tmp_path: Path, no_process_left: None):
    """Run a candidate that does something in its fiftieth step, or when it is imported."""

    def made(step: str = "pass", top: str = "pass") -> int | Fault:
        file = tmp_path / "mine.py"
        text = CANDIDATE.format(top=top, step=indent(step.strip(), " " * 12))
        file.write_text(text, encoding="utf-8")
        with Judge(resolve_candidate(f"{file}:Mine"), limits=LIMITS) as judge:
            return judge.once(Job(digest_of, SCENARIO))

    return made


def test_an_honest_one_is_judged(attempt) -> None:
    assert isinstance(attempt(), int)


LAYOUT = "from drivegate_models.contract.duty.records import DUTY_COMMAND"


def test_commands_written_over_are_what_is_judged(attempt) -> None:
    fault = attempt(f"{LAYOUT}\nshared().commands(DUTY_COMMAND)['first_duty'][:9] = 0.9")
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.MEMORY, "the plant there has had other commands than are kept"


CHANGED_PLANT = """
from dataclasses import replace
import drivegate_models.pm_ac.closed_loop as there
prepared = there.prepared_duty_loop
def easier(inputs, controller, restarts):
    drive = inputs.drive._replace(resistance=2.0 * inputs.drive.resistance)
    return prepared(replace(inputs, drive=drive), controller, restarts)
there.prepared_duty_loop = easier
"""


def test_another_plant_in_the_candidates_process_is_noticed(attempt) -> None:
    fault = attempt(top=CHANGED_PLANT)
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.MEMORY, fault.message


LOOK = """
seen = []
for frame in frames():
    seen += list(frame.f_locals.values())
seen += [found for found in gc.get_objects() if isinstance(found, (tuple, list, dict))]
def holds(thing, depth=0):
    if isinstance(thing, float):
        return thing == 1.2345
    if isinstance(thing, np.ndarray) and thing.dtype == np.float64 and thing.size < 100:
        return bool((thing == 1.2345).any())
    if isinstance(thing, (tuple, list)) and depth < 3 and len(thing) < 50:
        return any(holds(part, depth + 1) for part in thing)
    return False
if any(map(holds, seen)):
    raise RuntimeError("I know what will be asked of me")
"""


def test_what_is_to_come_in_a_run_is_nowhere_to_be_seen(attempt) -> None:
    ended = attempt(LOOK.replace("1.2345", "float('1.23' + '45')"))
    assert isinstance(ended, int), f"{ended}: the reference of a later step lies in the candidate's sight"


@pytest.mark.parametrize(
    ("step", "kind"),
    [
        ("os._exit(3)", FaultKind.CRASH),
        ("while True: pass", FaultKind.HANG),
        ("os.kill(os.getpid(), 11)", FaultKind.CRASH),
    ],
)
def test_what_ends_or_holds_its_process_is_a_verdict(attempt, step: str, kind: FaultKind) -> None:
    fault = attempt(step)
    assert isinstance(fault, Fault)
    assert (fault.kind, fault.step) == (kind, 49), fault
