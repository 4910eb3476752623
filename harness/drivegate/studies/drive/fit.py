"""A drive's constants fitted to torques of a CSV file, measured or published, with the uncertainty of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, isnan, nan, radians
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drivegate.drives.kinds import require_angles
from drivegate.drives.rating import drive_with, machine_constants
from drivegate_cases.documents.csv_file import read_columns
from drivegate_cases.documents.wording import counted, nearest, one_line, shown_path
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import InputError
from drivegate_models.machine.constants_fit import ConstantsFit, fit_constants
from drivegate_models.steady import oracle
from drivegate_models.steady.plant import AnyDrive
from drivegate_models.units import RADIANS_PER_RPM

REQUIRED: Final = ("speed_rpm", "torque_nm")
"""Columns that a file must have."""
OPTIONAL: Final = ("advance_deg", "current_a", "uncertainty_nm")
"""Columns that it may have."""
MOST_POINTS: Final = 1000
"""Points that a file may have at most."""
_HIGHEST_ANGLE: Final = 90.0
_HIGHEST_SPEED: Final = 1e6
SCHEMA: Final = 1
BOUNDS: Final = (0.05, 20.0)
"""Bounds of the search for a constant over the drive's own value (1)."""
_FLAT: Final = "emf_flat_deg"
_WIDEST_FLAT: Final = 175.0
_FLATS: Final = (60.0, 100.0, 140.0)
"""Flat widths from which the search begins next to the drive's own, since it may end in the wrong valley (deg)."""
_AT_BOUND: Final = 1e-3
_MOST_LEFT: Final = 0.1
"""Residual over the torques, both root mean square, from which on a fit explains nothing (1)."""
_SCATTER: Final = 3.0
"""Residual over the stated uncertainty, where that allows more (1)."""


@dataclass(frozen=True)
class MeasuredTorque:
    """A mean torque that was measured or published."""

    speed_rpm: float
    torque: float
    """Mean electromagnetic torque (N·m)."""
    advance_deg: float = nan
    """Advance angle (deg); NaN for that of the greatest torque."""
    current: float = nan
    """Current reference (A); NaN for the current limit."""
    uncertainty: float = nan
    """Standard uncertainty of the torque (N·m); NaN where it is not known."""

    def torque_of(self, constants: AnyDrive) -> float:
        """Return the torque that a drive has there (N·m)."""
        # A current reference gives what it would as the limit.
        at = constants if isnan(self.current) else constants._replace(current_limit=self.current)
        speed = self.speed_rpm * RADIANS_PER_RPM
        if isnan(self.advance_deg):
            return oracle.greatest_torque_at_limit(at, speed).torque
        return float(oracle.torques_at_limit(at, speed, [radians(self.advance_deg)])[0])


def read_measured(path: Path) -> tuple[MeasuredTorque, ...]:
    where = shown_path(path)
    rows = read_columns(path, REQUIRED, OPTIONAL, what="measured torques")
    if not 0 < len(rows) <= MOST_POINTS:
        raise InputError(f"{where} has {len(rows)} points, but must have 1 to {MOST_POINTS}")
    points = tuple(MeasuredTorque(*row) for row in rows)
    for number, point in enumerate(points, 1):
        problem = _problem(point)
        if problem:
            raise InputError(f"{where}: {problem} in point {number}")
    if len({isnan(point.uncertainty) for point in points}) > 1:
        raise InputError(f"{where}: 'uncertainty_nm' is given for some points, but must be for all or none")
    return points


def _problem(point: MeasuredTorque) -> str:
    """State the first value that cannot be."""
    if not 0.0 < point.speed_rpm <= _HIGHEST_SPEED:
        return f"'speed_rpm' is {point.speed_rpm:g}, but must be above 0 and up to {_HIGHEST_SPEED:g}"
    if not (isnan(point.advance_deg) or 0.0 <= point.advance_deg <= _HIGHEST_ANGLE):
        return f"'advance_deg' is {point.advance_deg:g}, but must be from 0 to {_HIGHEST_ANGLE:g}, or empty"
    if point.current <= 0.0:
        return f"'current_a' is {point.current:g}, but must be above 0, or empty for the current limit"
    if point.uncertainty <= 0.0:
        return f"'uncertainty_nm' is {point.uncertainty:g}, but must be above 0"
    return ""


def fitted_constants(document: DriveDocument, kept: Sequence[str]) -> dict[str, float]:
    """List the constants of a drive that are to be fitted, with its own values."""
    own = machine_constants(document)
    wrong = [key for key in kept if key not in own]
    if wrong:
        raise InputError(
            f"--keep {one_line(wrong[0])}: it is no constant that is fitted, the nearest is "
            f"'{nearest(wrong[0], own)}'"
        )
    chosen = {key: value for key, value in own.items() if key not in kept}
    if not chosen:
        raise InputError("--keep leaves no constant to be fitted; leave one out of it")
    for key, value in chosen.items():
        if value <= 0.0:
            raise InputError(
                f"the search for {key} begins at the drive's own value, which is 0; give another with "
                f"--set {key}=…, or keep it with --keep {key}"
            )
    return chosen


