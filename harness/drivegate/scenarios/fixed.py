"""The scenarios that every check runs first, whatever the seed."""

from __future__ import annotations

from drivegate.scenarios.building import base_speed_scenario, steady_scenario, vehicle_scenario
from drivegate.scenarios.changes import (
    CHANGE_S,
    pulsed,
    stepped,
    with_drift,
    with_dropout,
    with_glitch,
    with_imbalance,
    with_load_shares,
    with_mcs96,
    with_scales,
    with_speed,
    with_supply,
)
from drivegate.scenarios.speed_range import SpeedRange, loaded_range
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario, load_scenario


def fixed_scenarios(drive: DriveDocument, speed_range_rpm: SpeedRange | None = None) -> tuple[Scenario, ...]:
    """List the scenarios that every check runs first."""
    every = (
        *(load_scenario(name).replaced(drive=drive) for name in ("lock-up", "fig5-search")),
        *_steady(drive),
        base_speed_scenario(drive, 300.0, 520.0, 5.0),
        base_speed_scenario(drive, 480.0, 520.0, 8.0),
        *_changing(drive),
        *_other_plants(drive),
        *_other_sensors(drive),
        *_faults(drive),
    )
    if speed_range_rpm is None:
        return every
    lowest, highest = loaded_range(drive, speed_range_rpm)
    inside = tuple(
        scenario
        for scenario in every
        if all(speed_range_rpm[0] <= speed <= speed_range_rpm[1] for _, speed in scenario.speed_rpm)
    )
    middle = steady_scenario(drive, round(0.5 * (lowest + highest)), power_share=0.5, constant_power=False)
    return inside or (middle,)


def _steady(drive: DriveDocument) -> list[Scenario]:
    rated = [_rated(drive, speed) for speed in (550.0, 700.0, 900.0, 1150.0, 1350.0, 1500.0)]
    beyond = [_rated(drive, speed) for speed in (1750.0, 2000.0)]
    half = [_torque(drive, speed, 0.5) for speed in (600.0, 1000.0, 1500.0)]
    return [*rated, *half, *beyond]


def _rated(drive: DriveDocument, speed_rpm: float) -> Scenario:
    return steady_scenario(drive, speed_rpm, power_share=1.0, constant_power=True)


def _torque(drive: DriveDocument, speed_rpm: float, share: float) -> Scenario:
    return steady_scenario(drive, speed_rpm, power_share=share, constant_power=False)


def _changing(drive: DriveDocument) -> list[Scenario]:
    steps = ((0.5, 1.0), (1.0, 0.5))
    return [
        *(with_load_shares(_torque(drive, 1500.0, 1.0), (0.0, a), (CHANGE_S, b)) for a, b in steps),
        *(with_load_shares(_rated(drive, 900.0), (0.0, a), (CHANGE_S, b)) for a, b in steps),
        with_speed(_torque(drive, 1400.0, 0.6), stepped(900.0, 1400.0, CHANGE_S)),
        with_speed(_torque(drive, 1400.0, 0.6), stepped(1400.0, 900.0, CHANGE_S, over_s=2.0)),
        # Long at the current limit, which a regulator without anti-windup does not survive.
        with_speed(_torque(drive, 1500.0, 0.8), stepped(600.0, 1500.0, CHANGE_S)),
        with_supply(_torque(drive, 1500.0, 0.8), pulsed(1.0, 0.9, CHANGE_S, 0.5)),
        with_supply(_rated(drive, 1150.0), stepped(1.0, 0.92, CHANGE_S)),
        vehicle_scenario(
            drive,
            1000.0,
            mass_kg=200.0,
            gear_ratio=4.0,
            grade_percent=((0.0, 0.0), (CHANGE_S, 0.0), (CHANGE_S, 3.0)),
        ),
    ]


def _other_plants(drive: DriveDocument) -> list[Scenario]:
    return [
        with_scales(_rated(drive, 700.0), resistance=2.0),
        with_scales(_rated(drive, 700.0), inductance=1.2),
        with_scales(_rated(drive, 700.0), emf_constant=0.95),
        with_scales(_torque(drive, 1500.0, 0.8), friction_added_n_m=0.5),
    ]


def _other_sensors(drive: DriveDocument) -> list[Scenario]:
    return [
        with_mcs96(_rated(drive, 700.0), seed=1),
        with_mcs96(_torque(drive, 1100.0, 0.5), seed=2),
        with_mcs96(_torque(drive, 1500.0, 1.0), seed=3),
    ]


def _faults(drive: DriveDocument) -> list[Scenario]:
    return [
        with_dropout(_torque(drive, 1500.0, 0.8), "speed", CHANGE_S, 0.01),
        with_glitch(with_mcs96(_torque(drive, 1000.0, 0.8), seed=4), 20, CHANGE_S),
        with_imbalance(_torque(drive, 1200.0, 0.8), stepped(0.0, 0.03, CHANGE_S)),
        with_drift(
            _torque(drive, 1300.0, 0.9),
            resistance=stepped(1.0, 1.4, 2.0, over_s=8.0),
            emf_constant=stepped(1.0, 0.95, 2.0, over_s=8.0),
        ),
    ]
