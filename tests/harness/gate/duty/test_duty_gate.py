"""The gate of a controller of duty ratios: faults are caught, made simple, recorded, and reported on the page."""

from __future__ import annotations

from dataclasses import replace

import pytest

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import Judge, own_candidate
from drivegate.containment.messages import Job
from drivegate.contracts.catalogue import contract_named, contract_of
from drivegate.contracts.duty.scenarios.building import (
    failing,
    speed_scenario,
    torque_of,
    torque_scenario,
    with_edges,
)
from drivegate.drives.abilities import refuse_unreachable
from drivegate.drives.running import recorded
from drivegate.gate.engine import check_candidate
from drivegate.gate.events import CheckFinished
from drivegate.gate.focus import Focus
from drivegate.gate.options import CheckOptions
from drivegate.gate.plan import time_steps
from drivegate.gate.recording import behaviour_job
from drivegate.gate.shard import DrawnRuns, FixedRuns, run_drawn, run_fixed
from drivegate.results.verdict import check_outcomes
from drivegate.scenarios.changes import with_scales
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.failure_kind import FailureKind
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

INTERIOR = load_drive("pm-ac-interior").replaced(settling_s=0.3)
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


@pytest.mark.nightly
def test_a_quick_check_on_a_drive_with_hall_switches_alone_is_passed() -> None:
    drive = load_drive("pm-ac-interior").with_overrides(["sensing.position=hall"])
    events = list(
        check_candidate(
            resolve_candidate("foc"),
            CheckOptions(
                drive=drive,
                effort="quick",
                workers=1,
                search=False,
                focus=Focus(only=("STA-1", "SAF-1")),
            ),
        )
    )
    assert isinstance(events[-1], CheckFinished)
    result = events[-1].result
    assert {outcome.id: outcome.verdict for outcome in result.checks} == {"STA-1": "pass", "SAF-1": "pass"}


@pytest.mark.parametrize("share", [0.2, 0.35, 0.6])
@pytest.mark.parametrize(
    ("kind", "reference"),
    [("lost-position", "speed"), ("lost-position", "torque"), ("locked-rotor", "speed")],
)
def test_what_stops_the_edges_is_noticed_through_hall_switches_alone(
    kind: FailureKind, reference: str, share: float
) -> None:
    drive = load_drive("pm-ac-interior").with_overrides(["sensing.position=hall"])
    assert isinstance(drive, PmAcDocument)
    speed = share * drive.rating.base_speed_rpm
    torque = torque_of(drive, speed, 0.45)
    plain = (
        torque_scenario(drive, speed, (torque,))
        if reference == "torque"
        else speed_scenario(drive, (speed,), torque_nm=torque)
    )
    loaded = own_candidate(resolve_candidate("foc"))
    record = recorded(loaded, failing(plain, kind, 0.535), loaded.controller())
    found = [
        margin for margin in judged(record, CONTRACT.checks).margins if margin.check in ("SAF-1", "OVC-1")
    ]
    assert len(found) == 2
    assert all(margin.met for margin in found), found


@pytest.mark.parametrize("name", ["foc", "predictive-flux", "direct-torque", "load-observer"])
def test_a_correct_controller_passes_the_same_runs_and_repeats_itself(name: str) -> None:
    with Judge(resolve_candidate(name)) as judge:
        outcome = judge.run(Job(run_fixed, FixedRuns(revealing_runs(), repeat=True)))
    margins = [margin for run in outcome.runs for margin in run.margins]
    required = {check.id for check in contract_named("duty").checks if check.level == "required"}
    assert [margin for margin in margins if not margin.met and margin.check in required] == []
    assert [margin.measured for margin in margins if margin.check == "DET-1"] == [
        "2 repetitions are the same"
    ]


@pytest.mark.parametrize("name", ["foc-loss-model", "foc-loss-search"])
def test_controllers_of_least_loss_give_all_torque_that_the_limits_leave(name: str) -> None:
    loaded = own_candidate(resolve_candidate(name))
    weakened = revealing_runs()[1]
    margins = judged(recorded(loaded, weakened, loaded.controller()), CONTRACT.checks).margins
    assert "FWK-1" in {margin.check for margin in margins}
    failed = [margin for margin in margins if not margin.met]
    assert not failed, ", ".join(f"{margin.check}: {margin.measured}" for margin in failed)


