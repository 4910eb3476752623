"""A drive that is stated without field weakening: its highest speed is its base speed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.models.drawn_runs import drawn

from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.duty.scenarios.building import supply_step_scenario, torque_of, torque_scenario
from drivegate.contracts.duty.scenarios.drawn.families import FAMILY_GROUPS, drawn_scenarios
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.drives.abilities import ability_of, refuse_unreachable
from drivegate.results.verdict import check_outcomes
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.greatest_torque import greatest_within
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError
from drivegate_models.pm_ac.oracle import undistorted_limits
from drivegate_models.units import RADIANS_PER_RPM


def without_weakening(name: str = "pm-ac-surface") -> PmAcDocument:
    drive = load_drive(name)
    unweakened = drive.replaced(highest_speed_rpm=drive.rating.base_speed_rpm)
    assert isinstance(unweakened, PmAcDocument)
    return unweakened


DRIVE = without_weakening()
BASE = DRIVE.rating.base_speed_rpm


def fastest(run: Scenario) -> float:
    return max(abs(speed) for _, speed in run.speed_rpm)


def test_checks_of_weakening_do_not_apply_and_say_why() -> None:
    outcomes = {
        outcome.id: outcome
        for outcome in check_outcomes((), resolve_candidate("foc-mtpa").declaration, DRIVE, complete=True)
    }
    for check in ("FWK-1", "FWK-3"):
        assert outcomes[check].verdict == "not applicable"
        assert (
            "stated without field weakening: its highest speed is its base speed" in outcomes[check].message
        )
    assert "stated without" not in outcomes["FWK-2"].message, "needless d current is judged on any drive"


def test_no_fixed_scenario_is_above_base_speed_or_asks_for_weakening() -> None:
    fixed = fixed_scenarios(DRIVE)
    assert max(map(fastest, fixed)) == BASE
    reasons = {run: because for run in fixed if (because := unfair_because(run)) is not None}
    # A torque at base speed is out of reach with less voltage, and a heavier rotor too slow with what its load leaves.
    assert all(run.supply_v is not None or "too late" in because for run, because in reasons.items()), reasons
    assert len(reasons) <= 3


def test_the_highest_speed_is_not_passed_by_rounding() -> None:
    drive = DRIVE.replaced(base_speed_rpm=548.0, highest_speed_rpm=548.0)
    assert isinstance(drive, PmAcDocument)
    assert max(map(fastest, fixed_scenarios(drive))) == 548.0


@pytest.mark.parametrize("group", range(len(FAMILY_GROUPS)))
def test_every_group_of_drawn_scenarios_stays_up_to_base_speed(group: int) -> None:
    @drawn(5)
    @given(st.data())
    def draw(data: st.DataObject) -> None:
        assert fastest(data.draw(drawn_scenarios(DRIVE, group))) <= BASE

    draw()


def test_a_torque_that_takes_weakening_is_out_of_reach() -> None:
    interior = load_drive("pm-ac-interior")
    unweakened = without_weakening("pm-ac-interior")
    rated = torque_of(unweakened, unweakened.rating.base_speed_rpm, 0.9)
    run = torque_scenario(unweakened, unweakened.rating.base_speed_rpm, (rated,))
    assert unfair_because(run) is None
    low = supply_step_scenario(run, unweakened, (1.0, 0.75))
    assert str(unfair_because(low)).endswith("give the torque without field weakening")
    assert unfair_because(low.replaced(drive=interior)) is None, (
        "a torque out of reach is limited by weakening"
    )


def test_rated_power_has_to_be_reached_without_weakening() -> None:
    refuse_unreachable(DRIVE)
    faster = DRIVE.replaced(base_speed_rpm=1000.0, highest_speed_rpm=1000.0, overspeed_rpm=1100.0)
    refuse_unreachable(faster.replaced(highest_speed_rpm=1001.0))
    with pytest.raises(InputError, match="no controller can meet what the drive 'pm-ac-surface' requires"):
        refuse_unreachable(faster)


@pytest.mark.parametrize("name", ["pm-ac-surface", "pm-ac-interior"])
def test_the_greatest_torque_is_of_the_current_limit_or_of_the_voltage(name: str) -> None:
    plant = without_weakening(name).plant()
    limits = undistorted_limits(plant)
    base = without_weakening(name).rating.base_speed_rpm * RADIANS_PER_RPM
    below, above, far = (
        greatest_within(plant, limits, share * base, weakens=False) for share in (0.5, 1.2, 5.0)
    )
    assert below.current == pytest.approx(limits.current)
    assert above.voltage == pytest.approx(limits.voltage)
    assert 0.0 < above.torque < greatest_within(plant, limits, 1.2 * base, weakens=True).torque
    assert far.torque != far.torque, "above the speed at which the EMF is the voltage there is none"


def test_what_a_drive_can_do_is_stated_without_weakening() -> None:
    envelope = ability_of(DRIVE).envelope(DRIVE, lambda _: None)
    assert envelope["rated_power_up_to_rpm"] == pytest.approx(BASE)
    assert "stated without field weakening" in ability_of(DRIVE).facts(envelope)[1]
    assert "weakening" not in ability_of(DRIVE).required(DRIVE)[0]
