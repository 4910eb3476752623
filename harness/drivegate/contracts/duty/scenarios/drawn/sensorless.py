"""Drawn runs of a drive without a position sensor."""

from __future__ import annotations

from hypothesis import strategies as st

from drivegate.contracts.duty.scenarios.drawn.steps import Drawn, shares_between, speeds_between
from drivegate.contracts.duty.scenarios.sensorless import (
    LOADED_SHARE,
    WELL_ABOVE,
    flying_start,
    least_loaded_rpm,
    least_rpm,
    lost_rotor,
    overloaded,
    sensorless_load_step,
    sensorless_reversal,
    sensorless_start,
    slowly_loaded,
)
from drivegate.contracts.duty.scenarios.unsensed import fastest_taken_over_rpm
from drivegate.scenarios.changes import with_scales
from drivegate.scenarios.rotation import mirrored
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.limits import FAILURE_SPEED_SHARE
from drivegate_cases.drive.pm_ac.sensorless import START_TORQUE


def _speeds(drive: PmAcDocument, factor: float) -> st.SearchStrategy[float]:
    """Draw a speed from a multiple of the least one to the highest (rpm)."""
    least, highest = least_rpm(drive, factor), drive.rating.highest_speed_rpm
    return st.one_of(st.just(least), speeds_between(drive, least, max(least, highest)))


def _signs() -> st.SearchStrategy[float]:
    return st.sampled_from((1.0, -1.0))


def sensorless_start_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw starts from any angle of the rotor to 2 to 4 times the least speed, under up to half of rated torque."""
    return st.builds(
        lambda angle, share, factor: sensorless_start(drive, least_rpm(drive, factor), share, angle),
        st.integers(0, 359).map(float),
        shares_between(0.0, START_TORQUE),
        st.sampled_from((2.0, 3.0, 4.0)),
    )


def sensorless_load_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw loads of -80 to 80 % of rated torque that come on slowly, from the least speed to the highest.

    A load drives the shaft up to base speed.
    """
    base = drive.rating.base_speed_rpm
    return st.builds(
        lambda speed, sign, share: slowly_loaded(
            drive, sign * (speed if share >= 0.0 else min(speed, base)), share
        ),
        _speeds(drive, 1.0),
        _signs(),
        shares_between(-LOADED_SHARE, LOADED_SHARE),
    )


def sensorless_load_step_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw steps of the load of up to 80 % of rated torque, from twice the least speed on."""
    highest = drive.rating.highest_speed_rpm
    step = shares_between(0.1, LOADED_SHARE).flatmap(
        lambda share: st.tuples(
            st.just(share), speeds_between(drive, min(least_loaded_rpm(drive, share), highest), highest)
        )
    )
    return st.builds(lambda pair, sign: sensorless_load_step(drive, sign * pair[1], pair[0]), step, _signs())


def sensorless_reversal_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw reversals between 4 times the least speed and base speed, under up to half of rated torque."""
    least, base = least_rpm(drive, 2.0 * WELL_ABOVE), drive.rating.base_speed_rpm
    return st.builds(
        lambda speed, sign, share: sensorless_reversal(drive, sign * speed, share),
        speeds_between(drive, min(least, base), base),
        _signs(),
        shares_between(0.0, START_TORQUE),
    )


def flying_start_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw shafts that turn at 5 to 100 % of the highest speed, from the least speed on, at any angle."""
    highest = drive.rating.highest_speed_rpm
    return st.builds(
        lambda speed, sign, angle: flying_start(drive, sign * speed, angle),
        speeds_between(drive, max(least_rpm(drive), 0.05 * highest), fastest_taken_over_rpm(drive)),
        _signs(),
        st.integers(0, 359).map(float),
    )


def lost_rotor_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw shafts up to base speed: locked before a start or under a load, or stopped by an overload."""
    base = drive.rating.base_speed_rpm
    least = max(least_rpm(drive, WELL_ABOVE), FAILURE_SPEED_SHARE * base)
    speeds = speeds_between(drive, min(least, base), base)
    locked = st.builds(
        lambda speed, share, at_rest: lost_rotor(drive, speed, share, from_standstill=at_rest),
        speeds,
        shares_between(0.3, 0.6),
        st.booleans(),
    )
    stopped = st.builds(
        lambda speed, sign: mirrored(overloaded(drive, speed)) if sign < 0.0 else overloaded(drive, speed),
        speeds,
        _signs(),
    )
    return st.one_of(locked, stopped)


def sensorless_parameter_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw another resistance, magnet or inductance under a slow load, from twice the least speed to base speed."""
    others = st.one_of(
        st.tuples(st.just("resistance"), st.integers(14, 26).map(lambda part: round(0.05 * part, 2))),
        st.tuples(st.just("emf_constant"), st.integers(18, 21).map(lambda part: round(0.05 * part, 2))),
        st.tuples(st.just("inductance"), st.integers(16, 24).map(lambda part: round(0.05 * part, 2))),
    )
    return st.builds(
        lambda other, speed, share: with_scales(
            slowly_loaded(drive, min(speed, drive.rating.base_speed_rpm), share), **{other[0]: other[1]}
        ),
        others,
        _speeds(drive, WELL_ABOVE),
        shares_between(-LOADED_SHARE, LOADED_SHARE),
    )
