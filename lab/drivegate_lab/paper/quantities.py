"""Published numbers beside ours."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.drives.running import run_scenario
from drivegate_cases.documents.document import parse_document
from drivegate_cases.documents.wording import significant
from drivegate_cases.publication import Fact, Quantity
from drivegate_cases.scenario.operating_point import load_operating_point
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.paper.drives import ideal_drive, reference_drive
from drivegate_lab.paper.figures.instantaneous_torque import ADVANCE_DEG, torque_cycle
from drivegate_lab.paper.figures.phase_currents import POINTS
from drivegate_lab.paper.figures.speed_limit import speed_limit
from drivegate_lab.paper.verdicts import ComparedStatement, Number, Verdict
from drivegate_models.controllers.current.builtin import SEARCHES
from drivegate_models.steady.oracle import feasible_edge, point_at_torque
from drivegate_models.steady.steady_state import steady_state
from drivegate_models.units import RADIANS_PER_RPM


@dataclass(frozen=True)
class Ours:
    """A value of ours for a published quantity."""

    value: float
    """In the quantity's unit."""
    note: str = ""
    """How it was had."""
    given: bool = False
    """Whether it is an input of the model."""
    is_open: bool = False
    """Whether the paper leaves open what exactly is meant."""


def _given(value: float) -> Ours:
    return Ours(value, "input of the model", given=True)


def _rated_power() -> Ours:
    drive = reference_drive()
    speed = drive.rating.base_speed_rpm * RADIANS_PER_RPM
    angles = np.radians(np.arange(0.0, 90.0, 0.25))
    torques = [
        steady_state(ideal_drive(), speed, drive.rating.current_limit_a, angle).torque for angle in angles
    ]
    best = int(np.argmax(torques))
    at = math.degrees(angles[best])
    return Ours(
        torques[best] * speed, f"greatest power at {drive.rating.base_speed_rpm:g} rpm and 26 A, at {at:.2f}°"
    )


def _angle_below_base() -> Ours:
    """Run the published controller through base speed on a dynamometer, and look at what it commands below."""
    base = reference_drive().rating.base_speed_rpm
    ramp = {
        "schema": 1,
        "name": "through base speed",
        "drive": reference_drive().to_mapping(),
        "duration_s": 1.0,
        "speed_rpm": [[0.0, base - 100.0], [1.0, base + 100.0]],
        "load": {"kind": "locked"},
    }
    scenario = parse_document(ramp, Scenario, "the ramp through base speed")
    run = run_scenario(scenario, BuiltinController(SEARCHES["published"]))
    angle = math.degrees(run.observed.angle_below_base)
    return Ours(angle, "greatest angle that `published` commands below base speed, on a ramp through it")


def _necessary_angle(point_name: str) -> Ours:
    point = load_operating_point(point_name)
    edge = feasible_edge(ideal_drive(), point.speed_rpm * RADIANS_PER_RPM, point.torque_nm)
    return Ours(math.degrees(edge), f"smallest angle that gives {point.torque_nm:g} N·m at the current limit")


def _fig10_angle() -> Ours:
    point = load_operating_point("fig10-currents-1500")
    speed = point.speed_rpm * RADIANS_PER_RPM
    found = point_at_torque(ideal_drive(), speed, math.radians(point.advance_deg), point.torque_nm)
    edge = _necessary_angle("fig10-currents-1500").value
    return Ours(
        point.advance_deg,
        f"{'feasible' if found.robust else 'not feasible'}, with Σ|i| {found.current_sum:.1f} A; the smallest "
        f"feasible angle is {edge:.1f}°. The paper does not say whether 58° is an initial or an optimal angle",
        is_open=True,
    )


def _ripple() -> Ours:
    point = load_operating_point("fig6-torque-1500")
    found = torque_cycle(point.advance_deg)
    beside = torque_cycle(ADVANCE_DEG)
    return Ours(
        found.ripple_percent,
        f"peak to peak over mean at {point.advance_deg:g}° and {point.torque_nm:g} N·m; "
        f"{beside.ripple_percent:.1f} % at {ADVANCE_DEG:g}°",
    )


def _speed_ratio() -> Ours:
    data = speed_limit()
    edge = data.edge_deg[data.speed_rpm == data.reached_rpm][0]
    return Ours(
        data.reached_rpm / data.base_speed_rpm,
        f"1.5 kW is within reach at {data.reached_rpm:.0f} rpm from {edge:.1f}° on; looked no further",
    )


