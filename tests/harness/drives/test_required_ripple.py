"""Required points whose ripple no controller can have are found, and the limit that is offered instead can be met."""

import pytest

from drivegate.drives.abilities import refuse_unreachable
from drivegate.drives.rating import rated_drive
from drivegate.drives.required_ripple import unreachable_ripple
from drivegate_cases.drive.drive_document import PM_AC, drive_names, load_drive
from drivegate_models.errors import InputError

FAN = load_drive("fan-3-phase")


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", drive_names(but=PM_AC))
def test_what_a_packaged_drive_requires_can_be_met(name: str) -> None:
    refuse_unreachable(load_drive(name))
    assert unreachable_ripple(rated_drive(load_drive(name))) == ()


def test_the_ripple_of_five_phases_is_out_of_reach_of_three() -> None:
    strict = FAN.replaced(ripple_percent=13.0)
    (found,) = unreachable_ripple(rated_drive(strict))
    assert found.sentence() == (
        "a torque ripple below 13 % is required for 0.163 N·m at 6000 rpm, but within 2 % of the minimum current "
        "sum it is at least 47.6 %, at 66.9°; a check accepts ripple_percent = 49"
    )
    with pytest.raises(
        InputError, match=r"no controller can meet what the drive 'fan-3-phase' requires: a torque rip"
    ):
        refuse_unreachable(strict)


def test_the_limit_that_is_offered_can_be_met_and_a_little_less_cannot() -> None:
    strict = FAN.replaced(ripple_percent=13.0)
    (found,) = unreachable_ripple(rated_drive(strict))
    offered = strict.replaced(ripple_percent=float(found.nearest_percent))
    assert unreachable_ripple(rated_drive(offered)) == ()
    assert unreachable_ripple(rated_drive(strict.replaced(ripple_percent=100.0 * found.least))) != ()


def test_a_point_whose_torque_is_out_of_reach_is_reported_with_what_there_is() -> None:
    heavy = FAN.replaced(point=({"speed_rpm": 6000.0, "torque_n_m": 0.3},))
    (found,) = unreachable_ripple(rated_drive(heavy))
    assert found.sentence() == (
        "the required point of 0.3 N·m at 6000 rpm is out of reach: this drive delivers at most 0.196 N·m there; "
        "a check accepts torque_n_m = 0.195"
    )
    assert found.document()["key"] == "requirements.point"


def test_the_friction_of_a_shaft_adds_to_the_torque_of_a_point() -> None:
    (without,) = unreachable_ripple(rated_drive(FAN.replaced(ripple_percent=13.0)))
    (with_friction,) = unreachable_ripple(rated_drive(FAN.replaced(ripple_percent=13.0, friction_n_m=0.02)))
    heavier = FAN.replaced(
        ripple_percent=13.0, point=({"speed_rpm": 6000.0, "torque_n_m": without.torque_nm + 0.02},)
    )
    (stated,) = unreachable_ripple(rated_drive(heavier))
    assert with_friction.least == pytest.approx(stated.least, rel=1e-9)
    assert abs(with_friction.least - without.least) > 1e-3
    assert with_friction.greatest_torque == pytest.approx(without.greatest_torque - 0.02, rel=1e-9)