@pytest.mark.parametrize(("speeds", "torque"), [((500.0, 1100.0), 1.137), ((3100.0, 3200.0), 0.5)])
def test_the_search_for_least_loss_is_not_led_by_a_speed_that_settles(
    speeds: tuple[float, float], torque: float
) -> None:
    document = load_drive("pm-ac-interior")
    loaded = own_candidate(resolve_candidate("foc-loss-search"))
    record = recorded(loaded, speed_scenario(document, speeds, torque_nm=torque), loaded.controller())
    margins = judged(record, contract_of(document).checks).margins
    assert {"FWK-2", "MTP-1"} <= {margin.check for margin in margins}
    failed = [margin for margin in margins if not margin.met]
    assert not failed, ", ".join(f"{margin.check}: {margin.measured}" for margin in failed)


@pytest.mark.parametrize(
    ("name", "speed", "torques"),
    [("pm-ac-2kw", 1420.0, (0.0, 30.0, 0.0)), ("pm-ac-servo", 3900.0, (0.0, 0.8325))],
)
def test_the_search_for_least_loss_is_not_led_by_what_dead_time_and_drops_do(
    name: str, speed: float, torques: tuple[float, ...]
) -> None:
    document = load_drive(name)
    loaded = own_candidate(resolve_candidate("foc-loss-search"))
    record = recorded(loaded, torque_scenario(document, speed, torques), loaded.controller())
    margins = [
        margin for margin in judged(record, contract_of(document).checks).margins if margin.check == "FWK-2"
    ]
    assert margins
    assert all(margin.met for margin in margins), margins


def test_the_search_for_least_loss_does_not_drift_by_what_the_torque_changes_by() -> None:
    document = load_drive("pm-ac-msl")
    loaded = own_candidate(resolve_candidate("foc-loss-search"))
    steps = torque_scenario(document, 1080.0, (31.83, 95.49, 151.2))
    margins = judged(recorded(loaded, steps, loaded.controller()), contract_of(document).checks).margins
    found = [margin for margin in margins if margin.check == "FWK-2"]
    assert found
    assert all(margin.met for margin in found), found


def test_a_current_between_the_least_and_that_of_least_loss_is_no_waste() -> None:
    """The iron asks for more current than the least, and the drops of the switches for less than the iron does."""
    document = load_drive("pm-ac-interior").replaced(
        pole_pairs=2,
        resistance_ohm=0.0391,
        direct_inductance_h=0.00357,
        quadrature_inductance_h=0.0061,
        magnet_flux_v_s=0.0504,
        core_loss_conductance_s=0.0156,
        inertia_kg_m2=0.00359,
        link_voltage_v=40.1,
        carrier_frequency_hz=3300.0,
        switch_drop_v=0.134,
        diode_drop_v=0.134,
        base_speed_rpm=1760.0,
        highest_speed_rpm=5650.0,
        overspeed_rpm=6720.0,
        rated_power_w=129.0,
        current_limit_a=9.76,
    )
    loaded = own_candidate(resolve_candidate("foc-loss-search"))
    record = recorded(loaded, torque_scenario(document, 1300.0, (0.35,)), loaded.controller())
    margins = judged(record, contract_of(document).checks).margins
    assert [margin.met for margin in margins if margin.check == "MTP-1"] == [True], margins


def test_the_controller_without_weakening_fails_for_it_and_names_the_speed() -> None:
    loaded = own_candidate(resolve_candidate("foc-mtpa"))
    weakened = revealing_runs()[1]
    margins = judged(recorded(loaded, weakened, loaded.controller()), CONTRACT.checks).margins
    failed = {margin.check: margin for margin in margins if not margin.met}
    assert "FWK-1" in failed
    assert "at 6000 rpm" in failed["FWK-1"].measured


