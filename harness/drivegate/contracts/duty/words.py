"""The recorded signals of a run with duty ratios, and what happened in it, in plain words."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.contract import RecordedTrace
from drivegate.contracts.duty.columns import VOLTAGE
from drivegate.scenarios.title import titled
from drivegate_cases.scenario.load import DynamometerLoad

_ROOT_THREE: Final = math.sqrt(3.0)


def follows_torque(trace: RecordedTrace) -> bool:
    """Return True if the reference of a run is a torque."""
    return isinstance(trace.scenario.load, DynamometerLoad)


def undistorted_v(trace: RecordedTrace) -> NDArray[np.float64]:
    """Return the greatest undistorted voltage of a phase that the link gives, shape (n,) (V)."""
    return trace.columns["link_voltage_v"] / _ROOT_THREE


def account(trace: RecordedTrace) -> tuple[str, ...]:
    """Return an account of a run."""
    words = titled(trace.scenario).description.rstrip(".")
    last = {name: float(values[-1]) for name, values in trace.columns.items()}
    peak = float(np.max(trace.columns["peak_current_a"]))
    limit = trace.scenario.drive.rating.current_limit_a
    used = 100.0 * last[VOLTAGE] / float(undistorted_v(trace)[-1])
    if follows_torque(trace):
        end = f"{last['torque_nm']:.4g} N·m for a reference of {last['torque_reference_nm']:.4g} N·m"
    else:
        end = f"{last['speed_rpm']:.5g} rpm for a reference of {last['speed_reference_rpm']:.5g} rpm"
    return (
        f"Run: {words}; {trace.scenario.duration_s:g} s.",
        f"It ends at {end}, with {last['direct_current_a']:.4g} A along the magnet's axis, "
        f"{last['quadrature_current_a']:.4g} A across it, and {used:.3g} % of the undistorted voltage.",
        f"The greatest phase current is {peak:.4g} A, the limit of references {limit:g} A.",
    )
