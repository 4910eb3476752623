"""Checks that apply only to candidates which are made for some of the speeds they are judged at."""

from __future__ import annotations

import math

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import ReasonNotApplicable


def unless_speeds_from(lowest: float, highest: float) -> ReasonNotApplicable:
    """Let a check apply unless the candidate declares a range without any of the speeds it is judged at."""
    endless = highest == math.inf
    if endless:
        judged = f"the speeds above {lowest:g} rpm"
    elif lowest == highest:
        judged = f"{lowest:g} rpm"
    else:
        judged = f"the speeds from {lowest:g} to {highest:g} rpm"

    def reason(declaration: Declaration) -> str | None:
        declared = declaration.speed_range_rpm
        reaches = declared is not None and (declared[1] > lowest if endless else declared[1] >= lowest)
        if declared is None or (declared[0] <= highest and reaches):
            return None
        return (
            f"the candidate declares a speed range of {declared[0]:g} to {declared[1]:g} rpm, "
            f"which contains none of {judged}"
        )

    return reason
