"""On every packaged drive the table of angles that a correct design has leads to the optimum at rated power."""

import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.record import CurrentRecord
from drivegate.drives.running import run_scenario
from drivegate.scenarios.drive_scale import scale_of, tidy
from drivegate_cases.drive.drive_document import PM_AC, drive_names, load_drive
from drivegate_cases.scenario.load import ConstantPowerLoad
from drivegate_cases.scenario.scenario import Scenario

CONVERGENCE = ("CNV-1", "CNV-2", "CMD-1", "CMD-2", "ADV-1")


def failed(name: str, drive_name: str, share: float) -> set[str]:
    """Run a controller at rated power and a share of the range above base speed, and give the checks that it fails."""
    drive = load_drive(drive_name)
    scale = scale_of(drive)
    rpm = scale.speed(share)
    scenario = Scenario(
        name="rated power",
        drive=drive,
        duration_s=tidy(1.2 + scale.settling_s + scale.shortest_window_s),
        initial_speed_rpm=rpm,
        speed_rpm=((0.0, rpm),),
        load=ConstantPowerLoad(
            kind="constant_power", power_w=drive.rating.rated_power_w, factor=((0.0, 0.0), (0.2, 1.0))
        ),
    )
    candidate = resolve_candidate(name)
    run = run_scenario(scenario, load_controller(candidate))
    margins = judged(CurrentRecord(scenario, run, candidate.declaration), CHECKS).margins
    assert {"CNV-1", "CNV-2"} <= {margin.check for margin in margins}, (
        "a run that is not judged proves nothing"
    )
    return {margin.check for margin in margins if margin.value < 0.0}


# Each table takes seconds to compute; those of the star's variants are made alike.
@pytest.mark.nightly
@pytest.mark.parametrize("share", [0.05, 0.5, 1.0])
@pytest.mark.parametrize("drive", [name for name in drive_names(but=PM_AC) if "-150-" not in name])
def test_the_table_of_a_drive_leads_to_its_optimum(drive: str, share: float) -> None:
    assert not failed("design:angle-table", drive, share) & {*CONVERGENCE}
