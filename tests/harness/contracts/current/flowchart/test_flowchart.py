"""FLO-1: the flowchart's judge against right searches of many makes, and against wrong ones."""

import math
from dataclasses import replace

import numpy as np
import pytest

from drivegate import Command
from drivegate.candidates.declaration import FlowchartProfile
from drivegate.candidates.fault import CandidateFault, FaultKind
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.margin import GREATEST
from drivegate.containment.judge import own_candidate
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.current.flowchart.judging import judge_script
from drivegate.contracts.current.flowchart.run import ScriptRuns, run_scripts, script_margin, shortened
from drivegate.contracts.current.flowchart.scripts import Event, fixed_scripts, script_of, usual_speed
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.script import Script
from drivegate_models.errors import InputError

DRIVE = load_drive("paper-5-phase")
RPM = math.pi / 30.0
PROFILE = FlowchartProfile(
    speed_tolerance=5.0 * RPM,
    power_tolerance=0.0,
    power_tolerance_fraction=0.001,
    step=math.radians(1.0),
    period=0.005,
)


class Search:
    """Fig. 4 in Python, with each thing that it leaves open, or that can be wrong, as an attribute."""

    k1 = PROFILE.speed_tolerance
    k2 = 0.001
    k2_watts = 0.0
    step_size = math.radians(1.0)
    interval = 10
    direction_at_first = -1.0
    first_decision_after = 10
    takes_mean = True
    one_step_late = False
    multiplies_by_supply = False
    keeps_power_while_off = True
    keeps_power_while_still = False
    limits_offset = False
    first_change = 1.0
    reverses_when_power = "rises"
    forgets_direction_when_still = False
    forgets_direction_while_off = False
    returns_while_off = False
    blur = 0.0
    line_at_base = 33.0
    highest = 0.5 * math.pi

    def reset(self, nameplate):
        self.offset = self.applied = 0.0
        self.direction = self.direction_at_first
        self.old_power = None
        self.sum = 0.0
        self.count = self.interval - self.first_decision_after
        self.samples = 0

    def step(self, sense):
        line = math.radians(self.line_at_base + 0.025 * (sense.speed / RPM - 500.0))
        line = min(line, self.highest) if self.line_at_base else 0.0
        self.count += 1
        self.samples += 1
        self.sum += sense.current_magnitude_sum
        late = self.offset
        if self.count >= self.interval:
            power = self.sum / self.samples if self.takes_mean else sense.current_magnitude_sum
            self.decide(
                power * (sense.half_supply_voltage if self.multiplies_by_supply else 48.0), sense, line
            )
            self.count = self.samples = 0
            self.sum = 0.0
        offset = late if self.one_step_late else self.offset
        self.applied += 1
        wobble = self.blur if self.applied % 7 == 3 and self.offset != 0.0 else 0.0
        return Command(5.0, min(max(line + offset + wobble, 0.0), self.highest))

    def decide(self, power, sense, line):
        old, first = self.old_power, self.old_power is None
        if abs(sense.speed_reference - sense.speed) > self.k1:
            if not self.keeps_power_while_off:
                self.old_power = power
            if self.returns_while_off:
                self.offset = 0.0
            if self.forgets_direction_while_off:
                self.direction = self.direction_at_first
            return
        self.old_power = power
        if first:
            self.move(self.first_change, line)
            return
        change = power - old
        if abs(change) <= self.k2 * power + self.k2_watts:
            if self.keeps_power_while_still:
                self.old_power = old
            if self.forgets_direction_when_still:
                self.direction = self.direction_at_first
            return
        if (change > 0.0) == (self.reverses_when_power == "rises"):
            self.direction = -self.direction
        self.move(1.0, line)

    def move(self, steps, line):
        self.offset += steps * self.direction * self.step_size
        if self.limits_offset:
            self.offset = min(max(self.offset, -line), self.highest - line)


RIGHT = {
    "as published": {},
    "first upward": {"direction_at_first": 1.0},
    "first not at all": {"first_change": 0.0},
    "first in the first step": {"first_decision_after": 1},
    "first after a third of the interval": {"first_decision_after": 3},
    "last sample instead of mean": {"takes_mean": False},
    "one step late": {"one_step_late": True},
    "power instead of sum": {"multiplies_by_supply": True},
    "power of a closed gate taken": {"keeps_power_while_off": False},
    "power kept where it repeats": {"keeps_power_while_still": True},
    "angle limited, not just clamped": {"limits_offset": True},
    "no initial angle": {"line_at_base": 0.0},
    "no initial angle, limited": {"line_at_base": 0.0, "limits_offset": True, "direction_at_first": 1.0},
    "rounding of the angle": {"blur": 0.9e-9},
}
WRONG = {
    "goes on when W rises": {"reverses_when_power": "falls"},
    "never gated": {"k1": math.inf},
    "k1 a little too large": {"k1": PROFILE.speed_tolerance * 1.0002},
    "k1 a little too small": {"k1": PROFILE.speed_tolerance * 0.9998},
    "no k2": {"k2": 0.0},
    "k2 a little too large": {"k2": 0.001 * 1.0002},
    "k2 a little too small": {"k2": 0.001 * 0.9998},
    "step a little too large": {"step_size": math.radians(1.0) + 1.1e-9},
    "step a little too small": {"step_size": math.radians(1.0) - 1.1e-9},
    "first step twice as large": {"first_change": 2.0},
    "decides twice as often": {"interval": 5},
    "decides half as often": {"interval": 20},
    "forgets its direction": {"forgets_direction_when_still": True, "direction_at_first": 1.0},
    "forgets its direction while the speed is off": {"forgets_direction_while_off": True},
    "returns while the speed is off": {"returns_while_off": True},
    "moves between decisions": {"blur": 1.1e-9},
    "stops short of 90°": {"highest": math.radians(85.0)},
}


