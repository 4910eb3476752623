"""Faulty controllers of duty ratios are caught by the checks that are named for them."""

from __future__ import annotations

from functools import cache

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.scenarios.building import (
    failing,
    hoist_scenario,
    lifted_scenario,
    load_step_scenario,
    most_false_edges,
    restarted,
    speed_scenario,
    supply_step_scenario,
    torque_of,
    torque_scenario,
    vanishing_load_scenario,
    with_edges,
    with_false_edges,
    with_lost_samples,
    with_position_errors,
)
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.released import released_scenario
from drivegate.drives.running import recorded
from drivegate.gate.engine import check_candidate
from drivegate.gate.events import CheckFinished
from drivegate.gate.focus import Focus
from drivegate.gate.options import CheckOptions
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate.scenarios.facts import facts_of
from drivegate.scenarios.rotation import mirrored
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS
from drivegate_reports.conformance.report import page

INTERIOR = load_drive("pm-ac-interior").replaced(settling_s=0.3)
BY_HALL = INTERIOR.with_overrides(["sensing.position=hall"])
CONTRACT = contract_of(INTERIOR)


def revealing_runs(drive: DriveDocument = INTERIOR) -> tuple[Scenario, ...]:
    """Give runs that show every fault: great and small torque steps, weakening and its end, a free shaft, failures."""
    assert isinstance(drive, PmAcDocument)
    below, top = 1200.0, drive.rating.highest_speed_rpm
    levels = [torque_of(drive, below, share) for share in (0.0, 0.5, 0.3, 0.15)]
    return (
        torque_scenario(drive, below, levels),
        torque_scenario(drive, top, (0.0, torque_of(drive, top, 3.0), 0.0)),
        speed_scenario(drive, (1200.0, 2000.0), torque_nm=1.0),
        torque_scenario(drive, 0.08 * drive.rating.base_speed_rpm, levels[1:3]),
        failing(torque_scenario(drive, below, levels[1:2]), "stuck-current", 0.25),
        failing(speed_scenario(drive, (below,), initial_speed_rpm=0.0), "locked-rotor", 0.0),
        failing(with_edges(torque_scenario(drive, below, levels[1:2]), "hall", 1), "lost-edge", 0.25),
    )


