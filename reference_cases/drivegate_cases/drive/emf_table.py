"""The rules for a measured shape of the back-EMF, given as pairs of angle and value over a half cycle."""

from itertools import pairwise
from typing import Annotated

from pydantic import Field

EmfPoint = Annotated[tuple[float, float], Field(description="electrical degrees, share of the peak")]
EmfTable = tuple[EmfPoint, ...]

_PEAK_TOLERANCE = 1e-9
_LEAST_STEP_DEG = 1e-6


def check_emf_table(table: EmfTable) -> EmfTable:
    """Check that a table describes half a cycle of an odd, half-wave symmetric shape of peak 1."""
    if not table:
        return table
    angles = [angle for angle, _ in table]
    values = [value for _, value in table]
    if angles[0] != 0.0 or angles[-1] != 180.0:
        raise ValueError("must begin at 0 and end at 180 electrical degrees")
    if any(later - earlier < _LEAST_STEP_DEG for earlier, later in pairwise(angles)):
        raise ValueError(f"must have strictly increasing angles, at least {_LEAST_STEP_DEG:g} degrees apart")
    if values[0] != 0.0 or values[-1] != 0.0:
        raise ValueError("must have the value 0 at 0 and at 180 electrical degrees")
    if abs(max(values) - 1.0) > _PEAK_TOLERANCE or min(values) < -1.0 - _PEAK_TOLERANCE:
        raise ValueError("must have the value 1 as its greatest, and none below -1")
    return table