def controller(**attributes) -> PythonController:
    instance = Search()
    for name, value in attributes.items():
        assert hasattr(instance, name), f"a search has no {name}"
        setattr(instance, name, value)
    return PythonController(instance)


def worst(search: PythonController, profile: FlowchartProfile = PROFILE):
    scripts = fixed_scripts(DRIVE, profile, 1500.0)
    margins = [judge_script(search, profile, script).margin for script in scripts]
    return min(margins, key=lambda margin: margin.value)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("attributes", RIGHT.values(), ids=RIGHT)
def test_whatever_fig_4_leaves_open_may_be_done_either_way(attributes):
    margin = worst(controller(**attributes))
    assert margin.met, margin.measured
    assert margin.value == 1.0


@pytest.mark.one_in(3)
@pytest.mark.parametrize("attributes", WRONG.values(), ids=WRONG)
def test_whatever_is_not_fig_4_fails(attributes):
    margin = worst(controller(**attributes))
    assert not margin.met, "the wrong search is taken for Fig. 4"


@pytest.mark.parametrize("watts", [5.0, 500.0])
def test_k2_as_a_power(watts):
    profile = replace(PROFILE, power_tolerance=watts, power_tolerance_fraction=0.0)
    right = worst(controller(k2=0.0, k2_watts=watts), profile)
    wrong = worst(controller(k2=0.0, k2_watts=1.001 * watts), profile)
    assert right.met, right.measured
    assert not wrong.met


@pytest.mark.parametrize(("fraction", "step"), [(0.0, 1.0), (0.3, 1.0), (0.001, 30.0), (0.001, 90.0)])
def test_unusual_constants(fraction, step):
    profile = replace(PROFILE, power_tolerance_fraction=fraction, step=math.radians(step))
    margin = worst(controller(k2=fraction, step_size=math.radians(step)), profile)
    assert margin.met, margin.measured


def test_a_search_that_never_moves_is_none():
    margin = worst(controller(step_size=0.0))
    assert (
        margin.measured
        == "the angle never changes, though W falls and rises by 3 k2 from decision to decision"
    )
    assert not margin.met


def test_a_departure_is_reported_with_its_decision_and_the_branch():
    script = script_of("two falls", DRIVE, PROFILE, 1500.0, [Event(-3.0), Event(-3.0)])
    verdict = judge_script(controller(reverses_when_power="falls"), PROFILE, script)
    assert verdict.rows == 2
    assert verdict.margin.value == -2.0
    measured = verdict.margin.measured
    assert measured.startswith(
        "row 2, at 0.0145 s: the angle is +0° from the initial one, but Fig. 4 has -2°"
    ), measured
    assert "since W falls from 1920 W by" in measured


def test_a_gate_that_is_closed_is_reported_as_such():
    script = script_of("off", DRIVE, PROFILE, 1500.0, [Event(-3.0, 2.0)])
    measured = judge_script(controller(k1=math.inf), PROFILE, script).margin.measured
    assert "since the speed is off by +10 rpm, more than k1 = 5 rpm" in measured, measured


def test_a_stop_is_reported_as_such():
    script = script_of("still", DRIVE, PROFILE, 1500.0, [Event(-3.0), Event(-0.5)])
    measured = judge_script(controller(k2=0.0), PROFILE, script).margin.measured
    assert "no more than k2 = 1.9" in measured, measured


@pytest.mark.parametrize("angle", [1.7e308, -1.7e308])
@pytest.mark.filterwarnings("error")
def test_an_extreme_angle_departs(angle):
    class Jumping:
        def reset(self, nameplate):
            self.count = 0

        def step(self, sense):
            self.count += 1
            return Command(
                3.0, math.copysign(angle, sense.speed - sense.speed_reference + self.count % 7 - 3.0)
            )

    script = fixed_scripts(DRIVE, PROFILE, usual_speed(DRIVE, None))[0]
    margin = judge_script(PythonController(Jumping()), PROFILE, script).margin
    assert -GREATEST <= margin.value < 0.0, margin


def test_a_change_between_decisions_is_reported_as_such():
    script = script_of("fall", DRIVE, PROFILE, 1500.0, [Event(-3.0)])
    measured = judge_script(controller(interval=5), PROFILE, script).margin.measured
    assert "the angle changes before the next one is due" in measured, measured