def rare_families() -> dict[str, dict[str, Scenario]]:
    """Give what few firmwares are tried in, and for each the faults that show in it alone, with a run of each."""
    assert isinstance(INTERIOR, PmAcDocument)
    base, highest = INTERIOR.rating.base_speed_rpm, INTERIOR.rating.highest_speed_rpm
    rated = torque_of(INTERIOR, base, 1.0)
    light = speed_scenario(INTERIOR, (0.5 * base, 0.55 * base), torque_nm=0.3 * rated, inertia_factor=0.3)
    lifted = lifted_scenario(INTERIOR, base, 0.7 * rated, (2.0, 0.3), initial_speed_rpm=0.4 * base)
    held = torque_scenario(INTERIOR, 0.5 * base, (0.5 * rated,))
    turning = load_step_scenario(INTERIOR, base, 0.5 * rated, (1.0, 0.8))
    slipping = failing(held, "slip", 0.5 * held.duration_s, slip_deg=60.0)
    swelling = supply_step_scenario(torque_scenario(INTERIOR, base, (-0.5 * rated,)), INTERIOR, (1.0, 1.15))
    vanishing = vanishing_load_scenario(INTERIOR, 0.95 * base, 0.5 * rated, 1000 * INTERIOR.control_period_s)
    idle = vanishing_load_scenario(INTERIOR, 0.95 * base, 0.5 * rated, 0.5)
    beyond = speed_scenario(INTERIOR, (1.02 * highest, 1.08 * highest), torque_nm=0.1 * rated)
    start = speed_scenario(
        INTERIOR, (0.2 * base,), torque_nm=0.5 * rated, initial_speed_rpm=0.0, initial_angle_deg=90.0
    )
    stepping = torque_scenario(INTERIOR, 0.5 * base, (0.2 * rated, 0.8 * rated))
    sagging = supply_step_scenario(stepping, INTERIOR, (1.0, 0.85))
    false_edges = with_false_edges(held, most_false_edges(INTERIOR), 0.1, 1)
    return {
        "braking": {
            "weak-braking": torque_scenario(INTERIOR, base, (0.0, -rated)),
            "braking-reserve": torque_scenario(INTERIOR, 1.9 * base, (-0.3 * rated,)),
        },
        "link steps while braking": {"braking-cut-off": swelling, "overvoltage-ends-braking": swelling},
        "low speed": {
            "slow-shaft-unseen": speed_scenario(INTERIOR, (0.5 * base, 0.0, 0.03 * base)),
            "idle-speed-forced": load_step_scenario(INTERIOR, 0.01 * base, 0.02 * rated, (0.0, 1.0)),
        },
        "inertia": {
            "heavy-rotor-assumed": light,
            "lift-taken-for-broken-coupling": lifted,
        },
        "backward": {
            "backward-refused": speed_scenario(INTERIOR, (0.3 * base, -0.3 * base), torque_nm=0.3 * rated),
            "one-way-prediction": mirrored(torque_scenario(INTERIOR, 1.5 * base, (0.5 * rated,))),
            "lowering-refused": hoist_scenario(INTERIOR, (0.5 * base, -0.5 * base), 0.6 * rated),
        },
        "load that vanishes": {"weakening-kept-near-base": vanishing, "offsets-after-idling": idle},
        "above the highest speed": {"reference-clipped": beyond, "speed-clipped": beyond},
        "braking above the highest speed": {
            "braking-ends-at-highest-speed": torque_scenario(INTERIOR, 1.05 * highest, (-0.2 * rated,)),
            "overspeed-taken-early": torque_scenario(INTERIOR, 1.098 * highest, (-0.1 * rated,)),
        },
        "shaft that comes free": {
            "speed-taken-for-constant": released_scenario(INTERIOR, 0.6 * base, 0.95 * highest),
            "torque-ramped-after-stall": released_scenario(INTERIOR, 0.0, 0.5 * base),
        },
        "turns before the run": dict.fromkeys(
            ("turns-summed-in-single-precision", "edges-summed-in-single-precision"),
            torque_scenario(INTERIOR, base, (0.0, 0.6 * rated)).replaced(turns_before=10_000),
        ),
        "start": {"start-angle-assumed": start, "impatient-stall-watch": start},
        "restart": {
            "offsets-under-current": restarted(held, (0.5,)),
            "microseconds-signed": restarted(held, (), 2147.4),
        },
        "lost sample": {
            "undervoltage-at-once": with_lost_samples(held, ("supply",), (0.1,)),
            "lost-currents-trip": with_lost_samples(held, ("currents",), (0.1,)),
        },
        "two changes at once": {
            "reference-missed-with-link": sagging,
            "sag-taken-for-short-circuit": sagging,
            "reference-missed-with-sample": with_lost_samples(stepping, ("currents",), (0.5,)),
        },
        "false edge": {"false-edges-trip": false_edges, "phase-after-false-edges": false_edges},
        "position error": {
            "swinging-speed-trips": with_position_errors(turning, 1, track_gain=0.026, track_phase_deg=1.5),
            "swings-damped-one-way": with_position_errors(held, 1, eccentricity_deg=1.5, sine_offset=0.026),
        },
        "slip": {"jump-of-angle-believed": slipping, "jumps-of-angle-smoothed": slipping},
    }


def rarer_runs() -> dict[str, Scenario]:
    """Give the run of each of these faults."""
    return {name: run for runs in rare_families().values() for name, run in runs.items()}


@cache
def failed_checks(name: str, runs: tuple[Scenario, ...]) -> frozenset[str]:
    """Run a candidate and return the checks that it fails."""
    loaded = own_candidate(resolve_candidate(name))
    controller = loaded.controller()
    margins = [
        margin
        for scenario in runs
        for margin in judged(recorded(loaded, scenario, controller), CONTRACT.checks).margins
    ]
    return frozenset(margin.check for margin in margins if not margin.met)


def is_caught(name: str, runs: tuple[Scenario, ...]) -> bool:
    """Return True if a faulty controller fails its check in one of the runs; those after that one are not made."""
    loaded = own_candidate(resolve_candidate(f"faulty:{name}"))
    controller = loaded.controller()
    (check,) = (check for check in CONTRACT.checks if check.id == DUTY_FAULTS[name].check)
    margins = (check.evaluate(recorded(loaded, scenario, controller)) for scenario in runs)
    return any(margin is not None and not margin.met for margin in margins)


