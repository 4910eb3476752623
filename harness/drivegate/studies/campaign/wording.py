"""What is told of a check, the same on the console and on the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from drivegate_cases.documents.rounding import significant


def probability_text(value: float | None) -> str:
    """Write a probability with three digits and never in powers of ten."""
    return "–" if value is None else np.format_float_positional(significant(value, 3), trim="-")


def interval_text(stated: Mapping[str, Any]) -> str:
    """Write the interval of a probability; a dash where there were no runs."""
    if not stated["runs"]:
        return "–"
    low, high = stated["interval"]
    return f"{probability_text(low)} to {probability_text(high)}"


def share_text(stated: Mapping[str, Any]) -> str:
    """Write how often something happened."""
    return f"{stated['violations']} of {stated['runs']}" if stated["runs"] else "–"


def told_margins(
    shares: Sequence[float], check: Mapping[str, Any]
) -> tuple[float | None, float | None, float | None]:
    """Give a check's least margin, that of 5 % of the runs and the median; None where no run had any."""
    at = dict(zip(shares, check["margin_quantiles"], strict=False))
    return at.get(0.0), at.get(0.05), at.get(0.5)
