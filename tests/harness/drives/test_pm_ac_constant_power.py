"""The range of constant power of PM AC drives."""

import pytest

from drivegate.drives.duty_ability import DUTY_ABILITY, duty_envelope
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.units import RADIANS_PER_RPM


def document(**changes: float) -> PmAcDocument:
    found = load_drive("pm-ac-interior").replaced(**changes)
    assert isinstance(found, PmAcDocument)
    return found


def test_it_is_that_of_the_envelope() -> None:
    drive = document()
    found, stated = DUTY_ABILITY.constant_power(drive), duty_envelope(drive)
    assert found.speeds[0] == pytest.approx(drive.rating.base_speed_rpm * RADIANS_PER_RPM)
    last = stated["points"][-1]
    assert last["speed_rpm"] == drive.rating.overspeed_rpm
    assert found.powers[-1] == pytest.approx(last["greatest_power_w"])
    upto = stated["rated_power_up_to_rpm"] or drive.rating.overspeed_rpm
    assert found.reached == pytest.approx(min(upto, drive.rating.overspeed_rpm) * RADIANS_PER_RPM)


def test_it_ends_at_overspeed_and_is_none_where_base_speed_has_no_rated_power() -> None:
    weak = document(rated_power_w=300.0)
    assert DUTY_ABILITY.constant_power(weak).reached == pytest.approx(
        weak.rating.overspeed_rpm * RADIANS_PER_RPM
    )
    assert DUTY_ABILITY.constant_power(document(rated_power_w=5000.0)).reached is None
