"""Correct controllers without a position sensor of other designs than `foc-sensorless`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from drivegate_lab.kernels.faults.duty import sensorless as kernels


@dataclass(frozen=True)
class SensorlessDesign:
    """Another observer or another start."""

    variation: int = 0
    """What its steps do otherwise, from `drivegate_lab.kernels.faults.duty.sensorless`; 0 for nothing."""
    alter: Callable[[Any], None] | None = None
    """Changes the record of its state, just reset."""


def _slower_observer(state: Any) -> None:
    # 35 Hz. On machines with great inductances the observer is slower already.
    state["bandwidth"] = min(state["bandwidth"], 220.0)
    state["still_gain"] *= 1.5


SENSORLESS_DESIGNS: Final = {
    "start-by-observer": SensorlessDesign(kernels.BY_OBSERVER),
    "slower-observer": SensorlessDesign(alter=_slower_observer),
}
"""All of them, by the name behind ``design:``."""