def test_a_failing_script_is_made_as_short_as_can_be():
    scripts = {script.name: script for script in fixed_scripts(DRIVE, PROFILE, 1500.0)}
    broken = controller(k1=math.inf)
    short = shortened(broken, PROFILE, scripts["gate"])
    assert short.name == "gate-shortened"
    assert len(short.rows) == 2, short.rows
    assert not judge_script(broken, PROFILE, short).margin.met
    assert [row.current_sum_a for row in short.rows] == [round(row.current_sum_a, 1) for row in short.rows]


def test_a_period_that_the_script_cannot_have_is_refused():
    script = script_of("fall", DRIVE, PROFILE, 1500.0, [Event(-3.0)])
    with pytest.raises(InputError, match=r"has a period of 0\.0123 s, which must be a whole number of them"):
        judge_script(controller(), replace(PROFILE, period=0.0123), script)


def test_scripts_have_control_periods_that_divide_the_search_period():
    for period in (0.1, 0.0123, 0.0004, 0.0005):
        script = script_of("fall", DRIVE, replace(PROFILE, period=period), 1500.0, [Event(-3.0)])
        steps = period / script.control_period_s
        assert script.control_period_s <= 0.0005
        assert steps == pytest.approx(round(steps), rel=1e-12)


def test_fixed_scripts_keep_to_the_declared_speeds():
    assert usual_speed(DRIVE, None) == 1500.0
    assert usual_speed(DRIVE, (600.0, 900.0)) == 900.0
    assert usual_speed(DRIVE, (1600.0, 1900.0)) == 1600.0
    assert usual_speed(DRIVE, (0.0, 510.0)) is None


class Failing(Search):
    """A search whose second decision breaks something."""

    answer = None

    def decide(self, power, sense, line):
        if self.old_power is not None:
            if self.answer is None:
                raise ZeroDivisionError("no W")
            self.offset = self.answer
        super().decide(power, sense, line)


def test_an_exception_inside_a_script_is_the_candidates_fault():
    with pytest.raises(CandidateFault) as raised:
        worst(PythonController(Failing()))
    assert raised.value.fault.kind is FaultKind.EXCEPTION
    assert raised.value.fault.message == "ZeroDivisionError: no W"


def test_a_command_that_is_not_finite_is_the_candidates_fault():
    broken = Failing()
    broken.answer = math.nan
    broken.blur = math.nan
    with pytest.raises(CandidateFault) as raised:
        worst(PythonController(broken))
    assert raised.value.fault.kind is FaultKind.INVALID_OUTPUT


def loaded(name: str) -> JudgedCandidate:
    return own_candidate(resolve_candidate(name))


@pytest.fixture(scope="module")
def published():
    return run_scripts(loaded("published"), ScriptRuns(DRIVE, seed=0, examples=10))


def test_the_published_controller_follows_its_flowchart(published):
    assert len(published.runs) > len(fixed_scripts(DRIVE, PROFILE, 1500.0)), "no script was drawn"
    for run in published.runs:
        assert [margin.check for margin in run.margins] == ["FLO-1"]
        assert run.margins[0].met, run.margins[0].measured
        assert run.scenario["kind"] == "script"


def test_the_same_seed_draws_the_same_scripts(published):
    again = run_scripts(loaded("published"), ScriptRuns(DRIVE, seed=0, examples=10))
    other = run_scripts(loaded("published"), ScriptRuns(DRIVE, seed=1, examples=10))
    assert again == published
    assert other != published


def test_a_candidate_without_the_profile_is_not_scripted():
    assert run_scripts(loaded("reference"), ScriptRuns(DRIVE, 0, 2)).runs == ()
    script = script_of("fall", DRIVE, PROFILE, 1500.0, [Event(-3.0)])
    assert script_margin(loaded("reference"), script) is None


def test_the_shortest_failing_script_comes_last():
    candidate = resolve_candidate("published")
    flowchart = candidate.declaration.flowchart
    assert flowchart is not None
    declaration = replace(candidate.declaration, flowchart=replace(flowchart, step=math.radians(2.0)))
    wrong = own_candidate(replace(candidate, declaration=declaration))
    runs = run_scripts(wrong, ScriptRuns(DRIVE, 0, 0)).runs
    assert not any(run.margins[0].met for run in runs)
    assert runs[-1].scenario["name"].endswith("-shortened")
    assert len(runs[-1].scenario["rows"]) == 1
    again = parse_document(runs[-1].scenario, Script, "a counterexample")
    assert script_margin(wrong, again) == runs[-1].margins[0]


def test_rows_are_as_far_from_the_limits_as_requested():
    script = script_of("edges", DRIVE, PROFILE, 1500.0, [Event(-1.0), Event(1.0), Event(0.0, 1.0)])
    sums = np.array([row.current_sum_a for row in script.rows])
    assert np.abs(np.diff(sums))[:2] / sums[1:3] == pytest.approx([0.001, 0.001], rel=1e-6)
    assert script.rows[3].speed_reference_rpm - script.rows[3].speed_rpm == 5.0