def repeated_runs() -> dict[str, Scenario]:
    """Give each fault that outlives a reset the run whose repetition shows it."""
    assert isinstance(INTERIOR, PmAcDocument)
    held = torque_scenario(INTERIOR, 1200.0, (torque_of(INTERIOR, 1200.0, 0.5),))
    return {
        "failure-survives-reset": failing(held, "stuck-current", 0.25),
        "lost-samples-add-up": with_lost_samples(held, ("currents",), (0.1,)),
    }


def shown_on_any_drive() -> list[str]:
    """List the faults of common operation; those that idle here need a link or a sensor of another drive."""
    rarer = rarer_runs() | repeated_runs()
    faults = DUTY_FAULTS.items()
    return [name for name, fault in faults if name not in rarer and not fault.on(INTERIOR).idle_because]


def test_faults_that_idle_here_are_those_of_link_and_heat_with_tests_of_their_own() -> None:
    idle = {name for name, fault in DUTY_FAULTS.items() if fault.on(INTERIOR).idle_because}
    assert idle == {name for name, fault in DUTY_FAULTS.items() if fault.check.startswith(("LNK-", "THM-"))}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", shown_on_any_drive())
def test_a_faulty_controller_is_caught_by_its_check(name: str) -> None:
    assert is_caught(name, revealing_runs())


@pytest.mark.parametrize(("name", "check"), [("shallow-weakening", "FWK-1"), ("angle-offset", "FWK-2")])
def test_a_faulty_controller_is_caught_by_its_check_on_a_machine_without_saliency(
    name: str, check: str
) -> None:
    drive = load_drive("pm-ac-surface").replaced(settling_s=0.3)
    assert check in failed_checks(f"faulty:{name}", revealing_runs(drive)[1:2])


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", rarer_runs())
def test_a_fault_of_a_rarer_operation_is_caught_there_alone(name: str) -> None:
    run = rarer_runs()[name]
    assert unfair_because(run) is None
    assert failed_checks("foc", (run,)) == frozenset()
    assert failed_checks(f"faulty:{name}", revealing_runs()) == failed_checks("foc", revealing_runs())
    assert DUTY_FAULTS[name].check in failed_checks(f"faulty:{name}", (run,))


def differs_again(name: str, run: Scenario) -> bool:
    """Run a candidate through a scenario repeatedly and return whether `DET-1` fails it, and nothing else does."""
    outcome = run_fixed(own_candidate(resolve_candidate(name)), FixedRuns((run,), repeat=True))
    failed = {margin.check for margin in outcome.runs[0].margins if not margin.met}
    assert failed <= {"DET-1"}
    return bool(failed)


@pytest.mark.parametrize("name", repeated_runs())
def test_a_fault_that_outlives_a_reset_is_caught_where_its_trouble_is_repeated_alone(name: str) -> None:
    run, plain = repeated_runs()[name], revealing_runs()[2]
    assert not differs_again("foc", run)
    assert not differs_again(f"faulty:{name}", plain)
    assert differs_again(f"faulty:{name}", run)


def test_each_rarer_operation_has_two_faults_that_it_alone_shows() -> None:
    assert {family: len(runs) for family, runs in rare_families().items() if len(runs) < 2} == {}


@pytest.mark.parametrize(
    "name", ["swapped-axes", "angle-offset", "no-speed-integral", "patient-stall-watch", "hall-edges-counted"]
)
def test_a_faulty_controller_is_caught_through_hall_switches_alone(name: str) -> None:
    assert is_caught(name, revealing_runs(BY_HALL))


@pytest.mark.nightly
def test_a_fault_is_made_simple_recorded_and_reported_on_the_page() -> None:
    focus = Focus(only=("FWK-2",), stop_at_first=True)
    events = check_candidate(
        resolve_candidate("faulty:stuck-weakening"),
        CheckOptions(drive=INTERIOR, effort="quick", workers=1, focus=focus),
    )
    finished = next(event for event in events if isinstance(event, CheckFinished))
    document = finished.result.written()
    (failed,) = document["checks"]
    assert (failed["id"], failed["verdict"], document["exit_code"]) == ("FWK-2", "fail", 1)
    assert len(facts_of(failed["counterexample"])) <= 3
    assert {"direct_current_a", "voltage_v"} <= set(document["traces"][failed["recording"]["trace"]])
    assert document["envelope"] is None
    assert document["behaviour"] is None, "a check that was confined shows nothing beside it"
    text = page(document)
    assert "Run " in text
    assert "along the magnet" in text, "the account of the run is reported"
