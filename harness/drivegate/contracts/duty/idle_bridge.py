"""The control periods before a run in which the bridge is off and a candidate that reads `enable` senses 0."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from drivegate.candidates.declaration import Declaration

WAITING_PERIODS: Final = 32
"""Control periods with a turning shaft: an even number, so that a run begins in the same half of the carrier."""


@dataclass(frozen=True)
class IdleBridge:
    """Numbers of control periods before a run."""

    resting: int = 0
    """Those at standstill, which come first."""
    waiting: int = 0
    """Those in which the shaft turns at the initial speed of the run."""

    @property
    def periods(self) -> int:
        """All of them."""
        return self.resting + self.waiting


BRIDGE_ON: Final = IdleBridge()
"""No such periods."""


def idle_bridge(declaration: Declaration, control_period: float) -> IdleBridge:
    """Return the periods before a run of a candidate; `control_period` is in seconds."""
    if not declaration.reads_enable:
        return BRIDGE_ON
    return IdleBridge(round(declaration.calibration_time_s / control_period), WAITING_PERIODS)