@pytest.mark.parametrize(
    ("name", "drive", "speeds", "torque", "scales"),
    [
        ("foc", "pm-ac-surface", (800.0, 600.0), 2.0, {}),
        # What locked up generating at 16 A, and again nearly so at the end of the reluctance torque.
        ("foc", "pm-ac-interior", (6000.0, 5000.0), 0.5, {"inductance": 0.7}),
        ("foc", "pm-ac-interior", (2330.0, 1260.0), 0.6148, {"inductance": 1.3, "emf_constant": 0.85}),
        # Less voltage than any torque takes, on a salient machine.
        (
            "foc",
            "pm-ac-2kw",
            (2040.0, 2560.0),
            0.0,
            {"resistance": 2.0, "inductance": 0.7, "emf_constant": 1.05},
        ),
        # The flux turns through zero load angle, and what the model does not know stays where it is.
        (
            "direct-torque",
            "pm-ac-interior",
            (5820.0, 630.0),
            0.341,
            {"resistance": 0.8, "inductance": 1.3, "emf_constant": 0.8},
        ),
    ],
)
def test_the_voltage_limit_locks_no_current_up(
    name: str, drive: str, speeds: tuple[float, float], torque: float, scales: dict[str, float]
) -> None:
    document = load_drive(drive).replaced(settling_s=0.4)
    begin = None if not scales else document.rating.base_speed_rpm
    plain = speed_scenario(document, speeds, torque_nm=torque, initial_speed_rpm=begin)
    scenario = with_scales(plain, **scales)
    loaded = own_candidate(resolve_candidate(name))
    failed = [
        margin
        for margin in judged(
            recorded(loaded, scenario, loaded.controller()), contract_of(document).checks
        ).margins
        if not margin.met
    ]
    assert not failed, ", ".join(f"{margin.check}: {margin.measured}" for margin in failed)


@pytest.mark.parametrize("drive", ["pm-ac-interior", "pm-ac-surface"])
def test_a_shaft_starts_under_load_by_hall_switches_alone(drive: str) -> None:
    document = load_drive(drive)
    assert isinstance(document, PmAcDocument)
    slow = 0.2 * document.rating.base_speed_rpm
    load = torque_of(document, slow, 0.5)
    start = with_edges(speed_scenario(document, (slow,), torque_nm=load, initial_speed_rpm=0.0), "hall", 2)
    loaded = own_candidate(resolve_candidate("foc"))
    record = recorded(loaded, start, loaded.controller())
    assert not record.run.commands["fault"].any(), (
        "a shaft that begins to turn is not locked, nor a phase missing"
    )
    margins = {margin.check: margin for margin in judged(record, contract_of(document).checks).margins}
    assert margins["ROB-5"].met, margins["ROB-5"].measured


def test_drawn_runs_depend_on_their_seed_alone() -> None:
    loaded = own_candidate(resolve_candidate("foc"))
    first, again = (run_drawn(loaded, DrawnRuns(INTERIOR, 1, 2, search=False)) for _ in range(2))
    assert [run.scenario for run in first.runs] == [run.scenario for run in again.runs]
    assert [run.digest for run in first.runs] == [run.digest for run in again.runs]
    assert len(first.runs) == 2


def test_a_step_is_timed_on_what_was_sensed() -> None:
    loaded = own_candidate(resolve_candidate("foc"))
    (run,) = time_steps(loaded, revealing_runs()[0]).runs
    (margin,) = run.margins
    assert margin.check == "TIM-1"
    assert "native" in margin.measured


def test_how_a_candidate_behaves_is_measured_where_it_is_judged() -> None:
    outcome = next(iter(check_outcomes([], NOTHING_DECLARED, INTERIOR, complete=True)))
    changes = {"id": "STP-1", "scenario": revealing_runs()[0].to_mapping(), "counterexample": None}
    step = outcome.model_copy(update=changes)
    job = behaviour_job(INTERIOR, NOTHING_DECLARED, [step])
    assert job is not None
    with Judge(resolve_candidate("foc")) as judge:
        stated = judge.run(job)
    assert stated["step"]["speed_rpm"] == 1200.0
    assert len(stated["points"]) == 8
    assert behaviour_job(load_drive("paper-5-phase"), NOTHING_DECLARED, [step]) is None
    assert behaviour_job(INTERIOR, replace(NOTHING_DECLARED, references=("speed",)), [step]) is None


def test_a_rating_out_of_reach_is_refused_in_one_sentence() -> None:
    with pytest.raises(InputError, match="no controller can meet what the drive") as refused:
        refuse_unreachable(INTERIOR.replaced(rated_power_w=900.0))
    assert "\n" not in str(refused.value)
    with pytest.raises(InputError, match="too slow to be checked"):
        refuse_unreachable(INTERIOR.replaced(inertia_kg_m2=1e3))
    refuse_unreachable(INTERIOR)
    assert {check.id for check in contract_named("duty").checks} >= {"FWK-1", "FWK-2", "FWK-3"}
