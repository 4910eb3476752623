"""Check of the torque ripple at the published worst point."""

from __future__ import annotations

import math

from drivegate.check import Check
from drivegate.margin import Margin
from drivegate.run_record import RunRecord
from drivegate_cases.load import ConstantTorqueLoad
from drivegate_models import observation
from drivegate_models.oracle import point_at_torque

LARGEST_RIPPLE = 0.13
"""Limit of the peak-to-peak ripple over the mean torque (paper, Fig. 6)."""
RIPPLE_SPEED_RPM = 1500.0
"""Speed of the published point (rpm)."""
RIPPLE_TORQUE_NM = 9.8
"""Torque of the published point (N m)."""


def ripple_at_converged_angle(record: RunRecord) -> Margin | None:
    """Judge the torque ripple at the angle that the candidate converged to (paper, Fig. 6).

    The ripple is that of the periodic steady state with the ideal regulator (no band) at the candidate's mean
    angle and mean torque; its extremes are exact.

    Parameters
    ----------
    record : RunRecord
        The run.

    Returns
    -------
    Margin or None
        None where the run is not at the published point.
    """
    load = record.scenario.load
    if not isinstance(load, ConstantTorqueLoad) or load.torque_nm != RIPPLE_TORQUE_NM:
        return None
    windows = [
        window
        for window in record.windows()
        if window.dwell.speed_rpm == RIPPLE_SPEED_RPM and window.dwell.load_factor == 1.0
    ]
    if not windows:
        return None
    window = windows[-1]
    angle = float(window.values[observation.WINDOW_ANGLE])
    torque = float(window.values[observation.WINDOW_TORQUE])
    ideal = record.drive._replace(hysteresis_band=0.0)
    point = point_at_torque(ideal, window.speed, min(max(angle, 0.0), math.pi / 2.0), torque)
    where = f"at {math.degrees(angle):.2f}° and {torque:.3g} N·m"
    if not point.static:
        return Margin("RIP-1", -1.0, f"the torque is out of reach {where}")
    ripple = (point.torque_highest - point.torque_lowest) / point.torque
    return Margin("RIP-1", 1.0 - ripple / LARGEST_RIPPLE, f"{100.0 * ripple:.2f} % {where}")


RIP_1 = Check(
    "RIP-1",
    "Torque ripple at 1500 rpm and 9.8 N·m, ideal regulator, at the angle that the candidate converged to.",
    "P8",
    "candidate",
    "required",
    "13 % peak to peak over mean",
    "the published point, 1500 rpm and 9.8 N·m",
    ripple_at_converged_angle,
)
