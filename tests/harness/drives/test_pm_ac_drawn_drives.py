"""Drawn PM AC drives follow from seed and number, lie within the stated bounds, and can be judged on."""

from itertools import islice

import pytest

from drivegate.drives import pm_ac_drawn_drives
from drivegate.drives.pm_ac_drawn_bounds import FEWEST_PERIODS, PM_AC_BOUNDS
from drivegate.drives.pm_ac_drawn_drives import drawn_pm_ac_drive, pm_ac_draws, pm_ac_per_unit_values
from drivegate.drives.pm_ac_reach import unreachable_duty
from drivegate.drives.reach import refuse_unreachable
from drivegate_cases.drive.drive_document import drive_names, load_drive
from drivegate_cases.drive.drive_file import drive_toml
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.usual_values import unusual_values
from drivegate_models.errors import HarnessFault

_ROUNDING = 0.02
"""What three digits of each factor of a per-unit value make of it."""


@pytest.fixture(scope="module")
def many() -> list[PmAcDocument]:
    return [drive for number in range(1, 41) for drive in islice(pm_ac_draws(0, number), 5)]


def test_a_drive_follows_from_seed_and_number() -> None:
    assert next(pm_ac_draws(0, 3)) == next(pm_ac_draws(0, 3))
    assert len({next(pm_ac_draws(seed, number)) for seed in (0, 1) for number in (1, 2, 3)}) == 6


def test_values_lie_within_their_bounds(many: list[PmAcDocument]) -> None:
    for drive in many:
        values = pm_ac_per_unit_values(drive) | {
            "pole_pairs": drive.machine.pole_pairs,
            "link": drive.inverter.link_voltage_v,
        }
        assert values.keys() == PM_AC_BOUNDS.keys()
        for quantity, value in values.items():
            bound = PM_AC_BOUNDS[quantity]
            within = bound.lowest * (1.0 - _ROUNDING) <= value <= bound.highest * (1.0 + _ROUNDING)
            assert within, f"{drive.name}: {bound.quantity} is {value}"
        turns = drive.machine.pole_pairs * drive.rating.highest_speed_rpm / 60.0
        assert 1.0 / (turns * drive.control_period_s) >= FEWEST_PERIODS * (1.0 - _ROUNDING)


def test_the_bounds_are_made_use_of(many: list[PmAcDocument]) -> None:
    for quantity in ("emf", "reactance", "saliency", "speed_range", "power", "dead_time"):
        bound, values = PM_AC_BOUNDS[quantity], [pm_ac_per_unit_values(drive)[quantity] for drive in many]
        spread = (max(values) - min(values)) / (bound.highest - bound.lowest)
        assert spread > 0.9, f"{quantity} is drawn from {spread:.0%} of its range only"
    assert {drive.inverter.carrier for drive in many} == {"single", "double"}


def test_no_value_looks_like_a_wrong_unit_and_each_has_its_provenance(many: list[PmAcDocument]) -> None:
    for drive in many:
        assert unusual_values(drive) == ()
        told = {key for sentences in drive.provenance.values() for key in sentences}
        tables = (drive.machine, drive.inverter, drive.rating, drive.requirements)
        drawn = {key for table in tables for key in table.model_fields_set}
        assert drawn <= told, f"{drive.name} does not say where {drawn - told} come from"


def test_the_file_of_a_drive_is_the_drive(many: list[PmAcDocument], tmp_path) -> None:
    path = tmp_path / "drawn.toml"
    path.write_text(drive_toml(many[0]), encoding="utf-8")
    assert load_drive(path) == many[0]


@pytest.mark.parametrize("name", [name for name in drive_names() if name.startswith("pm-ac")])
def test_the_packaged_drives_lie_within_the_bounds(name: str) -> None:
    for quantity, value in pm_ac_per_unit_values(load_drive(name)).items():
        bound = PM_AC_BOUNDS[quantity]
        assert bound.lowest <= value <= bound.highest, f"{bound.quantity} is {value:.3g}"


def test_a_drive_whose_rating_cannot_be_met_is_rejected() -> None:
    drawn = next(found for number in range(1, 30) if (found := drawn_pm_ac_drive(0, number)).rejected)
    number = int(drawn.document.name.rpartition("-")[2])
    *before, last = islice(pm_ac_draws(0, number), drawn.rejected + 1)
    assert last == drawn.document
    refuse_unreachable(last)
    assert all(unreachable_duty(drive) is not None for drive in before)


def test_bounds_that_no_drive_can_meet_are_a_fault_of_the_harness(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pm_ac_drawn_drives, "unreachable_duty", lambda _: "nothing")
    monkeypatch.setattr(pm_ac_drawn_drives, "MOST_DRAWS", 3)
    with pytest.raises(HarnessFault, match="drives drawn with seed 0 for number 1"):
        drawn_pm_ac_drive(0, 1)
