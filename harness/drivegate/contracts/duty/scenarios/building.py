"""Plain runs of a PM AC drive from few numbers: torque references on a dynamometer, speed references under a load."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import accumulate, pairwise
from typing import Final

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.drawn_range import slow_load_share
from drivegate.contracts.duty.scenarios.windows import WINDOW_SHARE, is_held, run_up_s, settling_s
from drivegate.scenarios.changes import in_steps
from drivegate.scenarios.drive_scale import rated_torque_at, tidy
from drivegate.scenarios.title import titled
from drivegate_cases.drive.document import Position
from drivegate_cases.drive.limits import rounded
from drivegate_cases.drive.plant import Scales
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.control_periods import first_period_from, period_start_s
from drivegate_cases.scenario.courses import Drift
from drivegate_cases.scenario.disturbance import Dropout, Glitch
from drivegate_cases.scenario.failure_kind import FailureKind
from drivegate_cases.scenario.load import ConstantTorqueLoad, DynamometerLoad, FanLoad, HoistLoad
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import EDGES_A_LINE, SHUNTS

TORQUE_DIGITS: Final = 4
"""Digits that torques are rounded to."""
FALSE_ANGLE_DEG: Final = 3.0
"""Angle that false edges of an encoder may turn the rotor's frame by (electrical degrees)."""
LOST_APART: Final = 20
"""Control periods from the lost sample of one signal to that of the next (1)."""
PERIODS_AT_A_TIME: Final = 10
"""Control periods that the lengths of stretches are whole numbers of (1)."""


def torque_of(drive: PmAcDocument, speed_rpm: float, share: float) -> float:
    """Return a share of rated torque at a speed (N·m)."""
    return rounded(share * rated_torque_at(drive, speed_rpm), TORQUE_DIGITS)


def slow_torque(drive: PmAcDocument, speed_rpm: float, share: float = 1.0) -> float:
    """Return a share of the load that a speed regulator must bear at low speed, which grows with the speed (N·m)."""
    return torque_of(drive, speed_rpm, share * slow_load_share(speed_rpm, drive))


def dwell_periods(
    drive: PmAcDocument, speed_change_rpm: float = 0.0, inertia_factor: float = 1.0, *, held: bool = False
) -> int:
    """Return the control periods after a change in which a steady state is reached and judged."""
    settling = settling_s(drive, held=held)
    time = (1.0 + WINDOW_SHARE) * settling + run_up_s(drive, speed_change_rpm, inertia_factor)
    return PERIODS_AT_A_TIME * math.ceil(round(time / (PERIODS_AT_A_TIME * drive.control_period_s), 6))


def start_s(drive: PmAcDocument, period: int) -> float:
    """Return when a control period begins (s)."""
    return period_start_s(period, drive.control_period_s)


def _ends_of_dwells(drive: PmAcDocument, count: int, *, held: bool) -> list[float]:
    """Return the ends of dwells of equal length (s)."""
    return [start_s(drive, number * dwell_periods(drive, held=held)) for number in range(1, count + 1)]


def torque_scenario(drive: PmAcDocument, speed_rpm: float, torques_nm: Sequence[float]) -> Scenario:
    """Make a run at a held speed through steps of the torque reference, each long enough to be judged."""
    *times, end = _ends_of_dwells(drive, len(torques_nm), held=True)
    return titled(
        Scenario(
            name="torque",
            drive=drive,
            duration_s=end,
            initial_speed_rpm=speed_rpm,
            speed_rpm=((0.0, speed_rpm),),
            load=DynamometerLoad(kind="dynamometer", torque_reference_nm=in_steps(torques_nm, times)),
        )
    )


def share_scenario(drive: PmAcDocument, speed_rpm: float, *shares: float) -> Scenario:
    """Make a run at a held speed through steps of the torque reference, in shares of rated torque there."""
    return torque_scenario(drive, speed_rpm, [torque_of(drive, speed_rpm, share) for share in shares])


def speed_scenario(
    drive: PmAcDocument,
    speeds_rpm: Sequence[float],
    *,
    torque_nm: float = 0.0,
    factor: Profile = ((0.0, 1.0),),
    initial_speed_rpm: float | None = None,
    initial_angle_deg: float = 0.0,
    inertia_factor: float = 1.0,
) -> Scenario:
    """Make a run through steps of the speed reference under a constant torque, each long enough to be judged."""
    begin = speeds_rpm[0] if initial_speed_rpm is None else initial_speed_rpm
    ways = [after - before for before, after in pairwise((begin, *speeds_rpm))]
    periods = accumulate(dwell_periods(drive, way, inertia_factor) for way in ways)
    *times, end = (start_s(drive, period) for period in periods)
    return titled(
        Scenario(
            name="speed",
            drive=drive,
            duration_s=end,
            initial_speed_rpm=begin,
            initial_angle_deg=initial_angle_deg,
            speed_rpm=in_steps(speeds_rpm, times),
            load=ConstantTorqueLoad(kind="constant_torque", torque_nm=torque_nm, factor=factor),
            scales=Scales(inertia=inertia_factor),
        )
    )


