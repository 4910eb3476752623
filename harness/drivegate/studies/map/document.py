"""The document of a finished operating map."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from drivegate.studies.map.map import OperatingMap
from drivegate.studies.map.plan import MapPlan

SCHEMA: Final = 1


def title_of(plan: MapPlan) -> str:
    """Tell whose map it is."""
    if plan.candidate is not None:
        return f"{plan.candidate.name} on {plan.drive.name}"
    return plan.drive.name if plan.kind == "points" else f"the best of {plan.drive.name}"


def document_of(made: OperatingMap, seconds: float, files: Sequence[str]) -> dict[str, Any]:
    """Give the ranges of what was computed, and the files that it was written into."""
    plan = made.plan
    finite = np.isfinite(made.numbers)
    ranges = {
        name: {"lowest": float(column[here].min()), "highest": float(column[here].max())}
        for name, column, here in zip(plan.columns, made.numbers.T, finite.T, strict=True)
        if here.any() and name != "certified"
    }
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": "operating map",
        "of": plan.kind,
        "drive": plan.drive.identity(),
        "candidate": None if plan.candidate is None else plan.candidate.name,
        "axes": {name: list(values) for name, values in zip(plan.axes.names, plan.axes.values, strict=True)},
        "points": plan.axes.points,
        "without_values": int(np.count_nonzero(~finite.any(axis=1))),
        "ranges": ranges,
        "verdicts": {verdict: made.verdicts.count(verdict) for verdict in sorted(set(made.verdicts))},
    }
    if plan.kind == "points":
        document["not_certified"] = int(np.count_nonzero(made.numbers[:, -1] == 0.0))
    return document | {"files": list(files), "timing": {"seconds": seconds}}
