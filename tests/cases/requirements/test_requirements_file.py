"""Files of requirements: what they may say, and the one sentence for what they may not."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.requirements.file import OwnRequirements, RequirementsFile, read_requirements
from drivegate_cases.requirements.quantities import QUANTITIES
from drivegate_cases.requirements.row import Row
from drivegate_models.errors import InputError

ROW: dict[str, Any] = {
    "id": "REQ-1",
    "text": "After a load step the speed is back within 20 rpm in 0.3 s.",
    "when": "step of load",
    "between_s": [0.3, 1.0],
    "quantity": "speed_deviation_rpm",
    "statistic": "absolute",
    "at_most": 20,
}


def parsed(*rows: dict[str, Any]) -> RequirementsFile:
    return parse_document({"schema": 1, "requirement": list(rows)}, RequirementsFile, "requirements.toml")


def test_a_row_is_read_and_written_again() -> None:
    (row,) = parsed(ROW).requirement
    assert row.when.event == "step of load"
    assert row.limits == (None, 20.0)
    assert row.window == ("s", (0.3, 1.0))
    written = json.loads(json.dumps(row.model_dump(mode="json", exclude_defaults=True)))
    (again,) = parsed(written).requirement
    assert again == row
    assert hash(again) == hash(row)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"quantity": "speed_deviation_rad_s"}, "the nearest is 'speed_deviation_rpm'"),
        ({"between_s": [1.0, 0.3]}, "whose begin is before its end"),
        ({"between_s": [0.3, 0.3]}, "whose begin is before its end"),
        ({"between_s": [0.1, 0.2, 0.3]}, "has 3 entries, but must have at most 2"),
        ({"between_periods": [1.0]}, "states between_s and between_periods, but must state one of them"),
        ({"at_least": 3.0}, "states at_most and at_least, but must state exactly one of"),
        ({"at_most": None}, "states no limit"),
        ({"at_most": -1.0}, "can never be met: the statistic 'absolute' is never below 0"),
        ({"at_most": None, "within": [3.0, -3.0]}, "but its first value is above its second"),
        ({"at_most": None, "within": [3.0, 3.0]}, "is met by 3 alone"),
        ({"at_most": "20"}, "must be a number"),
        ({"when": "step of laod"}, "is \"step of laod\", but must be 'start', "),
        ({"when": {"speed_rpm": [900.0, 100.0]}}, "but its first value is above its second"),
        ({"when": {"speed_rpm": [10.0, 90.0], "direction": "backward"}}, "must not contradict itself"),
        ({"when": {"step_percent": [10.0, 90.0]}}, "must have a step as its event"),
        ({"statistic": "time until"}, "must state 'until'"),
        (
            {"until": [1.0, 2.0]},
            "must state 'until', the range that the quantity has to reach, for the statistic",
        ),
        ({"statistic": "average"}, 'is "average", but must be'),
        ({"for_s": 0.8}, "has a for_s of 0.8 s, but its window is only 0.7 s long"),
        ({"id": "REQ 1"}, "'requirement[0].id' is \"REQ 1\""),
        ({"atmost": 3.0}, "the key 'requirement[0].atmost' is unknown, the nearest known key is 'at_most'"),
    ],
)
def test_a_row_that_says_nothing_sensible_is_refused_in_one_sentence(
    change: dict[str, Any], sentence: str
) -> None:
    row = {key: value for key, value in {**ROW, **change}.items() if value is not None}
    with pytest.raises(InputError) as refused:
        parsed(row)
    assert sentence in str(refused.value)
    assert "\n" not in str(refused.value)


def test_identifiers_differ_by_more_than_capitals() -> None:
    with pytest.raises(InputError, match="two requirements are called REQ-1"):
        parsed(ROW, ROW | {"id": "req-1"})


def test_a_file_without_rows_is_refused() -> None:
    with pytest.raises(InputError, match=r"has no table \[\[requirement\]\]"):
        parsed()


def test_a_scenario_leaves_its_drive_out(tmp_path: Path) -> None:
    path = tmp_path / "requirements.toml"
    row = "\n".join(f"{key} = {json.dumps(value)}" for key, value in ROW.items())
    path.write_text(
        f'schema = 1\n[[requirement]]\n{row}\n[[scenario]]\nname = "one"\ndrive = "pm-ac-interior"\n'
    )
    with pytest.raises(InputError, match="scenario 1 has the key 'drive', but must leave it out"):
        read_requirements(path)
    path.write_text(f"schema = 1\n[[requirement]]\n{row}\n")
    assert read_requirements(path).rows == (Row.model_validate(parsed(ROW).requirement[0]),)


def test_ranges_are_drawn_and_their_ends_come_first() -> None:
    table = {
        "name": "step",
        "duration_s": 0.5,
        "restarts_s": [0.1, [0.2, 0.3]],
        "initial_angle_deg": [0.0, 90.0],
        "speed_rpm": [[0.0, [500.0, 1500.0]]],
        "load": {
            "kind": "constant_torque",
            "torque_nm": [0.1, 1.0],
            "factor": [[0.0, 0.0], [[0.1, 0.2], 0.0]],
        },
    }
    own = OwnRequirements(parsed(ROW).requirement, (json.dumps(table),))
    drive = load_drive("pm-ac-interior")
    assert own.scenarios_on(drive) == ()
    drawn = own.drawn_on(drive, 5, 7)
    assert [scenario.name for scenario in drawn] == [f"step {number}" for number in range(1, 6)]
    assert [scenario.speed_rpm[0][1] for scenario in drawn[:2]] == [500.0, 1500.0]
    assert [scenario.restarts_s for scenario in drawn[:2]] == [(0.1, 0.2), (0.1, 0.3)]
    angles = {scenario.initial_angle_deg for scenario in drawn}
    assert len(angles) == 5
    assert drawn == own.drawn_on(drive, 5, 7)
    assert drawn != own.drawn_on(drive, 5, 8)
    wrong = OwnRequirements(own.rows, (json.dumps(table | {"initial_angle_deg": [90.0, 0.0]}),))
    with pytest.raises(InputError, match="must have its lowest value first"):
        wrong.drawn_on(drive, 5, 7)


def test_every_quantity_has_its_unit_in_its_name() -> None:
    endings = {
        "rpm": "_rpm",
        "rpm/s": "_rpm_per_s",
        "%": "_percent",
        "N·m": "_nm",
        "A": "_a",
        "°": "_deg",
        "°C": "_c",
        "W": "_w",
        "V": "_v",
    }
    assert all(name.endswith(endings[quantity.unit]) for name, quantity in QUANTITIES.items())
