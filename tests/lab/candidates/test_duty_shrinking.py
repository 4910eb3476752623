"""A counterexample of duty ratios becomes simpler where its check is fair, and no worse than it was."""

from __future__ import annotations

from drivegate.candidates.controller import Controller
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.duty.scenarios.building import failing, torque_of, torque_scenario
from drivegate.gate.shrinking import ShrinkPlan, Shrunk, run_shrink
from drivegate.scenarios.simplification import size_of
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario

INTERIOR = load_drive("pm-ac-interior")
BASE = INTERIOR.rating.base_speed_rpm


class Loaded:
    """A built-in candidate in this very process."""

    def __init__(self, name: str) -> None:
        self.candidate = resolve_candidate(name)

    def controller(self) -> Controller:
        return load_controller(self.candidate)


def shrunk(name: str, scenario: Scenario, check: str, budget: int) -> Shrunk:
    plan = ShrinkPlan(scenario.to_mapping(), check, budget)
    found = run_shrink(Loaded(name), plan)  # type: ignore[arg-type]
    assert found is not None, f"{name} meets {check}"
    return found


def failed(speed_share: float, torque_share: float) -> Scenario:
    """Make a run at odd numbers in which a current sensor is stuck."""
    speed = speed_share * BASE
    held = torque_scenario(INTERIOR, speed, (torque_of(INTERIOR, speed, torque_share),))
    return failing(held, "stuck-current", 0.57 * held.duration_s, 2)


def test_a_failure_that_is_not_noticed_stays_at_speeds_and_torques_that_show_it() -> None:
    start = failed(0.2371, 0.4371)
    found = shrunk("faulty:third-current-computed", start, "SAF-1", 25)
    simplest = parse_document(found.scenario, Scenario, "the result")
    (_, speed), (_, torque) = simplest.speed_rpm[0], simplest.torque_reference_profile[0]
    assert size_of(found.scenario) < size_of(start.to_mapping())
    assert 0.2 * BASE <= speed <= BASE
    assert 0.3 <= torque / torque_of(INTERIOR, speed, 1.0) <= 0.6


def test_a_peak_of_the_current_does_not_grow_as_its_scenario_becomes_simpler() -> None:
    speed = 1.31 * BASE
    levels = [torque_of(INTERIOR, speed, share) for share in (0.0, 1.73, 0.0)]
    start = torque_scenario(INTERIOR, speed, levels)
    limit = 1.2 * INTERIOR.rating.current_limit_a
    first, found = (shrunk("faulty:generous-current-limit", start, "OVC-1", budget) for budget in (1, 25))
    assert size_of(found.scenario) < size_of(first.scenario)
    assert limit < float(found.margin.measured.split()[0]) <= float(first.margin.measured.split()[0])


def test_a_failure_at_every_speed_is_shown_at_rest() -> None:
    """A torque that rises late does so at any speed, also backward at half of base speed, where it was found."""
    levels = [torque_of(INTERIOR, 0.5 * BASE, share) for share in (0.0, -0.5, 0.0)]
    start = torque_scenario(INTERIOR, -0.5 * BASE, levels)
    found = shrunk("faulty:slow-currents", start, "STP-1", 25)
    assert {speed for _, speed in found.scenario["speed_rpm"]} == {0.0}
    assert min(torque for _, torque in found.scenario["load"]["torque_reference_nm"]) >= 0.0, (
        "and not braking"
    )


def test_a_failure_without_torque_is_shrunk_to_a_run_without() -> None:
    """Among six torques over six seconds is one of 0, and weakening that stays on fails there as well."""
    levels = [torque_of(INTERIOR, 0.0, share) for share in (0.5, -0.3, 0.0, 0.8, -0.7, 0.2)]
    start = torque_scenario(INTERIOR, 0.0, levels)
    found = shrunk("faulty:stuck-weakening", start, "FWK-2", 25)
    assert {torque for _, torque in found.scenario["load"]["torque_reference_nm"]} == {0.0}
    assert found.scenario["duration_s"] < 0.3 * start.duration_s
