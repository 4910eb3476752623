"""Drawn changes of the torque, the speed, the load and the link's voltage."""

from __future__ import annotations

from collections.abc import Callable

from hypothesis import strategies as st

from drivegate.contracts.duty.scenarios.building import (
    hoist_scenario,
    load_step_scenario,
    share_scenario,
    slow_torque,
    speed_scenario,
    stop_scenario,
    supply_step_scenario,
    torque_of,
    vanishing_load_scenario,
    with_fan,
)
from drivegate.contracts.duty.scenarios.drawn.steps import (
    Drawn,
    any_speed,
    shares_between,
    speeds_between,
    speeds_up_to_base,
    turning_speeds,
)
from drivegate.contracts.duty.scenarios.drawn_range import (
    BEYOND_SHARE,
    BRAKING_SHARE,
    HEAVIEST_FAILURE_SHARE,
    HEAVIEST_SHARE,
    SHARE_STEP,
    SLOW_SHARE,
)
from drivegate.contracts.duty.scenarios.unsensed import fastest_taken_over_rpm
from drivegate.scenarios.drive_scale import tidy
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario


def torque_step_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw steps of the torque reference up to the rated one either way, from standstill to the highest speed."""
    return st.builds(
        lambda shares, speed: share_scenario(drive, speed, *shares),
        st.tuples(
            shares_between(0.0, 1.0), shares_between(-BRAKING_SHARE, 1.0), shares_between(-BRAKING_SHARE, 1.0)
        ),
        any_speed(drive),
    )


def weakening_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw torque references above base speed that ask for more than rated power, and then for nothing."""
    return st.builds(
        lambda share, speed: share_scenario(drive, speed, 0.0, share, 0.0),
        shares_between(1.5, BEYOND_SHARE),
        speeds_between(drive, 1.02 * drive.rating.base_speed_rpm, fastest_taken_over_rpm(drive)),
    )


def speed_step_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw steps between any two speeds under a constant torque of up to 70 % of the rated one."""
    return st.builds(
        lambda share, first, second: speed_scenario(
            drive, (first, second), torque_nm=torque_of(drive, max(first, second), share)
        ),
        shares_between(0.0, 0.7),
        turning_speeds(drive),
        turning_speeds(drive),
    )


def reversal_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw steps from a speed forward to one backward, under a torque or a fan of up to 70 % of rated torque."""

    def made(share: float, first: float, second: float, is_fan: bool) -> Scenario:
        torque = torque_of(drive, max(first, second), share)
        run = speed_scenario(drive, (first, -second), torque_nm=torque)
        return with_fan(run) if is_fan else run

    return st.builds(
        made, shares_between(0.0, 0.7), turning_speeds(drive), turning_speeds(drive), st.booleans()
    )


def hoist_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw a weight of up to 60 % of rated torque, lifted or lowered, that comes on, or reverses between both."""
    heaviest = shares_between(0.1, HEAVIEST_FAILURE_SHARE)
    base = drive.rating.base_speed_rpm

    def made(share: float, first: float, second: float, how: str) -> Scenario:
        torque = torque_of(drive, base, share)
        if how == "reversal":
            return hoist_scenario(drive, (first, -second), torque)
        return hoist_scenario(drive, (first if how == "lift" else -first,), torque, (0.0, 1.0))

    speeds = speeds_up_to_base(drive)
    return st.builds(made, heaviest, speeds, speeds, st.sampled_from(("lift", "lower", "reversal")))


def load_step_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw steps of the load between shares of up to 85 % of rated torque, or a load that vanishes for a moment."""
    steps = st.builds(
        lambda shares, speed: load_step_scenario(drive, speed, torque_of(drive, speed, 1.0), shares),
        st.tuples(shares_between(0.0, HEAVIEST_SHARE), shares_between(0.0, HEAVIEST_SHARE)),
        turning_speeds(drive),
    )
    moments = st.builds(
        lambda share, speed, gone: vanishing_load_scenario(
            drive, speed, torque_of(drive, speed, share), gone
        ),
        shares_between(0.1, HEAVIEST_SHARE),
        turning_speeds(drive),
        st.sampled_from((0.001, 0.01, 0.05, 0.2)),
    )
    return st.one_of(steps, steps, moments)


def low_speed_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw runs that end at 1 to 10 % of base speed: from standstill, a higher speed, or a stop of 0.1 to 3 s.

    The load is up to 20 % of rated torque at the end of this range, and less in proportion to the speed below it.
    """
    base = drive.rating.base_speed_rpm

    def made(share: float, slow: float, fast: float, how: str, wait: float) -> Scenario:
        torque = slow_torque(drive, slow, share)
        if how == "load":
            return load_step_scenario(drive, slow, torque, (0.0, 1.0))
        if how == "start":
            return speed_scenario(drive, (slow,), torque_nm=torque, initial_speed_rpm=0.0)
        if how == "stop":
            return stop_scenario(drive, fast, wait, slow)
        return speed_scenario(drive, (fast, slow))

    return st.builds(
        made,
        st.sampled_from((0.25, 0.5, 0.75, 1.0)),
        st.integers(1, 9).map(lambda percent: tidy(percent * SLOW_SHARE * base)),
        turning_speeds(drive),
        st.sampled_from(("load", "start", "fall", "stop")),
        st.sampled_from((0.1, 0.5, 1.0, 3.0)),
    )


def start_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw starts from standstill at any angle of the rotor, up to base speed under up to 80 % of rated torque."""
    return st.builds(
        lambda angle, share, speed: speed_scenario(
            drive,
            (speed,),
            torque_nm=torque_of(drive, speed, share),
            initial_speed_rpm=0.0,
            initial_angle_deg=angle,
        ),
        st.integers(0, 359).map(float),
        shares_between(0.0, 0.8),
        speeds_up_to_base(drive),
    )


def supply_step_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw steps of the link's voltage within 85 to 115 % of the nominal one, at one operating point."""
    return _supply_steps(
        drive,
        lambda share, speed: load_step_scenario(drive, speed, torque_of(drive, speed, share), (1.0,)),
        shares_between(0.0, 0.8),
        turning_speeds(drive),
    )


def torque_supply_step_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw the same steps under a torque reference of up to the rated torque either way."""
    return _supply_steps(
        drive,
        lambda share, speed: share_scenario(drive, speed, share),
        shares_between(-BRAKING_SHARE, 1.0),
        any_speed(drive),
    )


def _supply_steps(
    drive: PmAcDocument,
    run: Callable[[float, float], Scenario],
    shares: st.SearchStrategy[float],
    speeds: st.SearchStrategy[float],
) -> Drawn:
    """Draw runs from a share of rated torque and a speed, each with two steps of the link's voltage."""
    return st.builds(
        lambda share, levels, speed: supply_step_scenario(
            run(share, speed), drive, (1.0, *(round(1.0 + SHARE_STEP * level, 2) for level in levels))
        ),
        shares,
        st.tuples(st.integers(-3, 3), st.integers(-3, 3)),
        speeds,
    )