def fit_document(
    document: DriveDocument, points: Sequence[MeasuredTorque], kept: Sequence[str] = ()
) -> dict[str, Any]:
    require_angles(document)
    stored = fitted_constants(document, kept)
    if len(points) < len(stored):
        raise InputError(
            f"{counted(len(points), 'point')} cannot tell {counted(len(stored), 'constant')} ({', '.join(stored)}); "
            "give more points, or keep a constant with --keep KEY"
        )
    weights = np.array([1.0 if isnan(point.uncertainty) else 1.0 / point.uncertainty for point in points])
    found = _best_fit(document, stored, points, weights)
    residuals = found.residuals / weights
    left = _root_mean_square(residuals)
    is_explained = left <= _most_left(points)
    constants = _constants(stored, found, points) if is_explained else []
    limit = document.plant().current_limit
    return {
        "schema": SCHEMA,
        "kind": "fit of a drive",
        "drive": document.name,
        "usable": bool(constants)
        and found.converged
        and all(row["determined"] and not row["at_bound"] for row in constants),
        "explained": is_explained,
        "constants": constants,
        "condition": found.condition,
        "converged": found.converged,
        "rms_residual_nm": left,
        "points": [
            {
                "speed_rpm": point.speed_rpm,
                "advance_deg": point.advance_deg,
                "current_a": limit if isnan(point.current) else point.current,
                "torque_nm": point.torque,
                "fitted_torque_nm": point.torque + float(residual),
            }
            for point, residual in zip(points, residuals, strict=True)
        ],
    }


def _most_left(points: Sequence[MeasuredTorque]) -> float:
    """Return the residual from which on a fit explains nothing (N·m): a share of the torques, or their uncertainty."""
    share = _MOST_LEFT * _root_mean_square([point.torque for point in points])
    stated = [point.uncertainty for point in points if not isnan(point.uncertainty)]
    return max(share, _SCATTER * _root_mean_square(stated)) if stated else share


def _root_mean_square(values: ArrayLike) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _best_fit(
    document: DriveDocument,
    stored: Mapping[str, float],
    points: Sequence[MeasuredTorque],
    weights: NDArray[np.float64],
) -> ConstantsFit:
    measured = np.array([point.torque for point in points])

    def residuals(values: NDArray[np.float64]) -> NDArray[np.float64]:
        made = drive_with(document, dict(zip(stored, map(float, values), strict=True)))
        return np.asarray((np.array([point.torque_of(made) for point in points]) - measured) * weights)

    lowest, highest = _bounds(stored)
    # The search begins at the drive's own values, and at these with other flat widths.
    others = [{**stored, _FLAT: flat} for flat in _FLATS] if _FLAT in stored else []
    starts = [list(values.values()) for values in (stored, *others)]
    fits = (
        fit_constants(residuals, start, lowest, highest)
        for start in starts
        if all(low < value < high for low, value, high in zip(lowest, start, highest, strict=True))
    )
    return min(fits, key=lambda fit: float(fit.residuals @ fit.residuals))


def _constants(
    stored: Mapping[str, float], found: ConstantsFit, points: Sequence[MeasuredTorque]
) -> list[dict[str, Any]]:
    """Return each constant next to the drive's own, and how sure it is.

    The uncertainty is one standard deviation: NaN where nothing determines it, infinite where the points do not
    determine the constant.
    """
    variance = _variance(found, points)
    spread = found.relative_spread(variance) if isfinite(variance) else np.full(len(stored), nan)
    return [
        {
            "key": key,
            "stored": stored[key],
            "fitted": float(value),
            "uncertainty": float(share * value),
            # An unknown uncertainty, NaN, is no sign that the points do not determine it.
            "determined": not share * value > value,
            "at_bound": any(abs(value / bound - 1.0) < _AT_BOUND for bound in bounds),
        }
        for key, value, share, *bounds in zip(stored, found.values, spread, *_bounds(stored), strict=True)
    ]


def _bounds(stored: Mapping[str, float]) -> tuple[list[float], list[float]]:
    lowest, highest = ({key: factor * value for key, value in stored.items()} for factor in BOUNDS)
    if _FLAT in stored:
        highest[_FLAT] = min(highest[_FLAT], _WIDEST_FLAT)
    return list(lowest.values()), list(highest.values())


def _variance(found: ConstantsFit, points: Sequence[MeasuredTorque]) -> float:
    """Estimate the variance of the weighted torques; NaN where neither further points nor the file determine it."""
    spare = len(found.residuals) - len(found.values)
    scatter = float(found.residuals @ found.residuals) / spare if spare else nan
    if isnan(points[0].uncertainty):
        return scatter
    # Points that scatter by more than they are said to are no better than they scatter.
    return max(1.0, scatter) if spare else 1.0
