"""The scenarios of a PM AC drive that every check runs first, whatever the seed."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Final

from drivegate.contracts.duty.scenarios.beyond import backward_beyond_scenarios, beyond_scenarios
from drivegate.contracts.duty.scenarios.building import (
    dwell_periods,
    edge_positions,
    failing,
    hoist_scenario,
    lifted_scenario,
    load_step_scenario,
    most_false_edges,
    restarted,
    share_scenario,
    slow_torque,
    speed_and_load_step_scenario,
    speed_scenario,
    start_s,
    stop_scenario,
    supply_step_scenario,
    torque_of,
    torque_scenario,
    vanishing_load_scenario,
    with_edges,
    with_false_edges,
    with_fan,
    with_lost_samples,
    with_position_errors,
)
from drivegate.contracts.duty.scenarios.drawn_range import BEYOND_SHARE, SLOW_SHARE, speed_of
from drivegate.contracts.duty.scenarios.hot import hot_scenarios
from drivegate.contracts.duty.scenarios.linked import linked_scenarios
from drivegate.contracts.duty.scenarios.rare import nightly_scenarios, rare_scenarios
from drivegate.contracts.duty.scenarios.released import free_shaft_scenarios
from drivegate.contracts.duty.scenarios.sensorless import sensorless_scenarios
from drivegate.scenarios.changes import with_real_sensors, with_scales
from drivegate.scenarios.drive_scale import rated_torque_at, tidy
from drivegate.scenarios.rotation import mirrored, needs_reverse
from drivegate.scenarios.title import titled
from drivegate_cases.drive.limits import rounded
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.limits import FAILURE_SPEED_SHARE
from drivegate_cases.scenario.failure_kind import FailureKind
from drivegate_cases.scenario.reference import FollowedReference, reference_of
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.pm_ac.rectifying import rectifies
from drivegate_models.units import RADIANS_PER_RPM

START_ANGLES_DEG: Final = tuple(15.0 * number for number in range(24))
"""Angles of the rotor that a start is tried from (electrical degrees)."""
LATE_CLOCK_S: Final = 2147.4
"""Time that the controller's clock shows at first, just before 2³¹ µs have passed (s)."""
TURNING_PERIODS: Final = 5_000_000
"""Control periods of the turns before a run of any effort, which take less than a second (1)."""
MANY_TURNS: Final = 1_000_000
"""Turns before a run that takes long (1)."""
START_SPEED_SHARE: Final = 0.2
"""Speed of a start over base speed (1)."""
START_TORQUE_SHARE: Final = 0.5
"""Load of a start over rated torque (1)."""
FAILURE_TIME_SHARE: Final = 0.6
"""When something fails, over the run's length (1)."""
GONE_PERIODS: Final = 1000
"""Control periods for which a load vanishes: too few for a steady state, whatever the carrier."""
DEAD_TIME_SPEED_SHARE: Final = 0.08
"""Speed at which dead time is looked at, over base speed (1)."""


def fixed_scenarios(
    drive: PmAcDocument,
    references: Collection[FollowedReference] = ("speed", "torque"),
    detected: Collection[FailureKind] = (),
    *,
    reverses: bool = True,
) -> tuple[Scenario, ...]:
    """List those of the references, and of the failures that a candidate detects; both ways only if it reverses.

    Speeds are shares of the drive's range, torques shares of the rated one.
    """
    reverses = reverses and drive.one_way_because is None
    every = (
        tuple(sensorless_scenarios(drive))
        if not drive.has_sensor
        else _every(drive, detected, reverses=reverses)
    )
    followed = [
        scenario
        for scenario in reversed(every)
        if reference_of(scenario) in references and (reverses or not needs_reverse(scenario))
    ]
    return tuple(dict.fromkeys(followed))[::-1]


def _every(drive: PmAcDocument, detected: Collection[FailureKind], *, reverses: bool) -> tuple[Scenario, ...]:
    """List the fixed runs of a drive with a position sensor."""
    return (
        *_torques(drive),
        *_speeds(drive),
        *_slow_speeds(drive),
        *efficiency_scenarios(drive),
        *_starts(drive),
        *_other_plants(drive),
        *_sensed(drive),
        *_disturbed(drive),
        *_at_once(drive),
        *(beyond_scenarios(drive) if drive.weakens else ()),
        *free_shaft_scenarios(drive),
        turned_scenario(drive),
        *hot_scenarios(drive),
        *linked_scenarios(drive),
        *(_backward(drive) if reverses else ()),
        *rare_scenarios(drive, reverses=reverses),
        *(run for run in _failures(drive) if run.failure is not None and run.failure.kind in detected),
    )


