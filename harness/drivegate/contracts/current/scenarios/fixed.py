"""The scenarios that every check runs first, whatever the seed."""

from __future__ import annotations

from drivegate.contracts.current.scenarios.building import (
    base_speed_scenario,
    coming_on,
    lifted_scenario,
    steady_scenario,
    vehicle_scenario,
)
from drivegate.contracts.current.scenarios.feasibility import coasted_rate
from drivegate.contracts.current.scenarios.rare import rare_scenarios
from drivegate.scenarios.changes import (
    pulsed,
    stepped,
    with_drift,
    with_dropout,
    with_glitch,
    with_imbalance,
    with_load_factor,
    with_load_shares,
    with_real_sensors,
    with_scales,
    with_speed,
    with_supply,
)
from drivegate.scenarios.drive_scale import SpeedRange, loaded_range, scale_of, tidy
from drivegate.scenarios.title import titled
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.requirements import RequiredPoint, points_of
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.scenario import Scenario, load_scenario
from drivegate_cases.scenario.sensors import has_encoder, real_sensors


def fixed_scenarios(drive: DriveDocument, speed_range_rpm: SpeedRange | None = None) -> tuple[Scenario, ...]:
    """List the scenarios that every check runs first; speeds are shares of the drive's range."""
    every = (
        *_required_points(drive),
        *(_rated(drive, share) for share in (0.05, 0.2, 0.4, 0.65, 0.85, 1.0)),
        *(_torque(drive, share, 0.5) for share in (0.1, 0.5, 1.0)),
        *(_beyond(drive, share) for share in (0.5, 1.0)),
        *_base_speed(drive),
        *_changing(drive),
        *_other_plants(drive),
        with_real_sensors(_rated(drive, 0.2), seed=1),
        with_real_sensors(_torque(drive, 0.6, 0.5), seed=2),
        with_real_sensors(_torque(drive, 1.0, 1.0), seed=3),
        *_faults(drive),
        *rare_scenarios(drive),
    )
    # Where a range has few speeds, some are the same.
    every = tuple(dict.fromkeys(reversed(every)))[::-1]
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


def _required_points(drive: DriveDocument) -> list[Scenario]:
    """Run the published cases at the first point that the drive requires, and plain runs at the others."""
    first, *others = points_of(drive)
    return [
        *(_at_point(load_scenario(name), drive, first) for name in ("lock-up", "fig5-search")),
        *(
            titled(_at_point(steady, drive, point))
            for point in others
            for steady in [_torque(drive, 1.0, 1.0)]
        ),
    ]


def _at_point(case: Scenario, drive: DriveDocument, point: RequiredPoint) -> Scenario:
    """Move a run under a constant torque to another operating point."""
    scale, load = scale_of(drive), case.load
    assert isinstance(load, ConstantTorqueLoad), "the published cases have a constant torque"
    stated = _in_words(RequiredPoint(speed_rpm=case.initial_speed_rpm, torque_n_m=load.torque_nm))
    return case.replaced(
        drive=drive,
        description=case.description.replace(stated, _in_words(point)),
        duration_s=max(scale.units(case.duration_s), tidy(scale.load_ramp_s + scale.dwell_s)),
        initial_speed_rpm=point.speed_rpm,
        speed_rpm=((0.0, point.speed_rpm),),
        load=load.model_copy(update={"torque_nm": point.torque_n_m, "factor": coming_on(drive)}),
    )


def _in_words(point: RequiredPoint) -> str:
    return f"{point.speed_rpm:g} rpm and {point.torque_n_m:g} N·m"


def _rated(drive: DriveDocument, speed_share: float) -> Scenario:
    speed = scale_of(drive).speed(speed_share)
    return steady_scenario(drive, speed, power_share=1.0, constant_power=True)


def _beyond(drive: DriveDocument, share: float) -> Scenario:
    speed = scale_of(drive).speed_beyond(share)
    return steady_scenario(drive, speed, power_share=1.0, constant_power=True)


