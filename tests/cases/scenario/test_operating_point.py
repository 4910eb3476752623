import json
from collections.abc import Callable
from typing import Any

import pytest

from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.operating_point import (
    OperatingPoint,
    PowerSweep,
    load_operating_point,
    load_power_sweep,
    operating_point_names,
    power_sweep_names,
)


@pytest.mark.parametrize(
    ("name", "speed", "torque", "advance"),
    [
        ("fig6-torque-1500", 1500.0, 9.8, 52.0),
        ("fig9-currents-1200", 1200.0, 11.88, 40.0),
        ("fig10-currents-1500", 1500.0, 9.8, 58.0),
    ],
)
def test_the_published_points(name: str, speed: float, torque: float, advance: float) -> None:
    point = load_operating_point(name)
    assert (point.speed_rpm, point.torque_nm, point.advance_deg) == (speed, torque, advance)


def test_every_point_and_sweep_loads_under_its_name_and_says_where_it_is_published() -> None:
    for name in operating_point_names():
        assert load_operating_point(name).name == name
        assert load_operating_point(name).source
    for name in power_sweep_names():
        assert load_power_sweep(name).name == name
        assert load_power_sweep(name).source


def test_the_sweep_of_fig_7_covers_the_range_of_constant_power() -> None:
    sweep = load_power_sweep("fig7-input-current")
    assert (sweep.speeds_rpm[0], sweep.speeds_rpm[-1], sweep.power_w) == (550.0, 2000.0, 1500.0)
    assert 1500.0 in sweep.speeds_rpm
    assert sweep.torque_at(1500.0) == pytest.approx(9.549, abs=1e-3)


POINT = {"schema": 1, "name": "p", "speed_rpm": 1500, "torque_nm": 9.8, "advance_deg": 52}
SWEEP = {"schema": 1, "name": "s", "speeds_rpm": [500, 1000], "power_w": 1500}


@pytest.mark.parametrize(
    ("mapping", "model", "changes", "reported"),
    [
        (POINT, OperatingPoint, {"advance_deg": 90.1}, "the key 'advance_deg' is 90.1"),
        (POINT, OperatingPoint, {"advance_deg": -1}, "the key 'advance_deg' is -1"),
        (POINT, OperatingPoint, {"speed_rpm": 0}, "the key 'speed_rpm' is 0"),
        (POINT, OperatingPoint, {"torque_nm": float("inf")}, "the key 'torque_nm' is Infinity"),
        (POINT, OperatingPoint, {"advance_rad": 1}, "the nearest known key is 'advance_deg'"),
        (SWEEP, PowerSweep, {"speeds_rpm": []}, "the key 'speeds_rpm' is [], but must have at least 1 item"),
        (SWEEP, PowerSweep, {"speeds_rpm": [2, 1]}, "must have strictly increasing speeds"),
        (SWEEP, PowerSweep, {"speeds_rpm": [1, "x"]}, "the key 'speeds_rpm[1]' is \"x\""),
        (SWEEP, PowerSweep, {"power_w": 0}, "the key 'power_w' is 0"),
    ],
)
def test_a_wrong_key_is_reported(
    refusal: Callable[..., str], mapping: dict[str, Any], model: Any, changes: dict[str, Any], reported: str
) -> None:
    assert reported in refusal(parse_document, mapping | changes, model, "here")


@pytest.mark.parametrize("load", [load_operating_point, load_power_sweep])
def test_an_unknown_name_is_reported_with_what_there_is(
    refusal: Callable[..., str], load: Callable[[str], object]
) -> None:
    message = refusal(load, "fig6")
    assert "is called 'fig6', the nearest is 'fig" in message


def test_points_and_sweeps_survive_a_round_trip() -> None:
    point = parse_document(POINT, OperatingPoint, "here")
    assert parse_document(json.loads(point.to_json()), OperatingPoint, "there") == point
    sweep = parse_document(SWEEP, PowerSweep, "here")
    assert parse_document(json.loads(sweep.to_json()), PowerSweep, "there") == sweep
