"""A drive's constants fitted to measured or published torques, with the uncertainty of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, isnan, nan, sqrt
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.drives.drive_kind import Drive
from drivegate.drives.kinds import kind_of
from drivegate.drives.rating import drive_with, machine_constants
from drivegate.studies.drive.measured import MeasuredTorque
from drivegate_cases.documents.wording import counted, nearest, one_line
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import InputError
from drivegate_models.machine.constants_fit import ConstantsFit, fit_constants

SCHEMA: Final = 1
BOUNDS: Final = (0.05, 20.0)
"""Bounds of the search for a constant over the drive's own value (1)."""
_FLAT: Final = "emf_flat_deg"
_WIDEST_FLAT: Final = 175.0
_FLATS: Final = (60.0, 100.0, 140.0)
"""Flat widths from which the search begins beside the drive's own, since it may end in the wrong valley (deg)."""
_AT_BOUND: Final = 1e-3


@dataclass(frozen=True)
class FittedConstant:
    """A constant beside the document's."""

    key: str
    """Its key in the document."""
    stored: float
    """The document's value."""
    fitted: float
    """The fitted one."""
    uncertainty: float
    """Its standard uncertainty: NaN where nothing determines it, infinite where the points do not determine the
    constant."""
    at_bound: bool
    """Whether the search has stopped at its bound."""

    @property
    def is_determined(self) -> bool:
        """Whether nothing says that the points do not determine it."""
        return not self.uncertainty > self.fitted


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
    """Fit a drive's constants to measured torques."""
    stored = fitted_constants(document, kept)
    if len(points) < len(stored):
        raise InputError(
            f"{counted(len(points), 'point')} cannot tell {counted(len(stored), 'constant')} ({', '.join(stored)}); "
            "give more points, or keep a constant with --keep KEY"
        )
    weights = np.array([1.0 if isnan(point.uncertainty) else 1.0 / point.uncertainty for point in points])
    found = _best_fit(document, stored, points, weights)
    return _document(document, _constants(stored, found, points), points, found.residuals / weights, found)


def _best_fit(
    document: DriveDocument,
    stored: Mapping[str, float],
    points: Sequence[MeasuredTorque],
    weights: NDArray[np.float64],
) -> ConstantsFit:
    measured = np.array([point.torque for point in points])

    def residuals(values: NDArray[np.float64]) -> NDArray[np.float64]:
        made = drive_with(document, dict(zip(stored, map(float, values), strict=True)))
        return np.asarray((_torques(document, made, points) - measured) * weights)

    lowest, highest = _bounds(stored)
    fits = (fit_constants(residuals, start, lowest, highest) for start in _starts(stored))
    return min(fits, key=lambda fit: float(fit.residuals @ fit.residuals))


def _constants(
    stored: Mapping[str, float], found: ConstantsFit, points: Sequence[MeasuredTorque]
) -> list[FittedConstant]:
    variance = _variance(found, points)
    spread = found.relative_spread(variance) if isfinite(variance) else np.full(len(stored), nan)
    return [
        FittedConstant(
            key=key,
            stored=stored[key],
            fitted=float(value),
            uncertainty=float(share * value),
            at_bound=any(abs(value / bound - 1.0) < _AT_BOUND for bound in bounds),
        )
        for key, value, share, *bounds in zip(stored, found.values, spread, *_bounds(stored), strict=True)
    ]


def _bounds(stored: Mapping[str, float]) -> tuple[list[float], list[float]]:
    lowest, highest = ({key: factor * value for key, value in stored.items()} for factor in BOUNDS)
    if _FLAT in stored:
        highest[_FLAT] = min(highest[_FLAT], _WIDEST_FLAT)
    return list(lowest.values()), list(highest.values())


def _starts(stored: Mapping[str, float]) -> list[list[float]]:
    """Return the constants to begin with: the drive's own, and these with other flat widths."""
    others = [{**stored, _FLAT: flat} for flat in _FLATS] if _FLAT in stored else []
    lowest, highest = _bounds(stored)
    starts = [list(values.values()) for values in (stored, *others)]
    return [start for start in starts if _lies_within(start, lowest, highest)]


def _lies_within(start: Sequence[float], lowest: Sequence[float], highest: Sequence[float]) -> bool:
    return all(low < value < high for low, value, high in zip(lowest, start, highest, strict=True))


def _torques(
    document: DriveDocument, constants: Drive, points: Sequence[MeasuredTorque]
) -> NDArray[np.float64]:
    oracle = kind_of(document).oracle()
    return np.array([point.torque_of(oracle, constants) for point in points])


def _variance(found: ConstantsFit, points: Sequence[MeasuredTorque]) -> float:
    """Estimate the variance of the weighted torques; NaN where neither a rest nor the file determines it."""
    spare = len(found.residuals) - len(found.values)
    scatter = float(found.residuals @ found.residuals) / spare if spare else nan
    if isnan(points[0].uncertainty):
        return scatter
    # Points that scatter by more than they are said to are no better than they scatter.
    return max(1.0, scatter) if spare else 1.0


def _document(
    document: DriveDocument,
    constants: Sequence[FittedConstant],
    points: Sequence[MeasuredTorque],
    residuals: NDArray[np.float64],
    found: ConstantsFit,
) -> dict[str, Any]:
    limit = document.plant().current_limit
    return {
        "schema": SCHEMA,
        "kind": "fit of a drive",
        "drive": document.name,
        "constants": [
            {
                "key": row.key,
                "stored": row.stored,
                "fitted": row.fitted,
                "uncertainty": row.uncertainty,
                "determined": row.is_determined,
                "at_bound": row.at_bound,
            }
            for row in constants
        ],
        "condition": found.condition,
        "converged": found.converged,
        "rms_residual_nm": sqrt(float(residuals @ residuals) / len(residuals)),
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