def load_step_scenario(
    drive: PmAcDocument,
    speed_rpm: float,
    torque_nm: float,
    shares: Sequence[float],
    *,
    initial_speed_rpm: float | None = None,
    inertia_factor: float = 1.0,
) -> Scenario:
    """Make a run at one speed reference through steps of the load, each long enough to be judged."""
    begin = speed_rpm if initial_speed_rpm is None else initial_speed_rpm
    each, first = dwell_periods(drive), dwell_periods(drive, speed_rpm - begin, inertia_factor)
    *times, end = (start_s(drive, first + number * each) for number in range(len(shares)))
    steady = speed_scenario(
        drive, (speed_rpm,), torque_nm=torque_nm, initial_speed_rpm=begin, inertia_factor=inertia_factor
    )
    load = steady.load.model_copy(update={"factor": in_steps(shares, times)})
    return titled(steady.replaced(duration_s=end, load=load))


def lifted_scenario(
    drive: PmAcDocument,
    speed_rpm: float,
    torque_nm: float,
    inertia_factors: tuple[float, float],
    *,
    initial_speed_rpm: float | None = None,
) -> Scenario:
    """Make a run in which a driven wheel is lifted from the ground and set down: its load goes and comes back.

    `inertia_factors`: on the inertia at the shaft, with the wheel on the ground, and lifted.
    """
    grounded, lifted = inertia_factors
    run = load_step_scenario(
        drive,
        speed_rpm,
        torque_nm,
        (1.0, 0.0, 1.0),
        initial_speed_rpm=initial_speed_rpm,
        inertia_factor=grounded,
    )
    inertia = tuple((time, 1.0 if share > 0.0 else lifted / grounded) for time, share in run.load_profile)
    return titled(run.replaced(drift=Drift(inertia=inertia)))


def stop_scenario(drive: PmAcDocument, fast_rpm: float, wait_s: float, slow_rpm: float) -> Scenario:
    """Make a run that stops, waits at standstill, and goes on slowly."""
    stops = dwell_periods(drive)
    waited = math.ceil(round((run_up_s(drive, fast_rpm) + wait_s) / drive.control_period_s, 6))
    goes_on = stops + waited
    profile = in_steps((fast_rpm, 0.0, slow_rpm), (start_s(drive, stops), start_s(drive, goes_on)))
    end = goes_on + dwell_periods(drive, slow_rpm)
    return titled(
        speed_scenario(drive, (fast_rpm,)).replaced(duration_s=start_s(drive, end), speed_rpm=profile)
    )


def vanishing_load_scenario(
    drive: PmAcDocument, speed_rpm: float, torque_nm: float, gone_s: float
) -> Scenario:
    """Make a run at one speed reference whose load vanishes for a moment."""
    begin = start_s(drive, dwell_periods(drive))
    gone = _period_from(begin + gone_s, drive.control_period_s)
    steady = speed_scenario(drive, (speed_rpm,), torque_nm=torque_nm)
    load = steady.load.model_copy(update={"factor": in_steps((1.0, 0.0, 1.0), (begin, gone))})
    end = round(gone / drive.control_period_s) + dwell_periods(drive)
    return titled(steady.replaced(duration_s=start_s(drive, end), load=load))


def with_fan(run: Scenario) -> Scenario:
    """Replace a constant torque by a fan that demands it at the greatest speed of the run, and at base speed at least.

    A fan that is loaded at low speed damps the shaft so much that a regulator of its speed takes long.
    """
    load = run.load
    assert isinstance(load, ConstantTorqueLoad), "a fan replaces a constant torque"
    fastest = max(run.drive.rating.base_speed_rpm, *(abs(speed) for _, speed in run.speed_rpm))
    fan = FanLoad(kind="fan", torque_nm=load.torque_nm, speed_rpm=fastest, factor=load.factor)
    return titled(run.replaced(load=fan))


def hoist_scenario(
    drive: PmAcDocument, speeds_rpm: Sequence[float], torque_nm: float, shares: Sequence[float] = (1.0,)
) -> Scenario:
    """Make a run through steps of the speed reference, or of the share of a hoist's weight at one."""
    if len(shares) > 1:
        run = load_step_scenario(drive, speeds_rpm[0], torque_nm, shares)
    else:
        run = speed_scenario(drive, speeds_rpm, torque_nm=torque_nm, factor=((0.0, shares[0]),))
    load = HoistLoad(kind="hoist", torque_nm=torque_nm, factor=run.load_profile)
    return titled(run.replaced(load=load))


