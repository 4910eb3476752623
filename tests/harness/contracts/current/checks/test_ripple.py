"""Checks of the torque ripple: that of the ideal regulator at a candidate's angle, and that of its closed loop."""

import math

import numpy as np
import pytest

from drivegate.contracts.current.checks import ripple
from drivegate_models.steady.oracle import TorquePoint, feasible_edge, point_at_torque

RATED = {"kind": "constant_power", "power_w": 1500.0, "factor": [[0.0, 1.0]]}


@pytest.fixture
def with_ripple(monkeypatch):
    """Let the steady state of the ideal regulator have a given ripple, at a mean torque of 1 N·m."""

    def with_ripple(value: float) -> None:
        def point(*_arguments, **_keywords) -> TorquePoint:
            known = {"static": True, "torque": 1.0, "torque_lowest": 0.0, "torque_highest": value}
            numbers = {name: 1.0 for name in TorquePoint._fields if name not in ("robust", "certified")}
            return TorquePoint(robust=True, certified=True, **{**numbers, **known})

        monkeypatch.setattr(ripple, "point_at_torque", point)

    return with_ripple


@pytest.mark.parametrize(("check", "changes"), [("RIP-1", {}), ("RIP-2", {"load": RATED})])
def test_ripple_of_the_ideal_regulator_stays_below_its_limit(
    record, scenario, checks, with_ripple, check, changes
):
    run = record(scenario(**changes))
    with_ripple(np.nextafter(0.13, 0.0))
    assert checks[check].evaluate(run).met
    with_ripple(0.13)
    assert not checks[check].evaluate(run).met


def test_ripple_is_that_of_the_angle_and_torque_converged_to(record, checks):
    run = record(window={"ANGLE": math.radians(54.0), "TORQUE": 9.7})
    ideal = run.drive._replace(hysteresis_band=0.0)
    point = point_at_torque(ideal, 1500.0 * math.pi / 30.0, math.radians(54.0), 9.7)
    expected = (point.torque_highest - point.torque_lowest) / point.torque
    margin = checks["RIP-1"].evaluate(run)
    assert margin.value == pytest.approx(1.0 - expected / 0.13, abs=1e-12)
    assert margin.measured == f"{100 * expected:.2f} % at 54.00°, 1500 rpm and 9.7 N·m"


def test_an_angle_that_cannot_give_the_torque_fails(record, checks):
    margin = checks["RIP-1"].evaluate(record(window={"ANGLE": math.radians(30.0)}))
    assert not margin.met
    assert margin.measured == "the torque is out of reach at 30.00°, 1500 rpm and 9.8 N·m"


def test_an_angle_on_the_feasible_edge_is_not_out_of_reach_by_rounding(record, checks):
    run = record(window={"ANGLE": math.radians(54.0)})
    ideal = run.drive._replace(hysteresis_band=0.0)
    edge = feasible_edge(ideal, 1500.0 * math.pi / 30.0, 9.8)
    for torque, met in ((9.8 * (1.0 + 1e-4), True), (9.8 * (1.0 + 5e-3), False)):
        margin = checks["RIP-1"].evaluate(record(window={"ANGLE": edge, "TORQUE": torque}))
        assert margin.met is met, margin


def test_where_only_a_band_holds_the_torque_the_ripple_is_the_bands(record, checks, monkeypatch):
    run = record(window={"ANGLE": math.radians(54.0), "TORQUE": 9.7})
    held = point_at_torque(run.drive, 1500.0 * math.pi / 30.0, math.radians(54.0), 9.7)

    def point(drive, *arguments) -> TorquePoint:
        found = point_at_torque(drive, *arguments)
        return found if drive.hysteresis_band > 0.0 else found._replace(static=False)

    monkeypatch.setattr(ripple, "point_at_torque", point)
    margin = checks["RIP-1"].evaluate(run)
    expected = (held.torque_highest - held.torque_lowest) / held.torque
    assert margin.measured == f"{100 * expected:.2f} % at 54.00°, 1500 rpm and 9.7 N·m"


@pytest.mark.parametrize(
    "changes",
    [
        {"speed_rpm": [[0.0, 1499.0]]},
        {"supply_v": [[0.0, 47.0]]},
        {"load": {"kind": "constant_torque", "torque_nm": 9.79, "factor": [[0.0, 1.0]]}},
    ],
)
def test_the_published_point_is_no_other(record, scenario, checks, changes):
    assert checks["RIP-1"].evaluate(record(scenario(**changes))) is None


@pytest.mark.parametrize(("speed_rpm", "applies"), [(549.0, False), (550.0, True), (1501.0, False)])
def test_ripple_under_constant_power_is_judged_over_its_range(
    record, scenario, checks, with_ripple, speed_rpm, applies
):
    with_ripple(0.1)
    run = record(scenario(load=RATED, speed_rpm=[[0.0, speed_rpm]]))
    assert (checks["RIP-2"].evaluate(run) is not None) == applies


def test_ripple_of_the_closed_loop_stays_below_its_limit(record, assert_limit):
    assert_limit("RIP-3", record(window={"RIPPLE": np.nextafter(0.2, 0.0)}), record(window={"RIPPLE": 0.2}))


def test_below_rated_torque_the_ripple_of_the_closed_loop_is_only_advised(record, scenario, checks):
    rated = 1500.0 / (1500.0 * math.pi / 30.0)
    for torque, advisory in ((rated, False), (rated * (1.0 - 1e-5), True), (0.1, True)):
        load = {"kind": "constant_torque", "torque_nm": torque, "factor": [[0.0, 1.0]]}
        margin = checks["RIP-3"].evaluate(record(scenario(load=load), window={"RIPPLE": 0.5}))
        assert margin.advisory == advisory, f"at {torque} N·m"
        assert not margin.met


def test_more_ripple_at_light_load_does_not_hide_that_of_rated_torque(record, scenario, checks):
    load = {"kind": "constant_torque", "torque_nm": 9.8, "factor": [[0, 0.5], [10, 0.5], [10, 1.0]]}
    run = record(scenario(duration_s=20.0, load=load), windows=[{"RIPPLE": 0.9}, {"RIPPLE": 0.15}])
    margin = checks["RIP-3"].evaluate(run)
    assert margin.met
    assert not margin.advisory


def test_an_unloaded_stretch_has_no_ripple_to_judge(record, scenario, checks):
    load = {"kind": "constant_torque", "torque_nm": 9.8, "factor": [[0.0, 0.0]]}
    assert checks["RIP-3"].evaluate(record(scenario(load=load), window={"RIPPLE": 9.0})) is None
