"""Drawn drives follow from seed and number, lie within the stated bounds, and can be judged on."""

from itertools import islice

import pytest

from drivegate.drives import drawn_drives
from drivegate.drives.drawn_bounds import BOUNDS
from drivegate.drives.drawn_drives import drawn_drive, draws, per_unit_values
from drivegate.drives.rating import rated_drive
from drivegate.drives.reach import unreachable
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.usual_values import unusual_values
from drivegate_models.errors import HarnessFault

_ROUNDING = 0.02
"""What three digits of each factor of a per-unit value make of it."""


@pytest.fixture(scope="module")
def many() -> list[DriveDocument]:
    return [drive for number in range(1, 41) for drive in islice(draws(0, number), 5)]


def test_a_drive_follows_from_seed_and_number() -> None:
    assert next(draws(0, 3)) == next(draws(0, 3))
    assert len({next(draws(seed, number)) for seed in (0, 1) for number in (1, 2, 3)}) == 6


def test_values_lie_within_their_bounds(many: list[DriveDocument]) -> None:
    for drive in many:
        for quantity, value in per_unit_values(drive).items():
            bound = BOUNDS[quantity]
            within = bound.lowest * (1.0 - _ROUNDING) <= value <= bound.highest * (1.0 + _ROUNDING)
            assert within, f"{drive.name}: {bound.quantity} is {value}"
        for quantity, value in (
            ("phases", drive.machine.phases),
            ("pole_pairs", drive.machine.pole_pairs),
            ("rated_power", drive.rating.rated_power_w),
            ("supply", drive.inverter.supply_voltage_v),
        ):
            assert BOUNDS[quantity].lowest <= value <= BOUNDS[quantity].highest, (
                f"{drive.name}: {quantity} is {value}"
            )


def test_the_bounds_are_made_use_of(many: list[DriveDocument]) -> None:
    for quantity in ("emf", "reactance", "speed_range", "current_limit"):
        bound, values = BOUNDS[quantity], [per_unit_values(drive)[quantity] for drive in many]
        spread = (max(values) - min(values)) / (bound.highest - bound.lowest)
        assert spread > 0.9, f"{quantity} is drawn from {spread:.0%} of its range only"
    assert {drive.machine.phases for drive in many} == set(range(3, 10))
    assert {drive.machine.emf_shape for drive in many} == {"sine", "trapezoid"}


def test_no_value_looks_like_a_wrong_unit_and_each_has_its_provenance(many: list[DriveDocument]) -> None:
    for drive in many:
        assert unusual_values(drive) == ()
        told = {key for sentences in drive.provenance.values() for key in sentences}
        drawn = set(drive.machine.model_fields_set - {"emf_table"}) | set(drive.rating.model_fields_set)
        assert drawn - {"emf_flat_deg"} <= told, f"{drive.name} does not say where {drawn - told} come from"
        assert all(
            text.startswith("drawn: ") for table in drive.provenance.values() for text in table.values()
        )


def test_the_papers_drive_lies_within_the_bounds() -> None:
    for quantity, value in per_unit_values(load_drive("paper-5-phase")).items():
        bound = BOUNDS[quantity]
        if quantity not in ("friction", "viscous_friction"):
            assert bound.lowest <= value <= bound.highest, f"{bound.quantity} is {value:.3g}"


def test_a_drive_whose_rating_cannot_be_met_is_rejected() -> None:
    drawn = next(found for number in range(1, 30) if (found := drawn_drive(0, number)).rejected)
    number = int(drawn.document.name.rpartition("-")[2])
    before = list(islice(draws(0, number), drawn.rejected + 1))
    assert before[-1].rating == drawn.document.rating
    assert all(unreachable(rated_drive(drive)) for drive in before[:-1])


def test_what_is_required_of_a_drawn_drive_can_be_met() -> None:
    drawn = [drawn_drive(0, number).document for number in range(1, 9)]
    for drive in drawn:
        assert unreachable(rated_drive(drive)) == (), drive.name
    assert any(limits_of(drive).ripple > 0.13 for drive in drawn), "some cannot have the paper's ripple"


def test_bounds_that_no_drive_can_meet_are_a_fault_of_the_harness(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawn_drives, "rating_is_met", lambda _: False)
    monkeypatch.setattr(drawn_drives, "MOST_DRAWS", 3)
    with pytest.raises(HarnessFault, match="none of 3 drives drawn with seed 0 for number 1"):
        drawn_drive(0, 1)
