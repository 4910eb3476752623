"""How great the numbers of a scenario may be follows from its drive; small drives keep the same bounds."""

from __future__ import annotations

from typing import Any

import pytest

from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario

SURFACE = load_drive("pm-ac-surface")
WIND = SURFACE.with_overrides(
    [
        "machine.pole_pairs=52",
        "machine.magnet_flux_v_s=3.725",
        "machine.inertia_kg_m2=1940",
        "inverter.link_voltage_v=1200",
        "rating.base_speed_rpm=17.8",
        "rating.highest_speed_rpm=19",
        "rating.overspeed_rpm=20.9",
        "rating.rated_power_w=1.4e6",
        "rating.current_limit_a=3252",
    ]
)
"""A generator of 750 kN·m."""


def scenario(drive: Any, **keys: Any) -> Scenario:
    plain = {"name": "size", "drive": drive, "duration_s": 1.0, "speed_rpm": ((0.0, 5.0),)}
    return Scenario(**(plain | keys))


def dynamometer(torque: float) -> dict[str, Any]:
    return {"kind": "dynamometer", "torque_reference_nm": ((0.0, torque),)}


def constant(torque: float) -> dict[str, Any]:
    return {"kind": "constant_torque", "torque_nm": torque, "factor": ((0.0, 1.0),)}


@pytest.mark.parametrize("load", [dynamometer(-2.3e6), constant(2.3e6)])
def test_three_times_the_torque_of_a_large_drive_is_no_error(load: dict[str, Any]) -> None:
    assert scenario(WIND, load=load).drive == WIND


@pytest.mark.parametrize(
    ("drive", "keys", "words"),
    [
        (
            SURFACE,
            {"load": constant(2e6)},
            "'load.torque_nm' is 2e+06, but must have values of at most 1e+06 N·m",
        ),
        (WIND, {"load": constant(2e7)}, "'load.torque_nm' is 2e+07, but must have values of at most 7.5"),
        (SURFACE, {"load": dynamometer(-2e6)}, "'load.torque_reference_nm' is -2e+06"),
        (SURFACE, {"load": dynamometer(0.0), "scales": {"friction_added_n_m": 2e5}}, "at most 100000 N·m"),
        (
            SURFACE,
            {"load": dynamometer(0.0), "drift": {"friction_n_m": ((0.0, 2e5),)}},
            "'drift.friction_n_m'",
        ),
        (
            SURFACE,
            {"load": {"kind": "constant_power", "power_w": 2e9, "factor": ((0.0, 1.0),)}},
            "'load.power_w' is 2e+09, but must have values of at most 1e+09 W",
        ),
    ],
)
def test_what_no_such_drive_can_meet_is_refused(drive: Any, keys: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match="either way on this drive") as refused:
        scenario(drive, **keys)
    assert words in str(refused.value)
