"""Runs above the highest speed, shafts that come free, and turns before a run: what they are, and what is fair."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.harness.contracts.key_effects import plain, seen

from drivegate.candidates.python.bridge import PythonController
from drivegate.contracts.duty.plant_run import MOST_PERIODS_OF_SLOW, duty_run, turned_before
from drivegate.contracts.duty.scenarios.beyond import (
    backward_beyond_scenarios,
    beyond_scenarios,
    speed_beyond,
)
from drivegate.contracts.duty.scenarios.drawn_range import speed_of
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios, long_scenarios, turned_scenario
from drivegate.contracts.duty.scenarios.released import (
    free_shaft_scenarios,
    released_scenario,
    stalled_scenario,
)
from drivegate.contracts.duty.scenarios.windows import duty_windows, released_windows
from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.scenarios.rotation import mirrored
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.courses import Drift
from drivegate_cases.scenario.profile import released_s
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.duty.signals import DutyCommand, DutySense
from drivegate_models.errors import InputError

DRIVE = load_drive("pm-ac-interior")
assert isinstance(DRIVE, PmAcDocument)
BASE, HIGHEST, OVERSPEED = (
    DRIVE.rating.base_speed_rpm,
    DRIVE.rating.highest_speed_rpm,
    DRIVE.rating.overspeed_rpm,
)
HELD = {"kind": "dynamometer", "torque_reference_nm": [[0.0, 1.0]]}


def test_fixed_runs_brake_from_the_highest_speed_to_the_last_stretch_below_overspeed() -> None:
    fixed = fixed_scenarios(DRIVE)
    made = [*beyond_scenarios(DRIVE), *backward_beyond_scenarios(DRIVE)]
    assert set(made) <= set(fixed)
    speeds = sorted(abs(run.speed_rpm[0][1]) for run in made)
    assert HIGHEST < speeds[0] < speeds[-1] < OVERSPEED
    assert (OVERSPEED - speeds[-1]) / (OVERSPEED - HIGHEST) == pytest.approx(0.02, abs=1e-3)
    for run in made[:2]:
        sense = math.copysign(1.0, run.speed_rpm[0][1])
        torques = [sense * torque for _, torque in run.torque_reference_profile]
        assert min(torques) < 0.0 == max(torques), "torques there brake, or are zero"
    assert not {run.name for run in fixed_scenarios(DRIVE, reverses=False)} & {run.name for run in made[1:]}
    assert speed_beyond(DRIVE, 1.0) == OVERSPEED


RELEASED = [*free_shaft_scenarios(DRIVE)[:2], released_scenario(DRIVE, 0.9 * BASE, 0.2 * BASE)]


@pytest.mark.parametrize("run", RELEASED, ids=lambda run: run.name)
def test_a_released_shaft_is_turned_by_the_torque_that_was_held(run: Scenario) -> None:
    released = released_s(run)
    assert released is not None
    (held,), (free,) = duty_windows(run), released_windows(run)
    assert held[2] == released
    assert released < free[1] < free[2] == run.duration_s
    (_, torque), *others = run.torque_reference_profile
    assert not others, "the reference stays"
    way = torque * (run.duration_s - released) / DRIVE.machine.inertia_kg_m2 * 30.0 / math.pi
    assert abs(way) > 0.5 * BASE, "the speed changes by much"
    assert 0.0 <= run.speed_rpm[0][1] + way < HIGHEST
    assert unfair_because(run) is None


class _Pushing:
    """Applies a voltage that turns with the rotor, whatever else it senses."""

    def reset(self, nameplate: Any) -> None:
        self.pairs = nameplate.pole_pairs

    def step(self, sense: DutySense) -> DutyCommand:
        angle = self.pairs * sense.angle + 0.5 * math.pi
        first, second, third = (
            0.5 + 0.02 * math.cos(angle - turn * 2.0 * math.pi / 3.0) for turn in range(3)
        )
        return DutyCommand((first, second, third))


def test_the_machine_alone_moves_a_shaft_that_is_released() -> None:
    """The impulse of its torque is what the shaft has gained: Newton's law, from the trace alone."""
    mapping = plain("pm-ac") | {
        "speed_rpm": [[0.0, 0.0]],
        "initial_speed_rpm": 0.0,
        "load": HELD | {"released_s": 0.01},
    }
    scenario = parse_document(mapping, Scenario, "case")
    run = duty_run(DRIVE_KINDS["pm-ac"].prepare_loop(), scenario, PythonController(_Pushing()))
    speed, torque = run.column("speed"), run.column("torque")
    begin = round(0.01 / scenario.control_period_s)
    assert not speed[: begin + 1].any(), "it is held until then"
    inertia = scenario.drive.machine.inertia_kg_m2  # type: ignore[attr-defined]
    gained = np.cumsum(torque[begin:-1]) * scenario.control_period_s / inertia
    assert speed[-1] > 0.1
    assert speed[begin + 1 :] == pytest.approx(gained, rel=1e-9, abs=1e-12)
    assert float(run.shaft[11]) == 0.0, "the ledger of the shaft begins with its release"


