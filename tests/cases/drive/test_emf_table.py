import pytest

from drivegate_cases.drive.plant import EmfTable, check_emf_table


@pytest.mark.parametrize(
    "table",
    [
        (),
        ((0.0, 0.0), (90.0, 1.0), (180.0, 0.0)),
        ((0.0, 0.0), (10.0, -0.2), (60.0, 1.0), (120.0, 0.9), (180.0, 0.0)),
        ((0.0, 0.0), (45.0, -1.0), (90.0, 1.0 + 1e-10), (180.0, 0.0)),
    ],
)
def test_a_half_cycle_of_peak_one_is_a_shape(table: EmfTable) -> None:
    assert check_emf_table(table) == table


@pytest.mark.parametrize(
    ("table", "reported"),
    [
        (((0.0, 0.0),), "begin at 0 and end at 180"),
        (((1.0, 0.0), (90.0, 1.0), (180.0, 0.0)), "begin at 0 and end at 180"),
        (((0.0, 0.0), (90.0, 1.0), (179.0, 0.0)), "begin at 0 and end at 180"),
        (((0.0, 0.0), (90.0, 1.0), (90.0, 0.5), (180.0, 0.0)), "strictly increasing"),
        (((0.0, 0.0), (90.0, 1.0), (80.0, 0.5), (180.0, 0.0)), "strictly increasing"),
        (((0.0, 0.0), (1e-320, 1.0), (180.0, 0.0)), "strictly increasing"),
        (((0.0, 0.1), (90.0, 1.0), (180.0, 0.0)), "the value 0 at 0 and at 180"),
        (((0.0, 0.0), (90.0, 1.0), (180.0, 0.1)), "the value 0 at 0 and at 180"),
        (((0.0, 0.0), (90.0, 0.9), (180.0, 0.0)), "the value 1 as its greatest"),
        (((0.0, 0.0), (90.0, 1.1), (180.0, 0.0)), "the value 1 as its greatest"),
        (((0.0, 0.0), (45.0, -1.1), (90.0, 1.0), (180.0, 0.0)), "none below -1"),
        (((0.0, 0.0), (180.0, 0.0)), "the value 1 as its greatest"),
    ],
)
def test_a_broken_rule_is_reported(table: EmfTable, reported: str) -> None:
    with pytest.raises(ValueError, match=reported):
        check_emf_table(table)
