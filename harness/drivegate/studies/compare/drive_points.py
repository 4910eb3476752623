"""What a candidate came to at the operating points of a comparison of drives, alike for every contract."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import hypot
from typing import Any, Final

from drivegate.contracts.duty.scenarios.building import torque_of
from drivegate.contracts.duty.scenarios.fixed import speed_of
from drivegate.studies.compare.compared_drive import ComparedDrive
from drivegate.studies.compare.duty.plan import EFFORTS as DUTY_EFFORTS
from drivegate.studies.compare.engine import Compared
from drivegate.studies.compare.plan import EFFORTS, PlannedRun, operating_speed
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.limits import duty_limits_of
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_models.machine.rotor_frame import SUM_OVER_PEAK

_DIGITS: Final = 6


@dataclass(frozen=True)
class DrivePoint:
    """One operating point of a candidate on a drive."""

    speed_share: float
    """Share of the drive's range by which drives are compared (1)."""
    load_percent: float
    """Load over that of rated power, constant torque below base speed (%)."""
    speed_rpm: float
    torque_nm: float
    """Speed and load (rpm, N·m)."""
    held: bool
    """Whether the candidate holds it."""
    speed_mean_rpm: float
    torque_mean_nm: float
    """Means of the steady stretch (rpm, N·m)."""
    input_power_w: float
    current_sum_a: float
    """Means of input power and Σ|i| (W, A)."""
    ripple_percent: float
    """Torque ripple, peak to peak over mean (%)."""


def drive_points(made: ComparedDrive, compared: Compared, effort: str) -> Iterator[DrivePoint]:
    """Give a candidate's points on a drive; two shares of a narrow range may be one speed."""
    if isinstance(made.drive, PmAcDocument):
        return _duty_points(made.drive, compared, effort)
    return _angle_points(made, compared, effort)


def _angle_points(made: ComparedDrive, compared: Compared, effort: str) -> Iterator[DrivePoint]:
    points = [
        (index, planned)
        for index, planned in enumerate(made.plan)
        if isinstance(planned, PlannedRun) and planned.group == "points"
    ]
    for share in EFFORTS[effort].speeds:
        speed = operating_speed(made.drive, share)
        for index, planned in points:
            if planned.speed_rpm != speed or index not in compared.figures:
                continue
            load, figures = planned.scenario.load, compared.figures[index]
            assert isinstance(load, ConstantTorqueLoad), "the load of an operating point is a torque"
            assert planned.share is not None, "an operating point has a load"
            yield DrivePoint(
                speed_share=share,
                load_percent=round(100.0 * planned.share, _DIGITS),
                speed_rpm=speed,
                torque_nm=load.torque_nm,
                held=figures["held"],
                speed_mean_rpm=figures["speed_mean_rpm"],
                torque_mean_nm=figures["torque_mean_nm"],
                input_power_w=figures["input_power_w"],
                current_sum_a=figures["current_sum_a"],
                ripple_percent=figures["ripple_percent"],
            )


def _duty_points(drive: PmAcDocument, compared: Compared, effort: str) -> Iterator[DrivePoint]:
    size = DUTY_EFFORTS[effort]
    rows = [row for figures in compared.figures.values() for row in figures.get("points", ())]
    by_place = {_place(row["speed_rpm"], row["reference_nm"]): row for row in rows}
    for share in size.speeds:
        speed = speed_of(drive, share)
        for load in size.torques:
            row = by_place.get(_place(speed, torque_of(drive, speed, load)))
            if row is not None:
                yield _duty_point(drive, share, load, row)


def _place(speed_rpm: float, torque_nm: float) -> tuple[float, float]:
    return round(speed_rpm, _DIGITS), round(torque_nm, _DIGITS)


def _duty_point(drive: PmAcDocument, share: float, load: float, row: dict[str, Any]) -> DrivePoint:
    swing = row["ripple_percent"] * duty_limits_of(drive).rated_torque_nm
    return DrivePoint(
        speed_share=share,
        load_percent=round(100.0 * load, _DIGITS),
        speed_rpm=row["speed_rpm"],
        torque_nm=row["reference_nm"],
        held=row["held"],
        # The shaft is held at its speed, or follows it within the tolerance of what is held.
        speed_mean_rpm=row["speed_rpm"],
        torque_mean_nm=row["torque_nm"],
        input_power_w=row["input_power_w"],
        current_sum_a=SUM_OVER_PEAK * hypot(row["direct_current_a"], row["quadrature_current_a"]),
        ripple_percent=swing / abs(row["torque_nm"]) if row["torque_nm"] else 0.0,
    )
