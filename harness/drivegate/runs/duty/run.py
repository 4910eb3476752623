"""A run of a controller of duty ratios through a scenario: from plain data to its trace and its commands."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind
from drivegate.runs.scenario import plant_load, plant_schedule
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.load import DynamometerLoad, VehicleLoad
from drivegate_cases.scenario.profile import profile_arrays
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.duty.signals import LEG_LOW, LEG_OFF, DutyNameplate
from drivegate_models.errors import HarnessFault
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED
from drivegate_models.loop.schedule import Course
from drivegate_models.units import RADIANS_PER_RPM

RunLoop: TypeAlias = Callable[..., Any]
"""Runs a controller, already reset, against the plant, and gives its status, trace, integrals and commands."""

DUTY_RATIOS: Final = ("first_duty", "second_duty", "third_duty")
"""Fields of a command that are duty ratios."""
LEGS: Final = ("first_leg", "second_leg", "third_leg")
"""Fields of a command that are states of legs."""
_DIGEST_BITS: Final = 63


@dataclass(frozen=True)
class DutyClosedLoopRun:
    """What is kept of one run.

    Attributes
    ----------
    columns : tuple of str
        Names of the trace's columns.
    trace : ndarray, shape (n, len(columns))
        A row for each control period, in SI units.
    commands : ndarray of DUTY_COMMAND, shape (n,)
        What the controller answered in each.
    totals : ndarray, shape (ledger.ENTRIES,)
        Exact integrals over the run.
    worst_balance : float
        Greatest energy that a control period misses, over its throughput (1).
    digest : int
        Digest of all commands, bit for bit.
    """

    columns: tuple[str, ...]
    trace: NDArray[np.float64]
    commands: NDArray[Any]
    totals: NDArray[np.float64]
    worst_balance: float
    digest: int

    def column(self, name: str) -> NDArray[np.float64]:
        """Give one column of the trace, shape (n,)."""
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


def duty_nameplate(scenario: Scenario) -> DutyNameplate:
    """Give what the controller of a scenario knows of its drive and of its reference."""
    drive = scenario.drive
    assert isinstance(drive, PmAcDocument), "a controller of duty ratios runs on a drive that takes them"
    torque = isinstance(scenario.load, DynamometerLoad)
    nameplate = drive.duty_nameplate(scenario.control_period_s, torque_reference=torque)
    if isinstance(scenario.load, VehicleLoad):
        return nameplate._replace(inertia=nameplate.inertia + scenario.load.inertia_kg_m2)
    return nameplate


def run_duty(
    loop: RunLoop, columns: tuple[str, ...], scenario: Scenario, controller: Controller
) -> DutyClosedLoopRun:
    """Reset a controller and run it through a scenario; a fault of its own is raised."""
    nameplate: Any = duty_nameplate(scenario)
    controller.reset(nameplate)
    torque = None
    if isinstance(scenario.load, DynamometerLoad):
        torque = Course(*profile_arrays(scenario.load.torque_reference_nm))
    run = loop(
        scenario.drive.plant(scenario.scales),
        plant_load(scenario),
        plant_schedule(scenario),
        step_address=controller.step_address,
        state_address=controller.state_address,
        control_period=scenario.control_period_s,
        duration=scenario.duration_s,
        initial_speed=scenario.initial_speed_rpm * RADIANS_PER_RPM,
        initial_angle=math.radians(scenario.initial_angle_deg),
        torque_reference=torque,
    )
    if run.status != COMPLETED:
        _raise_ending(run, scenario, controller)
    return DutyClosedLoopRun(
        columns=columns,
        trace=run.trace,
        commands=run.commands,
        totals=run.totals,
        worst_balance=run.worst_balance,
        digest=_digest(run.commands),
    )


def _digest(commands: NDArray[Any]) -> int:
    whole = hashlib.blake2b(commands.tobytes(), digest_size=8).digest()
    return int.from_bytes(whole, "little") >> (64 - _DIGEST_BITS)


def _raise_ending(run: Any, scenario: Scenario, controller: Controller) -> None:
    step = int(run.steps)
    time = step * scenario.control_period_s
    if controller.fault is not None:
        raise CandidateFault(controller.fault)
    command = run.commands[step]
    legs = [int(command[name]) for name in LEGS]
    if run.status == NOT_FINITE:
        ratios = ", ".join(f"{float(command[name]):g}" for name in DUTY_RATIOS)
        message = f"the duty ratios are not all finite: {ratios}"
    elif run.status == STOPPED:
        message = "the command's struct_size was overwritten with a negative number; the harness sets it"
    elif not all(LEG_OFF <= leg <= LEG_LOW for leg in legs):
        message = f"the legs are {', '.join(map(str, legs))}, but each must be from {LEG_OFF} to {LEG_LOW}"
    else:
        raise HarnessFault(f"the plant ended with status {run.status} at step {step}, {time:g} s")
    raise CandidateFault(Fault(FaultKind.INVALID_OUTPUT, message, "step", step=step, time=time))
