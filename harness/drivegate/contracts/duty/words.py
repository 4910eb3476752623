"""The recorded signals of a run with duty ratios, and what happened in it, in plain words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.duty.columns import VOLTAGE
from drivegate.scenarios.title import titled
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.scenario import Scenario

if TYPE_CHECKING:
    from drivegate.contracts.contract import RecordedTrace

_ROOT_THREE: Final = math.sqrt(3.0)


@dataclass(frozen=True)
class DutySignals:
    """A run's signals, each a mean over a stretch of it."""

    scenario: Scenario
    """What was run."""
    columns: Mapping[str, NDArray[np.float64]]
    """Arrays of equal length, shape (n,), by the name of the column, which has the unit."""

    @property
    def gives_torque(self) -> bool:
        """Whether the reference is a torque."""
        return isinstance(self.scenario.load, DynamometerLoad)

    @property
    def undistorted_v(self) -> NDArray[np.float64]:
        """Greatest undistorted voltage of a phase that the link gives, shape (n,) (V)."""
        return self.columns["link_voltage_v"] / _ROOT_THREE


def duty_signals(trace: RecordedTrace) -> DutySignals:
    """Return the signals of a recorded run."""
    return DutySignals(trace.scenario, trace.columns)


def duty_account(signals: DutySignals) -> tuple[str, ...]:
    """Return an account of a run."""
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
