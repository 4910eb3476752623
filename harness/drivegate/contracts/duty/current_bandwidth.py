"""The time of a step that follows from the current bandwidth which a candidate declares, and what may be declared."""

from __future__ import annotations

from decimal import Decimal
from math import ceil, floor, pi
from typing import Final

from drivegate.candidates.declaration import Declaration
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.errors import InputError

REMAINING: Final = 0.1
"""Share of a step of the currents that remains where 90 % of it are reached (1)."""
_TRANSIENT_PERIODS: Final = 100
_TRANSIENT_RISES: Final = 3.0
_OBSERVED_PERIODS: Final = 2.0
"""Control periods that sampling and the mean over a period add to the delay of the drive."""
_DETOUR: Final = 1.8
"""Time of a large step over that with all of the voltage straight from one end to the other: no regulator takes just
that way (1)."""
_MOST_FACTOR: Final = 10.0
"""Time of a step that a declaration may ask for over that of the drive's requirements (1)."""
OF_ONE_LEG: Final = 2.0 / 3.0
"""Phase voltage over that of one leg (1)."""
_PHASE_LEFT: Final = 0.5 * pi
"""Phase that a loop of one integrator has left for its delay (rad)."""


def declared_rise_s(
    drive: PmAcDocument, bandwidth: float, remaining: float = REMAINING, voltage_time: float = 0.0
) -> float:
    """Return the longest time in which a loop of a bandwidth (rad/s) brings the currents near the end of a step (s).

    The loop is of first order, behind the drive's delay. `remaining`: share of the step that is left then.
    `voltage_time`: time in which all of the voltage moves the currents (s); a loop that asks for more is slowed by it.
    """
    limited = max(bandwidth * voltage_time, 1.0)
    # The voltage is used up until the loop asks for less; from there on the currents approach their end.
    used_up = min(limited - 1.0, limited * (1.0 - remaining))
    approached = max(_logarithm(1.0 / (limited * remaining)), 0.0)
    return (used_up + approached) / bandwidth + _delay_s(drive)


def limited_rise_s(drive: PmAcDocument, remaining: float, voltage_time: float, straight_time: float) -> float:
    """Return the longest time of a step of the torque (s) by the drive's own requirement, which states no bandwidth.

    A small step has `rise_periods`, from which the bandwidth of a loop of first order follows. A greater one has as
    long as this loop takes with the voltage that there is, and never more than both times together. `voltage_time`:
    with the voltage that both ends leave; `straight_time`: with all of it, straight from one end to the other (s).
    """
    rise = drive.requirements.rise_periods * drive.control_period_s
    together = float(rise + voltage_time)
    bandwidth = _required_bandwidth(drive)
    if bandwidth is None:
        return together
    limited = declared_rise_s(drive, bandwidth, min(remaining, REMAINING), _DETOUR * straight_time)
    return min(together, limited)


def _required_bandwidth(drive: PmAcDocument) -> float | None:
    """Return the bandwidth of a loop of first order with the drive's own rise time (rad/s); None if it is all delay."""
    approach = drive.requirements.rise_periods * drive.control_period_s - _delay_s(drive)
    return _logarithm(1.0 / REMAINING) / approach if approach > 0.0 else None


def lost_share(drive: PmAcDocument, bandwidth: float | None, flux: float) -> float:
    """Return the share of a step by which its end is off while dead time and drops are not learnt (1).

    The sign of a current near zero is unknown, and with it what its leg loses. A loop is off by what moves the flux
    linkage by as much voltage. `bandwidth`: of the loop (rad/s), None for that of the drive's requirement; `flux`:
    change of the flux linkage (V s).
    """
    bandwidth = bandwidth or _required_bandwidth(drive)
    return 0.0 if bandwidth is None else OF_ONE_LEG * drive.inverter.lost_voltage_v / (bandwidth * flux)


def _logarithm(number: float) -> float:
    """Return a natural logarithm that every processor rounds identically, which libraries in C do not."""
    return float(Decimal(number).ln())


def _delay_s(drive: PmAcDocument) -> float:
    return (drive.inverter.update_delay + _OBSERVED_PERIODS) * drive.control_period_s


def require_bandwidth(drive: PmAcDocument, bandwidth: float) -> None:
    """Refuse a bandwidth (rad/s) that no loop can have at the drive's delay, or that asks for too much time."""
    period, rise = drive.control_period_s, drive.requirements.rise_periods
    least = ceil(_logarithm(1.0 / REMAINING) / (_MOST_FACTOR * rise * period - _delay_s(drive)))
    greatest = floor(_PHASE_LEFT / ((drive.inverter.update_delay + 0.5) * period))
    if not least <= bandwidth <= greatest:
        raise InputError(
            f"the key 'current_bandwidth_rad_s' is {bandwidth:g}, but on the drive '{drive.name}' must be from "
            f"{least} to {greatest}: a slower loop takes more than {_MOST_FACTOR:g} times the drive's "
            f"rise_periods of {rise:g}, and a faster one is unstable at its control period of {1e6 * period:.4g} µs"
        )


def transient_periods(drive: PmAcDocument, declaration: Declaration) -> int:
    """Return the control periods after a step that belong to it; what changes later is a choice of currents."""
    if declaration.current_bandwidth is None:
        return _TRANSIENT_PERIODS
    rise = declared_rise_s(drive, declaration.current_bandwidth)
    return max(_TRANSIENT_PERIODS, ceil(_TRANSIENT_RISES * rise / drive.control_period_s))
