"""A friction that grows during a run: what it does to the shaft, and what is fair about it."""

from __future__ import annotations

from typing import Any

import pytest

from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.current.scenarios.building import plain_scenario
from drivegate.contracts.current.scenarios.simplification import SIMPLIFICATIONS
from drivegate.contracts.duty.scenarios.building import speed_scenario, torque_of
from drivegate.scenarios.facts import facts_of
from drivegate.scenarios.simplification import simplified, size_of
from drivegate.scenarios.title import titled
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.circumstance import Circumstance, circumstance
from drivegate_cases.scenario.profile import dwells
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

DRIVES = ("paper-5-phase", "star-24v-3-phase", "pm-ac-interior")


def plain(name: str, share: float = 0.5) -> Scenario:
    """Return a run at base speed under a share of the torque of rated power, twice as long as it has to be."""
    drive = load_drive(name)
    speed = drive.rating.base_speed_rpm
    if isinstance(drive, PmAcDocument):
        run = speed_scenario(drive, (speed,), torque_nm=torque_of(drive, speed, share))
    else:
        run = plain_scenario(drive)
        load = run.load.model_copy(update={"torque_nm": share * run.load.torque_at(0.0)})
        run = run.replaced(load=load)
    return run.replaced(duration_s=2.0 * run.duration_s)


def dragging(run: Scenario, share: float) -> Scenario:
    """Add a share of the load's torque to the friction, from half of the run on."""
    at, torque = 0.5 * run.duration_s, share * run.load.torque_at(run.speed_rpm[0][1], 1.0)  # type: ignore[union-attr]
    return titled(run.replaced(drift={"friction_n_m": ((0.0, 0.0), (at, 0.0), (at, torque))}))


@pytest.mark.parametrize("name", DRIVES)
def test_it_ends_a_stretch_and_is_reported(name: str) -> None:
    run = dragging(plain(name), 0.1)
    torque = run.drift.friction_n_m[-1][1] if run.drift and run.drift.friction_n_m else 0.0
    added = [dwell.scales.friction_added_n_m for dwell in dwells(run)]
    assert added[-1] == torque > 0.0 == added[0]
    assert any(fact.startswith("friction changes by 0 → ") for fact in facts_of(run.to_mapping()))
    assert "friction-changes+0-" in run.name
    assert circumstance(run) is Circumstance.FAULTS


@pytest.mark.parametrize("name", DRIVES)
def test_it_is_fair_as_far_as_a_load_of_the_same_torque_is(name: str) -> None:
    run = plain(name)
    unfair = contract_of(run.drive).unfair_because
    assert unfair(run) is None
    assert unfair(dragging(run, 0.1)) is None
    assert unfair(dragging(run, 9.0)) is not None, "no drive has nine times its rated torque"


def test_a_step_of_it_throws_a_fast_shaft_like_a_step_of_the_load() -> None:
    run = plain("pm-ac-interior")
    slow = 0.02 * run.drive.rating.base_speed_rpm
    creeping = run.replaced(speed_rpm=((0.0, slow),), initial_speed_rpm=slow)
    idle = creeping.replaced(load=run.load.model_copy(update={"torque_nm": 0.0}))
    unfair = contract_of(run.drive).unfair_because
    assert unfair(idle) is None
    at = 0.5 * idle.duration_s
    friction = ((0.0, 0.0), (at, 0.0), (at, 0.5 * run.load.torque_at(slow)))  # type: ignore[union-attr]
    assert "stops the shaft" in str(unfair(idle.replaced(drift={"friction_n_m": friction})))


def test_a_shaft_without_a_load_must_be_able_to_bear_it() -> None:
    run = plain("paper-5-phase").replaced(duration_s=20.0)
    idle = run.replaced(load=run.load.model_copy(update={"factor": ((0.0, 0.0),)}))
    unfair = contract_of(run.drive).unfair_because
    assert unfair(idle) is None
    beyond: dict[str, Any] = {"friction_n_m": ((0.0, 0.0), (5.0, 0.0), (15.0, 100.0))}
    assert unfair(idle.replaced(drift=beyond)) is not None


def test_it_is_left_out_or_made_rounder() -> None:
    run = plain("paper-5-phase")
    run = run.replaced(drift={"friction_n_m": ((0.0, 0.0), (3.0, 0.0), (3.0, 0.1234567))})
    fields = (fields for simplification in SIMPLIFICATIONS for fields in simplification(run))
    simpler = [found for changed in fields if (found := simplified(run, changed)) is not None]
    assert all(size_of(found.to_mapping()) < size_of(run.to_mapping()) for found in simpler)
    left = [found.drift for found in simpler]
    assert None in left
    shorter = [drift.friction_n_m[-1][1] for drift in left if drift is not None and drift.friction_n_m]
    assert any(0.0 < torque != 0.1234567 for torque in shorter), shorter


@pytest.mark.parametrize(
    ("friction", "sentence"),
    [
        ([[0.0, -1.0]], r"the key 'drift.friction_n_m' is .*, but must have torques from 0 to 1e\+10 N·m"),
        (
            [[0.0, 0.0], [1e4, 2.0]],
            "the key 'drift.friction_n_m' has a point at 10000.0 s, but must end within",
        ),
    ],
)
def test_a_course_that_cannot_be_is_refused_in_a_sentence(friction: list[list[float]], sentence: str) -> None:
    given = plain("paper-5-phase").to_mapping() | {"drift": {"friction_n_m": friction}}
    with pytest.raises(InputError, match=sentence):
        parse_document(given, Scenario, "dragging.toml")
