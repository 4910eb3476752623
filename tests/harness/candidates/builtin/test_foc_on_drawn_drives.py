"""Field-oriented control on drawn drives: a salient machine beyond its magnet's flux, and dead time."""

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import CONTRACTS
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.drives.drawn.kinds import PM_AC
from drivegate.drives.running import recorded

CHECKS = {check.id: check for check in CONTRACTS["duty"].checks()}


@pytest.mark.parametrize(
    ("check_id", "number", "label"),
    [
        pytest.param(
            "FWK-1", 16, "-torque-0-", id="most torque per volt lies beyond the magnet's whole flux"
        ),
        pytest.param("RIP-4", 16, "14rpm-torque-", id="dead time at 8 % of base speed"),
        pytest.param("RIP-4", 5, "80rpm-torque-", id="dead time on a machine of large saliency"),
    ],
)
def test_foc_meets_a_check_on_a_drawn_drive(check_id: str, number: int, label: str) -> None:
    drive = PM_AC.draw(0, number).document
    loaded = own_candidate(resolve_candidate("foc"))
    controller = loaded.controller()
    margins = [
        CHECKS[check_id].evaluate(recorded(loaded, scenario, controller))
        for scenario in fixed_scenarios(drive)
        if label in scenario.name
    ]
    judged = [margin for margin in margins if margin is not None]
    assert judged, f"no fixed scenario of drive {number} is judged by {check_id}"
    assert all(margin.met for margin in judged), [margin for margin in judged if not margin.met]
