"""Drives from 1 W to 10 MW, 1 to 100 pole pairs and 1 rpm to 200,000 rpm: each document, each plan and a run."""

from __future__ import annotations

from math import isfinite, pi, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.duty.scenarios.building import share_scenario
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.drives.abilities import refusals
from drivegate.drives.duty_ability import duty_envelope
from drivegate.drives.running import recorded
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.document import PmAcDocument

PERIODS = 25.0
"""Control periods in an electrical period at the highest speed, at least."""
HIGHEST_CONTROL_HZ = 500e3
SLOWEST_HZ = 4e3
REACTANCE, RESISTANCE, EMF, POWER, MECHANICAL_S, RANGE = 0.5, 0.05, 0.6, 0.5, 0.2, 1.3
"""Values per unit of the voltage, the current limit and base speed."""


def machine(power_w: float, pairs: int, base_rpm: float) -> PmAcDocument:
    """Make a drive of a size, with the values per unit of usual ones."""
    speed = base_rpm * pi / 30.0
    link = min(max(12.0, 4.0 * sqrt(power_w)), 6000.0)
    voltage = link / sqrt(3.0)
    current = power_w / (POWER * 1.5 * voltage)
    impedance, electrical = voltage / current, pairs * speed
    values: dict[str, Any] = {
        "schema": 1,
        "name": "sized",
        "kind": "pm-ac",
        "machine": {
            "pole_pairs": pairs,
            "resistance_ohm": RESISTANCE * impedance,
            "direct_inductance_h": REACTANCE * impedance / electrical,
            "quadrature_inductance_h": REACTANCE * impedance / electrical,
            "magnet_flux_v_s": EMF * voltage / electrical,
            "inertia_kg_m2": MECHANICAL_S * power_w / (speed * speed),
        },
        "inverter": {
            "link_voltage_v": link,
            "carrier_frequency_hz": max(SLOWEST_HZ, PERIODS * RANGE * electrical / (2.0 * pi)),
        },
        "rating": {
            "base_speed_rpm": base_rpm,
            "highest_speed_rpm": RANGE * base_rpm,
            "overspeed_rpm": 1.1 * RANGE * base_rpm,
            "rated_power_w": power_w,
            "current_limit_a": current,
        },
    }
    drive = parse_document(values, DriveDocument, "a size")
    assert isinstance(drive, PmAcDocument)
    return drive


@st.composite
def sizes(draw: st.DrawFn) -> tuple[float, int, float]:
    """Draw power, pole pairs and base speed, evenly by ratio, with a field that an inverter can turn."""
    power = 10.0 ** draw(st.floats(0.0, 7.0))
    pairs = draw(st.integers(1, 100))
    fastest = min(200e3, 60.0 * HIGHEST_CONTROL_HZ / (PERIODS * RANGE * pairs))
    return power, pairs, min(10.0 ** draw(st.floats(0.0, np.log10(fastest))), fastest)


@given(sizes())
@settings(max_examples=25, deadline=None, derandomize=True)
def test_a_drive_of_any_size_can_be_judged(size: tuple[float, int, float]) -> None:
    drive = machine(*size)
    assert refusals(drive) == ()
    assert len(fixed_scenarios(drive)) > 50


CORNERS = [
    (1.0, 1, 1.0),
    (1.0, 1, 200e3),
    (1.0, 100, 9e3),
    (1e7, 1, 200e3),
    (1e7, 1, 1.0),
    (1e7, 100, 1.0),
    (1.55e6, 52, 17.8),
]


@pytest.mark.parametrize("size", CORNERS)
def test_what_a_drive_can_do_is_finite_and_foc_gives_its_torque(size: tuple[float, int, float]) -> None:
    drive = machine(*size)
    points = duty_envelope(drive)["points"]
    assert all(value is None or isfinite(value) for point in points for value in point.values())
    base = drive.rating.base_speed_rpm
    scenario = share_scenario(drive, 0.5 * base, 0.0, 0.5)
    loaded = own_candidate(resolve_candidate("foc"))
    torque = recorded(loaded, scenario, loaded.controller()).run.column("torque")
    wanted = 0.5 * drive.rating.rated_torque_nm
    assert torque[-len(torque) // 10 :].mean() == pytest.approx(wanted, rel=0.02)