def speed_and_load_step_scenario(
    drive: PmAcDocument, speeds_rpm: tuple[float, float], torque_nm: float, shares: tuple[float, float]
) -> Scenario:
    """Make a run whose load steps in the very control period in which its speed reference does."""
    run = speed_scenario(drive, speeds_rpm, torque_nm=torque_nm, factor=((0.0, shares[0]),))
    factor = in_steps(shares, (run.speed_rpm[-1][0],))
    return titled(run.replaced(load=run.load.model_copy(update={"factor": factor})))


def restarted(run: Scenario, shares: Sequence[float], clock_start_s: float = 0.0) -> Scenario:
    """Reset the controller at shares of a run's length, and let its clock begin anywhere."""
    times = _times_s(run, shares)
    return _settling_after(times, run.replaced(restarts_s=times, clock_start_s=clock_start_s))


def with_lost_samples(
    run: Scenario, signals: Sequence[str], shares: Sequence[float], phase: int | None = None
) -> Scenario:
    """Lose single samples of signals, one after the other, at shares of a run's length."""
    times, period = _times_s(run, shares), run.control_period_s
    lost = [
        {
            "signal": signal,
            "phase": phase,
            "start_s": time + number * LOST_APART * period,
            "duration_s": period,
        }
        for time in times
        for number, signal in enumerate(signals)
    ]
    dropouts = tuple(map(Dropout.model_validate, lost))
    return _settling_after([one.end_s for one in dropouts], run.replaced(dropouts=dropouts))


def with_false_edges(run: Scenario, counts: int, share: float, seed: int) -> Scenario:
    """See the shaft of a run by an encoder that counts false edges at a share of its length."""
    times = _times_s(run, (share,))
    glitches = tuple(Glitch(time_s=time, counts=counts) for time in times)
    return _settling_after(times, with_edges(run, "encoder", seed).replaced(glitches=glitches))


def with_position_errors(run: Scenario, seed: int, **errors: float) -> Scenario:
    """See the shaft of a run by a sensor without edges that has errors."""
    return titled(run.replaced(sensors=SHUNTS.model_copy(update={"position": "exact", **errors}), seed=seed))


def _times_s(run: Scenario, shares: Sequence[float]) -> tuple[float, ...]:
    """Return the starts of the control periods at shares of a run's length (s)."""
    return tuple(_period_from(share * run.duration_s, run.control_period_s) for share in shares)


def _period_from(time_s: float, period_s: float) -> float:
    """Return the start of the first control period from a time on (s)."""
    return period_start_s(first_period_from(time_s, period_s), period_s)


def _settling_after(times_s: Sequence[float], run: Scenario) -> Scenario:
    """Go on with a run for as long as it takes to settle after the last of some times."""
    drive = duty_document(run.drive)
    periods = round(max(times_s, default=0.0) / run.control_period_s) + dwell_periods(
        drive, held=is_held(run)
    )
    return titled(run.replaced(duration_s=max(run.duration_s, start_s(drive, periods))))


def most_false_edges(drive: PmAcDocument) -> int:
    """Return the false edges of an encoder that no controller without an index has to notice."""
    electrical = 360.0 * drive.machine.pole_pairs / (EDGES_A_LINE * SHUNTS.encoder_lines)
    return int(FALSE_ANGLE_DEG / electrical)


def failing(
    run: Scenario, kind: FailureKind, time_s: float, phase: int = 1, slip_deg: float | None = None
) -> Scenario:
    """Make something fail in a run, at the start of the first control period from a time on."""
    time = _period_from(time_s, run.control_period_s)
    return titled(run.replaced(failure={"kind": kind, "time_s": time, "phase": phase, "slip_deg": slip_deg}))


def edge_positions(drive: PmAcDocument) -> tuple[Position, ...]:
    """Return what may show edges of the shaft that can be lost: what the drive states, or else any kind."""
    if not drive.has_sensor:
        return ()
    return ("encoder", "hall") if drive.position == "exact" else (drive.position,)


def with_edges(run: Scenario, position: Position, seed: int) -> Scenario:
    """See the shaft of a run by the edges of an encoder, or of Hall switches."""
    sensors = SHUNTS.model_copy(update={"position": position})
    return titled(run.replaced(sensors=sensors, seed=seed))


def supply_step_scenario(base: Scenario, drive: PmAcDocument, shares: Sequence[float]) -> Scenario:
    """Make a run at one operating point through steps of the link's voltage, each long enough to be judged."""
    *times, end = _ends_of_dwells(drive, len(shares), held=is_held(base))
    volts = [tidy(share * drive.inverter.supply_voltage_v) for share in shares]
    return titled(base.replaced(duration_s=end, supply_v=in_steps(volts, times)))
