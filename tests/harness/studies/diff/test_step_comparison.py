"""Two candidates step by step: the first difference, with what both sensed and the plant's own state."""

import math
from dataclasses import replace

import numpy as np
import pytest

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.current.run import plant_state
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.kinds import kind_of
from drivegate.drives.running import run_scenario
from drivegate.studies.diff.diff import (
    FIRST,
    SECOND,
    RecordRequest,
    Rule,
    compared,
    record_run,
    recorded_rows,
)
from drivegate.studies.diff.document import units_in_the_last_place
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.errors import InputError

RESTARTED = load_scenario("lock-up").replaced(duration_s=1.0, restarts_s=(0.25, 0.6))
SHORT = load_scenario("lock-up").replaced(duration_s=1.0)

CONTROLLERS = """
from drivegate import Command

class Steady:
    def reset(self, nameplate): self.steps = 0
    def step(self, sense):
        self.steps += 1
        return self.answer(sense)
    def answer(self, sense): return Command(5.0 + 1e-3 * sense.phase_currents[2], 0.0)

class Keeping(Steady):
    runs = 0
    def reset(self, nameplate):
        super().reset(nameplate)
        self.runs += 1
    def answer(self, sense): return Command(5.0, 0.61 if self.runs > 1 and self.steps > 12 else 0.58)

class Later(Steady):
    def answer(self, sense):
        reference, angle, power = super().answer(sense)
        return Command(reference + (1e-9 if self.steps > 1200 else 0.0), angle)

class Counting(Steady):
    resets = 0
    def reset(self, nameplate):
        super().reset(nameplate)
        self.resets += 1
    def answer(self, sense):
        reference, angle, power = super().answer(sense)
        return Command(reference + (1e-9 if self.resets > 1 else 0.0), angle)

class Fragile(Later):
    def answer(self, sense):
        if self.steps > 1203: raise ValueError("spent")
        return super().answer(sense)

class Raising(Steady):
    def answer(self, sense):
        if self.steps == 100: raise ValueError("no")
        return super().answer(sense)

class NotFinite(Steady):
    def answer(self, sense): return Command(float("nan") if self.steps == 11 else 0.0, 0.0)

class Zero(Steady):
    def answer(self, sense): return Command(0.0, 0.0)

class NegativeZero(Steady):
    def answer(self, sense): return Command(0.0, -0.0, 1.0)
"""


@pytest.fixture
def candidate(tmp_path):
    file = tmp_path / "controllers.py"
    file.write_text(CONTROLLERS, encoding="utf-8")
    return lambda name: resolve_candidate(f"{file}:{name}")


def compare(first, second, rule=None, before=2, after=1, scenario=SHORT):
    return compared(first, second, scenario, rule or Rule(), before=before, after=after)


def test_a_candidate_is_equal_to_itself(candidate):
    ended = compare(candidate("Steady"), candidate("Steady"))
    assert (ended.steps, ended.difference, ended.fault) == (SHORT.control_periods, None, None)


OF_CURRENTS = """
from drivegate import DutyCommand

class Echo:
    def reset(self, nameplate): self.kind = nameplate.reference_kind
    def step(self, sense): return DutyCommand((0.5, 0.5, 0.5), torque=self.kind, speed=sense.reference)

class Fixed(Echo):
    def step(self, sense): return DutyCommand((0.5, 0.5, 0.5), torque=2.0, speed=sense.reference)
"""


def test_two_candidates_that_follow_a_q_current_get_it_in_place_of_a_torque(tmp_path):
    (tmp_path / "mine.py").write_text(OF_CURRENTS, encoding="utf-8")
    echo, fixed = (
        replace(
            resolve_candidate(f"{tmp_path / 'mine.py'}:{name}"),
            declaration=Declaration(references=("current",)),
        )
        for name in ("Echo", "Fixed")
    )
    held = torque_scenario(load_drive("pm-ac-interior"), 100.0, (1.0,)).replaced(duration_s=0.01)
    for first, second in ((echo, fixed), (fixed, echo)):
        ended = compare(first, second, scenario=held)
        assert (ended.steps, ended.difference, ended.fault) == (held.control_periods, None, None)
    assert compared(echo, fixed, held, Rule(), before=0, after=0, again=True).difference is None


def test_a_candidate_that_follows_a_q_current_is_refused_next_to_one_that_follows_a_torque():
    foc = resolve_candidate("foc")
    following = replace(foc, declaration=Declaration(references=("current",)))
    held = torque_scenario(load_drive("pm-ac-interior"), 100.0, (1.0,))
    with pytest.raises(InputError, match="but the other one gets the torque of the scenario"):
        compare(foc, following, scenario=held)


def test_a_restart_is_one_for_both(candidate):
    """A second candidate that were not reset would go on counting its steps."""
    ended = compare(candidate("Later"), candidate("Later"), scenario=RESTARTED)
    assert (ended.steps, ended.difference, ended.fault) == (RESTARTED.control_periods, None, None)
    apart = compare(candidate("Steady"), candidate("Counting"), scenario=RESTARTED)
    assert apart.difference.step == 500, "the first step after the first restart is the one that differs"
    assert apart.difference.plant["speed"] == apart.difference.rows["sense"]["speed"][2]


