"""Any commands of duty ratios, for whole runs or from some step on, get a verdict and a report."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.harness.containment.test_hostile_fuzz import DRAWN_ONCE, assert_a_verdict
from tests.harness.made import made_result

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.candidates.fault import CandidateFault, Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import JudgedRun
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.run import DUTY_RATIOS, LEGS
from drivegate.contracts.duty.scenarios.building import torque_of, torque_scenario
from drivegate.gate.recording import behaviour_job, recording_plans, run_recorded, with_recordings
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate.output.result_reports import all_formats, read_result, write_result
from drivegate.results.provenance import provenance
from drivegate.results.verdict import candidate_verdict, check_outcomes
from drivegate_cases.drive.drive_document import drive_names, load_drive
from drivegate_models.contract.duty.records import DUTY_COMMAND
from drivegate_models.contract.duty.signals import LEG_HIGH, LEG_LOW, LEG_OFF, LEG_PWM
from drivegate_models.loop.step_recording import player_of, playing_step

DRIVES: Final = tuple(name for name in drive_names() if load_drive(name).kind == "pm-ac")
MOST_STEPS: Final = 20_000
DRAWS: Final = int(os.environ.get("DRIVEGATE_TEST_DRAWS", "4"))
"""Number of candidates; more of them for a hunt."""
RATIOS = st.one_of(st.sampled_from([0.0, 0.5, 1.0, 5e-324, 1e-9, -1.0, 1e308, -1e308, math.nan]), st.floats())
STATES = st.sampled_from([LEG_PWM, LEG_OFF, LEG_HIGH, LEG_LOW])


@dataclass(frozen=True)
class Part:
    """What is answered in turn, period by period: three duty ratios, three states of legs, and all the rest."""

    ratios: tuple[tuple[float, float, float], ...]
    legs: tuple[int, int, int] = (LEG_PWM, LEG_PWM, LEG_PWM)
    next_period: float = 0.0
    estimate: float = math.nan

    def commands(self, steps: int) -> NDArray[Any]:
        answers = np.zeros(steps, DUTY_COMMAND)
        answers["struct_size"] = DUTY_COMMAND.itemsize
        turns = np.array(self.ratios)[np.arange(steps) % len(self.ratios)]
        for place, (ratio, leg) in enumerate(zip(DUTY_RATIOS, LEGS, strict=True)):
            answers[ratio], answers[leg] = turns[:, place], self.legs[place]
        answers["next_period"] = self.next_period
        for name in ("torque", "angle", "speed", "input_power"):
            answers[name] = self.estimate
        return answers


PARTS = st.builds(
    Part,
    st.lists(
        st.one_of(RATIOS.map(lambda value: (value, value, value)), st.tuples(RATIOS, RATIOS, RATIOS)),
        min_size=1,
        max_size=3,
    ).map(tuple),
    st.one_of(STATES.map(lambda state: (state, state, state)), st.tuples(STATES, STATES, STATES)),
    st.one_of(st.just(0.0), st.floats()),
    st.one_of(st.just(math.nan), st.floats()),
)


class Played:
    """A controller of this process that answers with the first part up to some step, and then with the second."""

    fault = None

    def __init__(self, first: Part, second: Part, change: int) -> None:
        self._commands = np.concatenate([first.commands(change), second.commands(MOST_STEPS - change)])
        self._step = playing_step()
        self._state = player_of(self._commands)
        self.step_address: int = self._step.address
        self.state_address: int = self._state.ctypes.data

    def reset(self, _nameplate: object) -> None:
        self._state["given"] = 0


def behaviour_of(loaded: JudgedCandidate, outcomes: Any, drive: Any) -> dict[str, Any] | None:
    job = behaviour_job(drive, NOTHING_DECLARED, outcomes)
    assert job is not None
    try:
        return job.target(loaded, job.payload)
    except CandidateFault:
        return None


@pytest.mark.nightly
@settings(DRAWN_ONCE, max_examples=DRAWS)
@given(
    drive=st.sampled_from(DRIVES),
    first=PARTS,
    second=PARTS,
    change=st.sampled_from([0, 1, 500, MOST_STEPS]),
    place=st.floats(0.0, 0.999),
)
@pytest.mark.filterwarnings("error")
def test_any_commands_of_duty_ratios_get_a_verdict_and_a_report(
    drive: str, first: Part, second: Part, change: int, place: float, tmp_path: Path
) -> None:
    document = load_drive(drive).replaced(settling_s=0.2)
    candidate = resolve_candidate("foc")
    loaded = JudgedCandidate(candidate, lambda: Played(first, second, change))
    fixed = contract_of(document).fixed_scenarios(document, NOTHING_DECLARED)
    runs: list[JudgedRun] = []
    faults: list[Fault] = []
    try:
        runs.extend(run_fixed(loaded, FixedRuns((fixed[int(place * len(fixed))],))).runs)
    except CandidateFault as ended:
        faults.append(ended.fault)
    for ending in (*runs, *faults):
        assert_a_verdict(ending)
    outcomes = check_outcomes(runs, NOTHING_DECLARED, document, complete=not faults)
    plans = recording_plans(outcomes)
    outcomes, traces = with_recordings(outcomes, [run_recorded(loaded, plan) for plan in plans])
    verdict, exit_code = candidate_verdict(outcomes, faults)
    result = made_result(
        candidate,
        document,
        faults=faults,
        verdict=verdict,
        exit_code=exit_code,
        checks=outcomes,
        runs=len(runs),
        provenance=provenance(),
        timing={},
        traces=traces,
        behaviour=None if faults else behaviour_of(loaded, outcomes, document),
    )
    written = write_result(result.written(), tmp_path, all_formats())
    written.require_all()
    read_result(tmp_path / "result.json")


@pytest.mark.parametrize("ratios", [(0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (0.5 + 1e-9, 0.5, 0.5 + 1e-9)])
def test_an_active_short_circuit_fails_by_its_current_and_not_by_its_ripple(
    ratios: tuple[float, float, float],
) -> None:
    drive = load_drive("pm-ac-msl")
    short = Part((ratios,))
    loaded = JudgedCandidate(resolve_candidate("foc"), lambda: Played(short, short, 0))
    scenario = torque_scenario(drive, 600.0, [torque_of(drive, 600.0, share) for share in (0.0, 0.5)])
    (run,) = run_fixed(loaded, FixedRuns((scenario,))).runs
    assert_a_verdict(run)
    met = {margin.check: margin.met for margin in run.margins}
    assert (met["ACC-1"], met["OVC-1"]) == (False, False)
    assert "RIP-4" not in met
