"""The recorded signals of a run with duty ratios, and what happened in it, in plain words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.duty.run import DutyClosedLoopRun
from drivegate.gate.recording import DUTY_COLUMNS, VOLTAGE, thinned_run
from drivegate.output.recorded_trace import columns_of, recorded_trace
from drivegate.scenarios.title import titled
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.scenario import Scenario

_NEEDED: Final = (*DUTY_COLUMNS, VOLTAGE)
_ROOT_THREE: Final = math.sqrt(3.0)


@dataclass(frozen=True)
class DutySignals:
    """A run's signals, each a mean over a stretch of it.

    Attributes
    ----------
    scenario : Scenario
        What was run.
    columns : mapping
        Arrays of equal length, shape (n,), by the name of the column, which has the unit.
    """

    scenario: Scenario
    columns: Mapping[str, NDArray[np.float64]]

    @property
    def gives_torque(self) -> bool:
        """Whether the reference is a torque."""
        return isinstance(self.scenario.load, DynamometerLoad)

    @property
    def undistorted_v(self) -> NDArray[np.float64]:
        """Greatest undistorted voltage of a phase that the link gives, shape (n,) (V)."""
        return self.columns["link_voltage_v"] / _ROOT_THREE


def duty_signals_of(document: Mapping[str, Any], check: Mapping[str, Any]) -> DutySignals | None:
    """Find the recorded signals of the run that is shown for a check."""
    found = recorded_trace(document, check, _NEEDED)
    if found is None or not isinstance(found.scenario.drive, PmAcDocument):
        return None
    return DutySignals(found.scenario, found.columns)


def duty_signals_of_run(scenario: Scenario, run: DutyClosedLoopRun) -> DutySignals | None:
    """Take the signals of a run, as a result would keep them."""
    columns = columns_of(thinned_run(run), _NEEDED)
    return None if columns is None else DutySignals(scenario, columns)


def duty_account(signals: DutySignals) -> tuple[str, ...]:
    """Give an account of a run."""
    words = titled(signals.scenario).description.rstrip(".")
    last = {name: float(values[-1]) for name, values in signals.columns.items()}
    peak = float(np.max(signals.columns["peak_current_a"]))
    limit = signals.scenario.drive.rating.current_limit_a
    used = 100.0 * last[VOLTAGE] / float(signals.undistorted_v[-1])
    if signals.gives_torque:
        end = f"{last['torque_nm']:.4g} N·m for a reference of {last['torque_reference_nm']:.4g} N·m"
    else:
        end = f"{last['speed_rpm']:.5g} rpm for a reference of {last['speed_reference_rpm']:.5g} rpm"
    return (
        f"Run: {words}; {signals.scenario.duration_s:g} s.",
        f"It ends at {end}, with {last['direct_current_a']:.4g} A along the magnet's axis, "
        f"{last['quadrature_current_a']:.4g} A across it, and {used:.3g} % of the undistorted voltage.",
        f"The greatest phase current is {peak:.4g} A, the limit of references {limit:g} A.",
    )
