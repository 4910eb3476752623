"""A run of a controller of duty ratios: what the controller knows, what precedes the run and what is kept of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import OVERWRITTEN_SIZE, UNSENSED
from drivegate.contracts.duty.document import duty_document
from drivegate_cases.drive.pm_ac.document import POSITIONS
from drivegate_cases.scenario.load import DynamometerLoad, VehicleLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import position_of
from drivegate_models.contract.duty.signals import CURRENT_REFERENCE, LEG_LOW, LEG_OFF, DutyNameplate
from drivegate_models.loop.exchange import NOT_FINITE, STOPPED

WAITING_PERIODS: Final = 32
"""Control periods with a turning shaft and the bridge off, before a run and after each restart: an even number, so that
a run begins in the same half of the carrier."""
PrepareDutyLoop: TypeAlias = Callable[..., Any]
"""Makes a run against the plant ready to begin, `drivegate_models.pm_ac.closed_loop.prepared_duty_loop`."""

DUTY_RATIOS: Final = ("first_duty", "second_duty", "third_duty")
"""Fields of a command that are duty ratios."""
LEGS: Final = ("first_leg", "second_leg", "third_leg")
"""Fields of a command that are states of legs."""


@dataclass(frozen=True)
class IdleBridge:
    """Numbers of control periods with the bridge off."""

    resting: int = 0
    """Those at standstill, which come first."""
    waiting: int = 0
    """Those in which the shaft turns: before the run at its initial speed, and after each restart."""

    @property
    def periods(self) -> int:
        """All of them before a run."""
        return self.resting + self.waiting


BRIDGE_ON: Final = IdleBridge()
"""No such periods."""


def idle_bridge(declaration: Declaration, control_period: float) -> IdleBridge:
    """Return the periods before a run of a candidate; `control_period` is in seconds."""
    if not declaration.reads_enable:
        return BRIDGE_ON
    return IdleBridge(round(declaration.calibration_time_s / control_period), WAITING_PERIODS)


@dataclass(frozen=True)
class DutyClosedLoopRun:
    """What is kept of one run."""

    columns: tuple[str, ...]
    """Names of the trace's columns."""
    trace: NDArray[np.float64]
    """A row for each control period, in SI units, shape (n, len(columns)."""
    commands: NDArray[Any]
    """What the controller answered in each, shape (n,)."""
    totals: NDArray[np.float64]
    """Exact integrals over the run, shape (ledger.ENTRIES,)."""
    worst_balance: float
    """Greatest energy that a control period misses, over its throughput (1)."""
    shaft: NDArray[np.float64]
    """Energy ledger of the shaft, shape (shaft_ledger.ENTRIES,)."""
    digest: int
    """Digest of all commands, bit for bit."""

    def column(self, name: str) -> NDArray[np.float64]:
        """Return one column of the trace, shape (n,)."""
        values: NDArray[np.float64] = self.trace[:, self.columns.index(name)]
        return values

    @cached_property
    def voltages(self) -> NDArray[np.float64]:
        """Peak voltage of a phase that each period's duty ratios ask for, shape (n,) (V)."""
        ratios = [np.clip(self.commands[name], 0.0, 1.0) for name in DUTY_RATIOS]
        middle = (ratios[0] + ratios[1] + ratios[2]) / 3.0
        squares = sum((ratio - middle) * (ratio - middle) for ratio in ratios)
        voltages: NDArray[np.float64] = np.sqrt(2.0 / 3.0 * squares) * self.column("link")
        return voltages


def duty_nameplate(scenario: Scenario, *, follows_current: bool = False) -> DutyNameplate:
    """Return what the controller of a scenario knows of its drive and of its reference."""
    drive = duty_document(scenario.drive)
    torque = isinstance(scenario.load, DynamometerLoad)
    nameplate = drive.duty_nameplate(scenario.control_period_s, torque_reference=torque)
    nameplate = nameplate._replace(position=POSITIONS.index(position_of(scenario.sensors, drive)))
    if torque and follows_current:
        nameplate = nameplate._replace(reference_kind=CURRENT_REFERENCE)
    if isinstance(scenario.load, VehicleLoad):
        return nameplate._replace(inertia=nameplate.inertia + scenario.load.inertia_kg_m2)
    return nameplate


def refusal_of(command: Any, status: int, *, has_sensor: bool = True) -> str:
    """Return why a command ended a run although the controller itself reports no fault.

    `has_sensor`: whether anything shows the shaft.
    """
    if status == NOT_FINITE:
        ratios = ", ".join(f"{float(command[name]):g}" for name in DUTY_RATIOS)
        because = "" if has_sensor else UNSENSED
        return f"the duty ratios are not all finite: {ratios}{because}"
    if status == STOPPED:
        return OVERWRITTEN_SIZE
    legs = ", ".join(str(int(command[name])) for name in LEGS)
    return f"the legs are {legs}, but each must be from {LEG_OFF} to {LEG_LOW}"
