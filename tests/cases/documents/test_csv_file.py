"""CSV files of numbers, with columns that must be there and others that may."""

import os
from math import isnan

import pytest

from drivegate_cases.documents.csv_file import read_columns
from drivegate_models.errors import InputError


def rows(tmp_path, text):
    (tmp_path / "own.csv").write_text(text, encoding="utf-8")
    return read_columns(tmp_path / "own.csv", ("speed", "torque"), ("angle",), what="points")


def test_columns_are_found_by_name_in_any_order_and_others_are_left_alone(tmp_path):
    read = rows(tmp_path, "note,Torque, angle ,speed\nfirst,2,30,1\n\nsecond,4,40,3\n")
    assert read == [[1.0, 2.0, 30.0], [3.0, 4.0, 40.0]]


def test_an_optional_cell_or_column_may_have_nothing(tmp_path):
    ((speed, torque, angle),) = rows(tmp_path, "speed,torque,angle\n1,2,\n")
    assert (speed, torque) == (1.0, 2.0)
    assert isnan(angle)
    ((*_, angle),) = rows(tmp_path, "speed,torque\n1,2\n")
    assert isnan(angle)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("speed,torqe\n1,2\n", "has no column 'torque' in its first line, the nearest there is 'torqe'"),
        ("", "it must have speed and torque"),
        (
            "speed;torque;angle\n1,5;2,5;3\n",
            "separates its columns by semicolons, but must have commas, and decimal points in its numbers: ",
        ),
        ("torque\tspeed\n1\t2\n", "separates its columns by tabs, but must have commas"),
        (
            "speed,torque\n1,2,5\n",
            "has 3 cells in line 2, but 2 columns in its first line; numbers must have",
        ),
        ('speed,torque\n1,"2,5"\n', "must be a number with a decimal point, 2.5"),
        ("speed,torque\n1,\n", "'torque' is \"\" in line 2, but must be a number"),
        ("speed,torque\n1,nan\n", "must be a number"),
        ("speed,torque,angle\n1,2,steep\n", "'angle' is \"steep\" in line 2"),
    ],
)
def test_what_is_wrong_is_reported_with_its_place(tmp_path, text, reason):
    with pytest.raises(InputError) as refused:
        rows(tmp_path, text)
    assert reason in str(refused.value)


def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "own.csv")
    with pytest.raises(
        InputError, match=r"is not a regular file, but must be a CSV file with speed and torque"
    ):
        read_columns(tmp_path / "own.csv", ("speed", "torque"), what="points")
