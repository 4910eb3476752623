"""A run of a controller of duty ratios through a scenario: from plain data to its trace and observations."""

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
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import OVERWRITTEN_SIZE, CandidateFault, placed, refused_command
from drivegate.containment.contained_controller import Wrap, require_same_plant, stepped_here
from drivegate.containment.messages import AnyController
from drivegate.containment.protocol import CloseLoop
from drivegate.containment.restarting import Restarter
from drivegate.contracts.duty.current_reference import quadrature_profile
from drivegate.contracts.duty.document import duty_document
from drivegate.scenarios.plant_inputs import plant_course, plant_load, plant_schedule
from drivegate_cases.scenario.load import DynamometerLoad, VehicleLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.duty.records import DUTY_COMMAND
from drivegate_models.contract.duty.signals import CURRENT_REFERENCE, LEG_LOW, LEG_OFF, DutyNameplate
from drivegate_models.contract.layout import DUTY
from drivegate_models.errors import HarnessFault
from drivegate_models.loop.duty_command import BAD_LEG
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED
from drivegate_models.units import RADIANS_PER_RPM

WAITING_PERIODS: Final = 32
"""Control periods with a turning shaft: an even number, so that a run begins in the same half of the carrier."""
PrepareDutyLoop: TypeAlias = Callable[..., Any]
"""Makes a run against the plant ready to begin, `drivegate_models.pm_ac.closed_loop.prepared_duty_loop`."""

DUTY_RATIOS: Final = ("first_duty", "second_duty", "third_duty")
"""Fields of a command that are duty ratios."""
LEGS: Final = ("first_leg", "second_leg", "third_leg")
"""Fields of a command that are states of legs."""
_DIGEST_BITS: Final = 63
_AFTER_A_STEP: Final = 1e-6
"""Time of a control period at which a step at its start has been taken, in control periods (1)."""


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
    if torque and follows_current:
        nameplate = nameplate._replace(reference_kind=CURRENT_REFERENCE)
    if isinstance(scenario.load, VehicleLoad):
        return nameplate._replace(inertia=nameplate.inertia + scenario.load.inertia_kg_m2)
    return nameplate


def run_duty(
    prepare: PrepareDutyLoop,
    columns: tuple[str, ...],
    scenario: Scenario,
    controller: AnyController,
    sensors: Any = None,
    failure: Any = None,
    wrap: Wrap | None = None,
    idle: IdleBridge = BRIDGE_ON,
    *,
    follows_current: bool = False,
) -> DutyClosedLoopRun:
    """Reset a controller and run it through a scenario; a fault of its own is raised.

    A candidate's instance runs in its own process, beside a plant that is there to close the loop; what is observed is
    what the plant here comes to by the same commands. Without sensors it sees the plant as it is, and without a failure
    nothing fails.
    """
    plant = (scenario.drive.plant(scenario.scales), plant_load(scenario), plant_schedule(scenario))
    before = {"resting": idle.resting, "waiting": idle.waiting}
    options = {**_options(scenario, sensors, follows_current), "failure": failure, **before}
    nameplate: Any = duty_nameplate(scenario, follows_current=follows_current)
    controller.reset(nameplate)
    restarts = [round(time / scenario.control_period_s) for time in scenario.restarts_s]
    order = CloseLoop(prepare, plant, options, restarts, commands=DUTY_COMMAND)
    by_address = stepped_here(controller, order, idle.periods + scenario.control_periods)
    stepped = by_address if wrap is None else wrap(by_address)
    restarter = Restarter(stepped, nameplate)
    prepared = prepare(
        *plant,
        **options,
        step_address=stepped.step_address,
        state_address=stepped.state_address,
        restarts=restarter.restarts(restarts),
    )
    run = prepared.run()
    if restarter.failures:
        # Taken out, since what is raised keeps this frame, and with it the restarter.
        raise restarter.failures.pop()
    if run.status != COMPLETED:
        _raise_ending(run, prepared.exchange, by_address)
    require_same_plant(by_address, prepared.records)
    commands = run.commands[run.before :]
    if follows_current:
        _show_torque(columns, run.trace, scenario)
    return DutyClosedLoopRun(
        columns=columns,
        trace=run.trace,
        commands=commands,
        totals=run.totals,
        worst_balance=run.worst_balance,
        digest=_digest(commands),
    )


def _show_torque(columns: tuple[str, ...], trace: NDArray[np.float64], scenario: Scenario) -> None:
    """Put the torque of the scenario back where the loop has kept the q current that the controller got for it."""
    times = (np.arange(len(trace)) + _AFTER_A_STEP) * scenario.control_period_s
    points = np.array(scenario.torque_reference_profile)
    trace[:, columns.index("torque_reference")] = np.interp(times, points[:, 0], points[:, 1])


def _options(scenario: Scenario, sensors: Any, follows_current: bool) -> dict[str, Any]:
    """Return what a run is made of besides drive, load and schedule."""
    torque = None
    if isinstance(scenario.load, DynamometerLoad):
        torques = scenario.load.torque_reference_nm
        torque = plant_course(scenario, quadrature_profile(scenario, torques) if follows_current else torques)
    return {
        "control_period": scenario.control_period_s,
        "duration": scenario.duration_s,
        "initial_speed": scenario.initial_speed_rpm * RADIANS_PER_RPM,
        "initial_angle": math.radians(scenario.initial_angle_deg),
        "clock_start": scenario.clock_start_s,
        "torque_reference": torque,
        "sensors": sensors,
    }


def _digest(commands: NDArray[Any]) -> int:
    whole = hashlib.blake2b(commands.tobytes(), digest_size=8).digest()
    return int.from_bytes(whole, "little") >> (64 - _DIGEST_BITS)


def _raise_ending(run: Any, exchange: Any, controller: Controller) -> None:
    sense = DUTY.sensed(exchange.sense[0], exchange.sensed_currents)
    step = int(run.steps)
    fault = controller.fault
    if run.status == STOPPED and fault is not None:
        raise CandidateFault(placed(fault, step, sense))
    if run.status not in (STOPPED, NOT_FINITE, BAD_LEG):
        raise HarnessFault(f"the plant ended with status {run.status} at step {step}, {sense.time:g} s")
    raise CandidateFault(refused_command(refusal_of(run.commands[step], run.status), step, sense))


def refusal_of(command: Any, status: int) -> str:
    """Return why a command ended a run although the controller itself reports no fault."""
    if status == NOT_FINITE:
        ratios = ", ".join(f"{float(command[name]):g}" for name in DUTY_RATIOS)
        return f"the duty ratios are not all finite: {ratios}"
    if status == STOPPED:
        return OVERWRITTEN_SIZE
    legs = ", ".join(str(int(command[name])) for name in LEGS)
    return f"the legs are {legs}, but each must be from {LEG_OFF} to {LEG_LOW}"