def _angle_of_greatest_speed() -> Ours:
    data = speed_limit()
    return Ours(
        90.0,
        f"no greatest speed is stated; ours gives the greatest power at 90° from {data.ninety_from_rpm:.0f} rpm on, "
        f"but still {data.power_at_90_w[-1]:.0f} W at {data.speed_rpm[-1]:.0f} rpm",
        is_open=True,
    )


_OURS: Final[Mapping[tuple[str, str], Callable[[], Ours]]] = {
    ("P1", "phases"): lambda: _given(reference_drive().machine.phases),
    ("P1", "poles"): lambda: _given(2 * reference_drive().machine.pole_pairs),
    ("P1", "shift between neighbouring phases"): lambda: _given(180.0 / reference_drive().machine.phases),
    ("P1", "conduction in each half cycle"): lambda: _given(reference_drive().inverter.window_deg),
    ("P2", "voltage of one half of the supply"): lambda: _given(reference_drive().inverter.supply_voltage_v),
    ("P2", "switches"): lambda: _given(2 * reference_drive().machine.phases),
    ("P3", "rated power"): _rated_power,
    ("P3", "base speed"): lambda: _given(reference_drive().rating.base_speed_rpm),
    ("P3", "rated phase current"): lambda: _given(reference_drive().rating.current_limit_a),
    ("P5", "speed below which the angle is zero"): lambda: _given(reference_drive().rating.base_speed_rpm),
    ("P5", "angle below that speed"): _angle_below_base,
    ("P7", "speed of Fig. 9"): lambda: _given(load_operating_point(POINTS[0]).speed_rpm),
    ("P7", "torque of Fig. 9"): lambda: _given(load_operating_point(POINTS[0]).torque_nm),
    ("P7", "angle of Fig. 9"): lambda: _necessary_angle("fig9-currents-1200"),
    ("P7", "speed of Fig. 10"): lambda: _given(load_operating_point(POINTS[1]).speed_rpm),
    ("P7", "torque of Fig. 10"): lambda: _given(load_operating_point(POINTS[1]).torque_nm),
    ("P7", "angle of Fig. 10"): _fig10_angle,
    ("P8", "necessary angle at 1500 rpm"): lambda: _necessary_angle("fig6-torque-1500"),
    ("P8", "torque ripple at 1500 rpm"): _ripple,
    ("P10", "angle of the greatest speed"): _angle_of_greatest_speed,
    ("P10", "greatest speed over base speed"): _speed_ratio,
}


def quantity_keys() -> frozenset[tuple[str, str]]:
    """List the published quantities of the paper's own drive, which have a value of ours."""
    return frozenset(_OURS)


def compared(fact: Fact, quantity: Quantity) -> ComparedStatement:
    """Compare one published quantity with what the models give."""
    ours = _OURS[fact.id, quantity.name]()
    relation = {"equal": "", "at_most": "at most ", "at_least": "at least "}[quantity.bound]
    bounded = quantity.bound != "equal"
    known = not ours.is_open
    if ours.is_open:
        verdict: Verdict = "open in the paper"
    elif ours.given:
        verdict = "taken as given"
    else:
        verdict = "reproduced" if quantity.agrees(ours.value) else "not reproduced"
    at_least = "at least " if quantity.bound == "at_least" else ""
    return ComparedStatement(
        fact=fact.id,
        quantity=quantity.name,
        published=relation + _with_unit(quantity.value, quantity.unit),
        ours=at_least + _with_unit(ours.value, quantity.unit) if known else "–",
        residual=_difference(ours.value - quantity.value, quantity.unit) if known else "",
        tolerance="a limit" if bounded else _tolerance(quantity),
        verdict=verdict,
        note=ours.note,
        numbers=(
            Number("published", quantity.value, quantity.unit),
            *([Number("ours", ours.value, quantity.unit)] if known else []),
        ),
    )


def _tolerance(quantity: Quantity) -> str:
    if quantity.tolerance is None:
        return ""
    return "exact" if quantity.tolerance == 0.0 else f"± {_with_unit(quantity.tolerance, quantity.unit)}"


def _with_unit(value: float, unit: str) -> str:
    gap = "" if unit in ("", "deg") else " "
    return f"{value:.4g}{gap}{'°' if unit == 'deg' else unit}"


def _difference(value: float, unit: str) -> str:
    text = _with_unit(significant(value, 2), unit)
    return f"+{text}" if value > 0.0 else text.replace("-", "−")