@pytest.mark.parametrize(
    ("changes", "reported"),
    [
        (
            {"load": HELD | {"released_s": 0.02}},
            "the key 'load.released_s' is 0.02, but the run ends at 0.02 s",
        ),
        (
            {"load": HELD | {"released_s": 0.01}, "speed_rpm": [[0.0, 300.0], [0.015, 400.0]]},
            "'speed_rpm' goes on to 0.015 s",
        ),
        ({"turns_before": -3}, "the key 'turns_before' is -3, but the shaft turns at 300 rpm"),
        ({"turns_before": 3, "initial_speed_rpm": 0.0}, "the shaft turns at 0 rpm"),
    ],
)
def test_what_no_shaft_can_do_is_refused(changes: dict[str, Any], reported: str) -> None:
    with pytest.raises(InputError) as refused:
        parse_document(plain("pm-ac") | changes, Scenario, "case")
    assert reported in str(refused.value)


def test_a_shaft_that_runs_away_is_set_aside() -> None:
    fair = released_scenario(DRIVE, 0.5 * BASE, 0.9 * HIGHEST)
    load = fair.load.model_copy(
        update={"torque_reference_nm": ((0.0, 1.2 * fair.torque_reference_profile[0][1]),)}
    )
    assert unfair_because(fair) is None
    assert "beyond the highest speed" in str(unfair_because(fair.replaced(load=load)))
    heavier = fair.replaced(load=load, drift=Drift(inertia=((0.0, 1.3),)))
    assert unfair_because(heavier) is None, "a heavier shaft does not get that far"
    assert unfair_because(mirrored(fair)) is None


def test_a_shaft_is_stalled_at_first_and_then_comes_free() -> None:
    run = stalled_scenario(DRIVE, 0.3 * BASE, 0.3)
    assert unfair_because(run) is None
    assert run.initial_speed_rpm == 0.0
    turning = run.replaced(initial_speed_rpm=0.3 * BASE)
    assert "no currents within the limits" in str(unfair_because(turning)), "friction would stop it"


@pytest.mark.parametrize("sensors", ["ideal", "encoder", "hall", "exact"])
def test_turns_before_a_run_are_seen_and_change_nothing_of_it(sensors: str) -> None:
    seen_by = {} if sensors == "ideal" else {"sensors": {"kind": "shunts", "position": sensors}}
    # As many control periods as its answers repeat in.
    speed, turns = 3000.0, 30
    mapping = plain("pm-ac") | seen_by | {"speed_rpm": [[0.0, speed]], "initial_speed_rpm": speed}
    without, after = (
        seen(parse_document(mapping | {"turns_before": count}, Scenario, "case")) for count in (0, turns)
    )
    before = len(after.senses) - len(without.senses)
    period = parse_document(mapping, Scenario, "case").control_period_s
    assert before == round(turns / (speed / 60.0 * period))
    assert after.plant == without.plant, "the plant is the same, bit for bit"
    later = [sense._replace(time=0.0) for sense in after.senses[before:]]
    assert later == [sense._replace(time=0.0) for sense in without.senses]
    angles = np.unwrap([sense.angle for sense in after.senses[: before + 1]])
    edge = math.radians(60.0) / 2 if sensors == "hall" else 0.01
    assert (angles[-1] - angles[0]) / (2.0 * math.pi) == pytest.approx(turns, abs=edge)
    times = np.diff([sense.time for sense in after.senses])
    assert times == pytest.approx(np.full(len(times), period), rel=1e-6), "the clock goes on through it"
    if sensors == "ideal":
        currents = np.array([sense.phase_currents for sense in after.senses[:before]])
        assert not currents[:2].any(), "the bridge is off until the first command acts"
        assert currents.any(axis=1)[2:].all(), "and the currents follow the commands then"
        assert currents.sum(axis=1) == pytest.approx(0.0, abs=1e-12)


def test_a_slow_controller_sees_the_last_turns_alone_and_a_fast_one_all() -> None:
    *_, million = long_scenarios(DRIVE)
    assert million.turns_before == 1_000_000
    assert all(run.turns_before == 0 for run in long_scenarios(DRIVE, ("speed",)))
    turning = turned_before(million, PythonController(_Pushing()))
    assert turning is not None
    assert 0.99 * MOST_PERIODS_OF_SLOW < turning.periods <= MOST_PERIODS_OF_SLOW
    short = turned_scenario(DRIVE)
    assert short in fixed_scenarios(DRIVE)
    (_, torque) = short.torque_reference_profile[0]
    assert torque == 0.0, "no current flows before the run, and none is asked for at first"
    back = mirrored(short)
    assert back.turns_before == -short.turns_before
    turned = turned_before(back, PythonController(_Pushing()))
    assert turned is not None
    assert turned.speed < 0.0


def test_turns_before_a_run_are_slower_than_the_diodes_conduct() -> None:
    """On this drive they conduct at half of the range above base speed; the turns would show no current of them."""
    drive = load_drive("pm-ac-2kw")
    assert isinstance(drive, PmAcDocument)
    run = turned_scenario(drive)
    assert unfair_because(run) is None
    assert run.initial_speed_rpm == drive.rating.base_speed_rpm
    fast = speed_of(drive, 0.5)
    beyond = run.replaced(speed_rpm=((0.0, fast),), initial_speed_rpm=fast)
    assert "a current of the diodes" in str(unfair_because(beyond))
    assert unfair_because(beyond.replaced(turns_before=0)) is None
