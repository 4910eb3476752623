"""Drive cycles: the urban cycle as published, and a user's own file."""

from itertools import pairwise
from pathlib import Path

import pytest

from drivegate_cases.scenario.drive_cycle import cycle_names, load_drive_cycle
from drivegate_models.errors import InputError


def test_the_urban_cycle_is_the_published_one():
    cycle = load_drive_cycle("ece-15")
    assert cycle_names() == ("ece-15",)
    assert cycle.duration_s == 195.0
    # The regulation states 1.013 km and 19 km/h.
    assert cycle.distance_m == pytest.approx(1013.0, rel=0.002)
    assert 3.6 * cycle.distance_m / cycle.duration_s == pytest.approx(19.0, abs=0.5)
    assert max(speed for _, speed in cycle.speed_km_h) == 50.0
    assert cycle.speed_km_h[0][1] == cycle.speed_km_h[-1][1] == 0.0
    assert "Regulation No. 83" in cycle.source


def test_the_urban_cycle_stands_still_as_long_as_published():
    points = load_drive_cycle("ece-15").speed_km_h
    standing = sum(
        later - earlier for (earlier, before), (later, after) in pairwise(points) if before == after == 0.0
    )
    assert standing == 60.0, "the regulation has 60 s of idling"


def test_a_file_of_ones_own_is_read(tmp_path: Path):
    file = tmp_path / "commute.csv"
    file.write_text(
        "\ufefftime_s, note ,Speed_km_h\n0,start,0\n\n10.5,x,36\n20,,36\n30,end,0\n", encoding="utf-8"
    )
    cycle = load_drive_cycle(file)
    assert cycle.name == "commute"
    assert cycle.speed_km_h == ((0.0, 0.0), (10.5, 36.0), (20.0, 36.0), (30.0, 0.0))
    assert cycle.distance_m == pytest.approx(52.5 + 95.0 + 50.0)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "no column 'time_s'"),
        ("time,speed_km_h\n0,0\n1,5\n", "the nearest there is 'time'"),
        ("time_s,speed_km_h\n0,0\n1,fast\n", "'speed_km_h' is \"fast\" in line 3"),
        ("time_s,speed_km_h\n0,0\n1\n", "'speed_km_h' is \"\" in line 3"),
        ("time_s,speed_km_h\n0,0\n1,nan\n", "must be a number"),
        ("time_s,speed_km_h\n0,0\n2,5\n2,6\n", "times that increase"),
        ("time_s,speed_km_h\n1,0\n2,5\n", "first point at time 0"),
        ("time_s,speed_km_h\n0,0\n2,-5\n", "speeds from 0"),
        ("time_s,speed_km_h\n0,0\n2,0\n", "a speed above 0"),
        ("time_s,speed_km_h\n0,0\n", "2 to"),
        ("time_s,speed_km_h\n0,0\n9000,5\n", "end within"),
    ],
)
def test_a_bad_file_is_reported_in_one_sentence(tmp_path: Path, content: str, said: str):
    file = tmp_path / "bad.csv"
    file.write_text(content, encoding="utf-8")
    with pytest.raises(InputError) as reported:
        load_drive_cycle(file)
    assert said in str(reported.value)
    assert "bad.csv" in str(reported.value)
    assert "\n" not in str(reported.value)


def test_files_that_cannot_be_read_are_reported(tmp_path: Path):
    with pytest.raises(InputError, match=r"none\.csv does not exist"):
        load_drive_cycle(tmp_path / "none.csv")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        load_drive_cycle(tmp_path / "folder.csv")
    (tmp_path / "bytes.csv").write_bytes(b"time_s,speed_km_h\n\xff\xfe")
    with pytest.raises(InputError, match="not text in UTF-8"):
        load_drive_cycle(tmp_path / "bytes.csv")
    with pytest.raises(InputError, match="the nearest is 'ece-15'"):
        load_drive_cycle("ece15")