def test_the_first_difference_comes_with_inputs_commands_and_plant(candidate):
    ended = compare(candidate("Steady"), candidate("Later"))
    found = ended.difference
    assert ended.steps == found.step == 1200, "the 1201st answer is the first that differs"
    assert found.begin == 1198
    assert len(found.rows) == len(found.answers) == 4
    first, here = found.rows["command"], found.step - found.begin
    for field in ("current_reference", "advance_angle"):
        assert np.array_equal(first[field][:here], found.answers[field][:here])
    references = (rows["current_reference"][here] for rows in (found.answers, first))
    assert np.subtract(*references) == pytest.approx(1e-9, rel=1e-3)
    assert found.rows["sense"]["time"][here] == 0.6
    # Ideal sensors show the plant as it is.
    assert found.plant["speed"] == found.rows["sense"]["speed"][here]
    assert found.plant["phase_currents"] == tuple(found.rows["currents"][here])


def test_an_instance_that_has_run_before_shows_what_reset_keeps(candidate):
    keeping, steady = candidate("Keeping"), candidate("Steady")
    assert compare(keeping, keeping).difference is None, "each instance runs once"
    found = compared(keeping, keeping, SHORT, Rule(), before=0, after=0, again=True).difference
    assert (found.step, found.answers["advance_angle"][0]) == (12, 0.61)
    assert compared(steady, steady, SHORT, Rule(), before=0, after=0, again=True).difference is None


def test_a_tolerance_and_an_ignored_field_let_differences_pass(candidate):
    assert compare(candidate("Steady"), candidate("Later"), Rule(tolerance=1e-8)).difference is None
    zeros = (candidate("Zero"), candidate("NegativeZero"))
    assert compare(*zeros).difference.step == 0
    assert compare(*zeros, Rule(0.0)).difference.step == 0, "one of them makes no estimate of power"
    assert compare(*zeros, Rule(0.0, ("input_power",))).difference is None


def test_a_candidate_that_fails_after_its_difference_still_shows_it(candidate):
    found = compare(candidate("Steady"), candidate("Fragile"), after=10).difference
    assert found.step == 1200
    assert len(found.answers) == 5, "all that it has answered before it fails is there"
    assert len(found.rows) == 13


@pytest.mark.parametrize(
    ("name", "kind", "step"), [("Raising", "exception", 99), ("NotFinite", "invalid output", 10)]
)
def test_a_fault_of_either_is_reported(candidate, name, kind, step):
    first = compare(candidate(name), candidate(name))
    assert (first.faulted, first.fault.kind, first.fault.step, first.steps) == (FIRST, kind, step, step)
    # Both answer alike before, except that NotFinite has an answer of its own.
    second = compare(candidate("Zero" if name == "NotFinite" else "Steady"), candidate(name))
    assert (second.faulted, second.fault.kind, second.fault.step) == (SECOND, kind, step)
    assert second.fault.sense is not None


def test_a_second_candidate_that_is_refused_is_reported_before_the_long_run(candidate):
    long = SHORT.replaced(duration_s=8000.0)
    with pytest.raises(InputError, match="Missing"):
        compare(candidate("Steady"), candidate("Missing"), scenario=long)


@pytest.mark.parametrize(("drive", "sensors"), [("paper-5-phase", "mcs96"), ("star-3-phase", "hall")])
def test_a_record_is_exact_and_the_plant_played_back_is_the_plant(tmp_path, drive, sensors):
    # Encoder, Hall switches and converter show the plant otherwise than it is, and the switches commutate it.
    scenario = SHORT.replaced(drive=load_drive(drive), sensors=sensors)
    path, candidate = tmp_path / "steps", resolve_candidate("reference")
    loaded = JudgedCandidate(candidate, lambda: load_controller(candidate))
    record_run(loaded, RecordRequest(path, scenario))
    columns = run_scenario(scenario, load_controller(candidate), trace_every=1).trace
    rows = recorded_rows(path, scenario)
    assert np.array_equal(rows["sense"]["time"], columns["time_s"])
    assert np.array_equal(np.degrees(1.0) * rows["command"]["advance_angle"], columns["advance_deg"])
    prepare = kind_of(scenario.drive).prepare_loop()
    for step in (0, 1, 1501):
        plant = plant_state(prepare, scenario, rows["command"], step)
        assert plant["speed_rpm"] == columns["speed_rpm"][step], "played back otherwise"
        assert 0.0 <= plant["electrical_angle_deg"] < 360.0
    sense = rows["sense"][1501]
    assert plant["speed"] != sense["speed"], "the encoder shows the speed otherwise than it is"
    assert plant["phase_currents"] == pytest.approx(rows["currents"][1501], abs=1.0)
    turned = scenario.drive.machine.pole_pairs * (math.pi / 30.0) * columns["speed_rpm"][:1501].sum() * 0.0005
    angle = math.radians(plant["electrical_angle_deg"])
    assert math.remainder(angle - turned, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("one", "other", "places"),
    [
        (1.0, 1.0, 0),
        (0.0, -0.0, 0),
        (1.0, math.nextafter(1.0, 2.0), 1),
        (-5e-324, 5e-324, 2),
        (-1.0, math.nextafter(-1.0, -2.0), 1),
        (1.0, 2.0, 2**52),
        (math.nan, 1.0, None),
    ],
)
def test_units_in_the_last_place(one, other, places):
    assert units_in_the_last_place(one, other) == units_in_the_last_place(other, one) == places
