"""Operating maps: steady states, the best that the drive can do, or what a candidate makes of it, over a grid."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import dataclass, field
from math import nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.containment.backend import Backend, done_by
from drivegate.studies.map.plan import MapPlan, plant_of, single_parameters
from drivegate.studies.map.tasks import compile_solver, compute_piece


@dataclass(frozen=True)
class OperatingMap:
    """A finished map."""

    plan: MapPlan
    """What was requested."""
    numbers: NDArray[np.float64]
    """What was computed, shape (points, columns)."""
    verdicts: list[str] = field(default_factory=list)
    """What became of each closed-loop run; empty of other maps."""

    def table(self) -> dict[str, Any]:
        """Return the map as columns."""
        columns: dict[str, Any] = dict(self.plan.axes.coordinates(0, self.plan.axes.points))
        if self.verdicts:
            columns["verdict"] = self.verdicts
        for place, name in enumerate(self.plan.columns):
            columns[f"found_{name}" if name in columns else name] = self.numbers[:, place]
        if "certified" in columns:
            columns["certified"] = columns["certified"] != 0.0
        return columns


def computed(plan: MapPlan, backend: Backend, report_progress: Callable[[int, int], None]) -> OperatingMap:
    """Compute a map."""
    for parameter in single_parameters(plan):
        plant_of(plan.drive, parameter)
    points, done = plan.axes.points, 0
    values = np.full((points, len(plan.columns)), nan)
    verdicts = [""] * points if plan.kind == "loop" else []
    package = pickle.dumps(plan, pickle.HIGHEST_PROTOCOL)
    if plan.kind == "points":
        compile_solver(package, plan.drive.kind)
    report_progress(0, 0)
    for (first, last), part in done_by(backend, compute_piece, package, plan.pieces()):
        values[first:last] = part.values
        if part.verdicts:
            verdicts[first:last] = part.verdicts
        done += last - first
        report_progress(done, 0)
    return OperatingMap(plan, values, verdicts)