def _sensed(drive: PmAcDocument) -> list[Scenario]:
    slow, fast = speed_of(drive, -0.5), speed_of(drive, 0.4)
    runs = [
        speed_scenario(drive, (slow, fast), torque_nm=torque_of(drive, fast, 0.5)),
        share_scenario(drive, slow, 0.2, 0.8),
    ]
    return [with_real_sensors(run, seed) for seed, run in enumerate(runs, start=1)]


def _failures(drive: PmAcDocument) -> list[Scenario]:
    slow, base = speed_of(drive, FAILURE_SPEED_SHARE - 1.0), speed_of(drive, 0.0)
    torques = [share_scenario(drive, speed, 0.5) for speed in (slow, base)]
    sensed = [*torques, *(with_real_sensors(run, 1) for run in torques)]
    kinds: tuple[FailureKind, ...] = ("open-phase", "stuck-current")
    kinds += ("lost-position",) if drive.has_sensor else ()
    by_edges = [with_edges(run, position, 1) for run in torques for position in edge_positions(drive)]
    turning = speed_scenario(drive, (base,), torque_nm=torque_of(drive, base, 0.5))
    start = speed_scenario(drive, (base,), torque_nm=torque_of(drive, base, 0.5), initial_speed_rpm=0.0)
    return [
        *(failing(run, kind, FAILURE_TIME_SHARE * run.duration_s) for kind in kinds for run in sensed),
        failing(turning, "locked-rotor", FAILURE_TIME_SHARE * turning.duration_s),
        failing(start, "locked-rotor", 0.0),
        *(
            failing(run, "slip", FAILURE_TIME_SHARE * run.duration_s, slip_deg=slip)
            for run, slip in zip(torques, (60.0, -60.0), strict=True)
            if drive.position == "exact"
        ),
        *(failing(run, "lost-edge", FAILURE_TIME_SHARE * run.duration_s) for run in by_edges),
    ]


def _torques(drive: PmAcDocument) -> list[Scenario]:
    found = [share_scenario(drive, speed_of(drive, at), 0.0, 0.9, 0.5, 0.1, 0.0) for at in (-0.5, 0.5)]
    found += [share_scenario(drive, speed_of(drive, at), 0.0, -0.6, -1.0, 0.4) for at in (-0.7, 0.0, 0.5)]
    held = (share_scenario(drive, speed_of(drive, 0.2), part) for part in (0.7, -0.7))
    found += [supply_step_scenario(run, drive, (1.0, 0.85, 1.15)) for run in held]
    if drive.weakens:
        found += [release_scenario(drive, share) for share in (0.05, 0.25, 0.5, 1.0)]
    found.append(share_scenario(drive, speed_of(drive, DEAD_TIME_SPEED_SHARE - 1.0), 0.2, 0.5, 0.9))
    slow = (speed_of(drive, -0.7), 0.0)
    return [*found, *(share_scenario(drive, speed, 0.0, 0.2, 0.0, 0.5, 0.3, -0.3) for speed in slow)]


def release_scenario(drive: PmAcDocument, share: float = 1.0) -> Scenario:
    """Make the run that asks for more than weakening can give at a speed above base speed, and then for nothing."""
    return share_scenario(drive, speed_of(drive, share), 0.0, BEYOND_SHARE, 0.0)


def range_scenario(drive: PmAcDocument) -> Scenario:
    """Make the run from half of base speed to the highest speed and back, without a load."""
    slow = speed_of(drive, -0.5)
    return speed_scenario(drive, (slow, speed_of(drive, 1.0), slow))


def _speeds(drive: PmAcDocument) -> list[Scenario]:
    slow, fast, top = speed_of(drive, -0.5), speed_of(drive, 0.5), speed_of(drive, 1.0)
    at_fast = torque_of(drive, fast, 0.8)
    near, below = speed_of(drive, -0.05), speed_of(drive, -0.6)
    return [
        range_scenario(drive),
        speed_scenario(drive, (slow, fast), torque_nm=torque_of(drive, fast, 0.6)),
        load_step_scenario(drive, slow, torque_of(drive, slow, 0.8), (0.0, 1.0, 0.5)),
        load_step_scenario(drive, fast, at_fast, (0.0, 1.0, 0.25)),
        load_step_scenario(drive, top, torque_of(drive, top, 0.8), (0.0, 1.0, 0.0)),
        supply_step_scenario(load_step_scenario(drive, fast, at_fast, (1.0,)), drive, (1.0, 0.9, 1.1)),
        vanishing_load_scenario(
            drive, near, torque_of(drive, near, 0.5), GONE_PERIODS * drive.control_period_s
        ),
        with_fan(speed_scenario(drive, (below, fast, below), torque_nm=at_fast)),
        *(_beyond_highest(drive) if drive.weakens else ()),
    ]