def _torque(drive: DriveDocument, speed_share: float, power_share: float) -> Scenario:
    speed = scale_of(drive).speed(speed_share)
    return steady_scenario(drive, speed, power_share=power_share, constant_power=False)


def _base_speed(drive: DriveDocument) -> list[Scenario]:
    scale = scale_of(drive)
    return [
        base_speed_scenario(
            drive,
            scale.around_base(-below),
            scale.around_base(4),
            coasted_rate(drive, tidy(fall * scale.speed_grain_rpm / scale.time_unit_s)),
        )
        for below, fall in ((40, 1.0), (4, 1.6))
    ]


def _changing(drive: DriveDocument) -> list[Scenario]:
    scale = scale_of(drive)
    at, slow, fast = scale.change_s, scale.speed(0.4), scale.speed(0.9)
    steps = ((0.5, 1.0), (1.0, 0.5))
    return [
        *(with_load_shares(_torque(drive, 1.0, 1.0), (0.0, a), (at, b)) for a, b in steps),
        *(with_load_shares(_rated(drive, 0.4), (0.0, a), (at, b)) for a, b in steps),
        with_speed(_torque(drive, 0.9, 0.6), stepped(slow, fast, at)),
        with_speed(_torque(drive, 0.9, 0.6), stepped(fast, slow, at, over_s=scale.units(2))),
        # Long at the current limit, which a regulator without anti-windup does not survive.
        with_speed(_torque(drive, 1.0, 0.8), stepped(scale.speed(0.1), scale.speed(1.0), at)),
        with_speed(_beyond(drive, 0.8), stepped(scale.speed_beyond(0.3), scale.speed_beyond(0.8), at)),
        with_load_factor(
            _torque(drive, 0.1, 0.5),
            (*coming_on(drive), *pulsed(1.0, 0.0, at, scale.units(0.5))[1:]),
        ),
        with_supply(_torque(drive, 1.0, 0.8), pulsed(1.0, 0.9, at, scale.units(0.5))),
        with_supply(_rated(drive, 0.65), stepped(1.0, 0.92, at)),
        vehicle_scenario(
            drive,
            scale.speed(0.5),
            mass_units=4,
            gear_units=4,
            grade_percent=((0.0, 0.0), (at, 0.0), (at, 3.0)),
        ),
    ]


def _other_plants(drive: DriveDocument) -> list[Scenario]:
    scale = scale_of(drive)
    friction, early, at = scale.friction_claimed_nm, scale.units(4), scale.change_s
    rising = with_speed(_torque(drive, 0.6, 0.7), stepped(scale.speed(0.3), scale.speed(0.6), early))
    return [
        with_scales(_rated(drive, 0.2), resistance=2.0),
        with_scales(_rated(drive, 0.2), inductance=1.2),
        with_scales(_rated(drive, 0.2), emf_constant=0.95),
        with_scales(_torque(drive, 1.0, 0.8), friction_added_n_m=friction),
        lifted_scenario(rising, tidy(at + early), scale.units(1), 0.3),
    ]


def _faults(drive: DriveDocument) -> list[Scenario]:
    scale = scale_of(drive)
    at, early, over = scale.change_s, scale.units(2), scale.units(8)
    return [
        with_dropout(_torque(drive, 1.0, 0.8), "speed", at, tidy(10 * scale.dropout_step_s)),
        *(
            [with_glitch(with_real_sensors(_torque(drive, 0.5, 0.8), seed=4), 20, at)]
            if has_encoder(real_sensors(drive), drive)
            else []
        ),
        *(
            [with_imbalance(_torque(drive, 0.7, 0.8), stepped(0.0, 0.03, at))]
            if drive.has_split_supply
            else []
        ),
        with_drift(
            _torque(drive, 0.8, 0.9),
            resistance=stepped(1.0, 1.4, early, over_s=over),
            emf_constant=stepped(1.0, 0.95, early, over_s=over),
        ),
    ]
