"""The recorded signals of a run, taken out of a result document that may hold anything."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.gate.recording import COLUMNS, thinned
from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError
from drivegate_models.loop.closed_loop import ClosedLoopRun

# Nothing is told of the supply.
_NEEDED: Final = tuple(name for name in COLUMNS if name != "half_supply_v")
_MOST_POINTS: Final = 5_000
_GREATEST: Final = 1e9


@dataclass(frozen=True)
class RunSignals:
    """A run's signals, and the stretch that a check was judged on.

    Attributes
    ----------
    scenario : Scenario
        What was run.
    time_s : ndarray, shape (n,)
        Middle of each point's stretch (s).
    speed_reference_rpm, speed_rpm : ndarray, shape (n,)
        Speed reference, and true speed (rpm).
    current_sum_a, current_reference_a : ndarray, shape (n,)
        Σ|i| and the current reference (A).
    advance_deg : ndarray, shape (n,)
        Advance angle (electrical deg).
    torque_nm, load_torque_nm : ndarray, shape (n,)
        Electromagnetic torque and the load's (N·m).
    judged_s : tuple of float
        Start and end of the stretch (s).
    """

    scenario: Scenario
    time_s: NDArray[np.float64]
    speed_reference_rpm: NDArray[np.float64]
    speed_rpm: NDArray[np.float64]
    current_sum_a: NDArray[np.float64]
    current_reference_a: NDArray[np.float64]
    advance_deg: NDArray[np.float64]
    torque_nm: NDArray[np.float64]
    load_torque_nm: NDArray[np.float64]
    judged_s: tuple[float, float]

    @property
    def speed_error_rpm(self) -> NDArray[np.float64]:
        """True speed less the reference, shape (n,) (rpm)."""
        return self.speed_rpm - self.speed_reference_rpm

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Which points lie in the judged stretch, shape (n,)."""
        return (self.time_s >= self.judged_s[0]) & (self.time_s <= self.judged_s[1])


def signals_of(document: Mapping[str, Any], check: Mapping[str, Any]) -> RunSignals | None:
    """Find the recorded signals of the run that is shown for a check."""
    recording, traces = check.get("recording"), document.get("traces")
    scenario = check.get("scenario") if check.get("counterexample") is None else check["counterexample"]
    if not isinstance(recording, Mapping) or not isinstance(traces, list):
        return None
    place = recording.get("trace")
    if not isinstance(place, int) or not 0 <= place < len(traces):
        return None
    columns = _columns(traces[place])
    judged = (recording.get("start_s"), recording.get("end_s"))
    if columns is None or not all(isinstance(time, int | float) and math.isfinite(time) for time in judged):
        return None
    try:
        run = parse_document(scenario if isinstance(scenario, Mapping) else {}, Scenario, "the scenario")
    except InputError:
        return None
    return RunSignals(scenario=run, judged_s=(float(judged[0] or 0.0), float(judged[1] or 0.0)), **columns)


def signals_of_run(
    scenario: Scenario, run: ClosedLoopRun, judged_s: tuple[float, float]
) -> RunSignals | None:
    """Take the signals of a run with a trace, as a result would keep them."""
    columns = _columns(thinned(run.trace))
    return None if columns is None else RunSignals(scenario=scenario, judged_s=judged_s, **columns)


def _columns(trace: object) -> dict[str, NDArray[np.float64]] | None:
    """Read the columns; None unless all are there, equally long, and finite."""
    if not isinstance(trace, Mapping):
        return None
    columns = {}
    for name in _NEEDED:
        values = trace.get(name)
        if not isinstance(values, list) or not 2 <= len(values) <= _MOST_POINTS:
            return None
        if not all(isinstance(value, int | float) and abs(value) < _GREATEST for value in values):
            return None
        columns[name] = np.array(values, dtype=np.float64)
    lengths = {len(values) for values in columns.values()}
    increasing = bool(np.all(np.diff(columns["time_s"]) > 0.0))
    return columns if len(lengths) == 1 and increasing else None