def _beyond_highest(drive: PmAcDocument) -> list[Scenario]:
    """Make the run whose speed steps begin and end above the highest speed."""
    rating = drive.rating
    highest, beyond = rating.highest_speed_rpm, rating.overspeed_rpm - rating.highest_speed_rpm
    first, second = (tidy(highest + share * beyond) for share in (0.2, 0.8))
    return [speed_scenario(drive, (first, second, first), torque_nm=torque_of(drive, second, 0.5))]


def _slow_speeds(drive: PmAcDocument) -> list[Scenario]:
    """Make the runs that end at low speed: steady and loaded, from standstill, and after a stop."""
    slowest, slow = (tidy(share * drive.rating.base_speed_rpm) for share in (SLOW_SHARE, 5.0 * SLOW_SHARE))
    return [
        load_step_scenario(drive, slowest, slow_torque(drive, slowest), (0.0, 1.0)),
        speed_scenario(drive, (slow,), torque_nm=slow_torque(drive, slow), initial_speed_rpm=0.0),
        speed_scenario(drive, (speed_of(drive, -0.5), 0.0, slow)),
        stop_scenario(drive, speed_of(drive, 0.0), start_s(drive, dwell_periods(drive)), slow),
    ]


def _disturbed(drive: PmAcDocument) -> list[Scenario]:
    """Make the runs in which the controller restarts, its clock passes 31 bits, or samples and edges are wrong."""
    slow, fast = speed_of(drive, -0.5), speed_of(drive, 0.3)
    torque = share_scenario(drive, slow, 0.6)
    speed = speed_scenario(drive, (fast,), torque_nm=torque_of(drive, fast, 0.5))
    base = speed_of(drive, 0.0)
    speed_at_base = speed_scenario(drive, (base,), torque_nm=torque_of(drive, base, 0.5))
    edges = most_false_edges(drive)
    by_encoder = drive.position in ("exact", "encoder") and edges > 0
    return [
        restarted(torque, (0.5,)),
        restarted(speed, (0.5,)),
        restarted(torque, (), LATE_CLOCK_S),
        with_lost_samples(torque, ("currents", *(("speed",) if drive.has_sensor else ()), "supply"), (0.1,)),
        *(_off_position(drive, torque, speed_at_base) if drive.position == "exact" else ()),
        *([with_false_edges(torque, edges, 0.1, 1)] if by_encoder else []),
    ]


def _at_once(drive: PmAcDocument) -> list[Scenario]:
    """Make the runs in which two things happen in the same control period: reference or load, and something else."""
    slow, fast = speed_of(drive, -0.5), speed_of(drive, 0.3)
    torques = share_scenario(drive, slow, 0.2, 0.8, -0.5)
    step = share_scenario(drive, slow, 0.6, 0.3)
    load = load_step_scenario(drive, fast, torque_of(drive, fast, 0.7), (0.3, 1.0))
    return [
        _seen_with_reference(drive, supply_step_scenario(torques, drive, (1.0, 0.85, 1.1))),
        with_lost_samples(step, ("currents",), (0.5,)),
        _seen_with_reference(drive, supply_step_scenario(load, drive, (1.0, 0.9))),
        restarted(load, (0.5,)),
        speed_and_load_step_scenario(drive, (slow, fast), torque_of(drive, fast, 0.7), (0.2, 1.0)),
    ]


def _seen_with_reference(drive: PmAcDocument, run: Scenario) -> Scenario:
    """Have the source step a control period earlier where the link follows it: its first change is sensed at once."""
    if drive.real_link is None or run.supply_v is None:
        return run
    period = drive.control_period_s
    steps = ((max(rounded(time - period, 9), 0.0), volts) for time, volts in run.supply_v)
    return titled(run.replaced(supply_v=tuple(steps)))


def turned_scenario(drive: PmAcDocument, turns: int | None = None) -> Scenario:
    """Make the run of a shaft that has turned fast for long, before a step of the torque."""
    plant, fast = drive.plant(), speed_of(drive, 0.5)
    if rectifies(plant, fast * RADIANS_PER_RPM, plant.link_voltage):
        # The run begins with the current of the diodes, the turns before it without.
        fast = speed_of(drive, 0.0)
    run = share_scenario(drive, fast, 0.0, 0.6)
    seen = TURNING_PERIODS * drive.control_period_s * fast / 60.0
    return titled(run.replaced(turns_before=int(rounded(seen, 2)) if turns is None else turns))


def long_scenarios(
    drive: PmAcDocument, references: Collection[FollowedReference] = ("speed", "torque")
) -> tuple[Scenario, ...]:
    """List the fixed runs that take long: those of some minutes, and that of a shaft that has made a million turns."""
    turned = (turned_scenario(drive, MANY_TURNS),) if "torque" in references else ()
    return (*nightly_scenarios(drive, references), *turned)


def _off_position(drive: PmAcDocument, torque: Scenario, speed: Scenario) -> tuple[Scenario, Scenario]:
    """See the shaft of two runs by a position sensor with errors of 3 electrical degrees each."""
    part_deg = tidy(3.0 / drive.machine.pole_pairs)
    part = round(math.radians(3.0) / drive.machine.pole_pairs, 4)
    return (
        with_position_errors(torque, 1, eccentricity_deg=part_deg, sine_offset=part),
        with_position_errors(speed, 1, track_gain=part, track_phase_deg=part_deg),
    )


def _backward(drive: PmAcDocument) -> list[Scenario]:
    """Make the runs backward and through standstill: torques, loads, starts, low speed, a hoist, and sensors."""
    slow, fast, top = speed_of(drive, -0.5), speed_of(drive, 0.5), speed_of(drive, 1.0)
    slowest = tidy(2.0 * SLOW_SHARE * drive.rating.base_speed_rpm)
    torques = (
        share_scenario(drive, slow, 0.9, 0.4, -0.7),
        share_scenario(drive, fast, 0.7, -0.7),
        *([release_scenario(drive, 0.5)] if drive.weakens else ()),
    )
    start = speed_of(drive, START_SPEED_SHARE - 1.0)
    speeds = (
        load_step_scenario(drive, top, torque_of(drive, top, 0.8), (0.0, 1.0, 0.0)),
        load_step_scenario(drive, slowest, slow_torque(drive, slowest), (0.0, 1.0)),
        speed_scenario(
            drive,
            (start,),
            torque_nm=torque_of(drive, start, START_TORQUE_SHARE),
            initial_speed_rpm=0.0,
            initial_angle_deg=45.0,
        ),
    )
    reversal = speed_scenario(drive, (slow, -slow), torque_nm=torque_of(drive, slow, 0.5))
    return [
        *(mirrored(run) for run in (*torques, *speeds)),
        reversal,
        with_real_sensors(reversal, 1),
        hoist_scenario(drive, (slow, -slow), torque_of(drive, slow, 0.6)),
        *(backward_beyond_scenarios(drive) if drive.weakens else ()),
    ]


def efficiency_scenarios(drive: PmAcDocument) -> list[Scenario]:
    """Make the runs through the eight efficiency points; rated torque at base speed comes last."""
    rated = rated_torque_at(drive, 0.0)
    return [
        torque_scenario(
            drive, tidy(speed * drive.rating.base_speed_rpm), tuple(tidy(part * rated) for part in parts)
        )
        for speed, parts in ((0.0, (0.25, 0.5, 1.0)), (0.5, (0.25, 0.5, 1.0)), (1.0, (0.5, 1.0)))
    ]


def _starts(drive: PmAcDocument) -> list[Scenario]:
    speed = speed_of(drive, START_SPEED_SHARE - 1.0)
    torque = torque_of(drive, speed, START_TORQUE_SHARE)
    return [
        speed_scenario(drive, (speed,), torque_nm=torque, initial_speed_rpm=0.0, initial_angle_deg=angle)
        for angle in START_ANGLES_DEG
    ]


def _other_plants(drive: PmAcDocument) -> list[Scenario]:
    slow, fast = speed_of(drive, -0.5), speed_of(drive, 0.4)
    runs = [
        speed_scenario(drive, (slow, fast), torque_nm=torque_of(drive, fast, 0.5)),
        load_step_scenario(drive, slow, torque_of(drive, slow, 0.6), (0.0, 1.0)),
    ]
    changes = ({"resistance": 0.5}, {"resistance": 2.0}, {"inductance": 0.7}, {"inductance": 1.3})
    fluxes = ({"emf_constant": 0.8}, {"emf_constant": 1.05})
    others = [with_scales(run, **change) for change in (*changes, *fluxes) for run in runs]
    inertias = [
        speed_scenario(drive, (slow, after), torque_nm=torque_of(drive, fast, 0.5), inertia_factor=factor)
        for factor in (0.3, 2.0)
        for after in (fast, speed_of(drive, -0.45))
    ]
    lifted = lifted_scenario(drive, fast, torque_of(drive, fast, 0.7), (2.0, 0.3), initial_speed_rpm=slow)
    return [*others, *inertias, lifted]
