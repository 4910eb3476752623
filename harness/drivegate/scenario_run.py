"""One run of a controller through a scenario: from plain data to what the closed loop observed."""

from __future__ import annotations

import math
from contextlib import nullcontext
from typing import TYPE_CHECKING

from drivegate.controller import Controller
from drivegate.fault import CandidateFault, Fault, FaultKind
from drivegate_cases.load import ConstantPowerLoad, ConstantTorqueLoad, LockedLoad
from drivegate_cases.profile import dwells, profile_arrays
from drivegate_cases.scenario import Scenario
from drivegate_models import closed_loop, load
from drivegate_models.errors import HarnessFault
from drivegate_models.signals import Sense

if TYPE_CHECKING:
    from drivegate.shared_progress import SharedProgress

SETTLING_TIME = 6.0
"""Time within which a search has to converge at a steady reference (s)."""
SHORTEST_WINDOW = 3.0
"""Shortest time over which convergence is judged (s)."""

RADIANS_PER_RPM = math.pi / 30.0


def observed_windows(scenario: Scenario) -> list[tuple[float, float]]:
    """Find the stretches in which convergence is judged: from `SETTLING_TIME` into each long dwell to its end.

    Parameters
    ----------
    scenario : Scenario
        The scenario.

    Returns
    -------
    list of tuple of float
        Start and end of each stretch (s).
    """
    return [
        (dwell.start + SETTLING_TIME, dwell.end)
        for dwell in dwells(scenario)
        if dwell.duration >= SETTLING_TIME + SHORTEST_WINDOW - 1e-9
    ]


def plant_load(scenario: Scenario) -> load.Load:
    """Give a scenario's load as the plant takes it.

    Parameters
    ----------
    scenario : Scenario
        The scenario.

    Returns
    -------
    Load
        Kind and size in SI units.
    """
    drawn = scenario.load
    if isinstance(drawn, LockedLoad):
        return load.Load(load.LOCKED, 0.0, 1.0)
    if isinstance(drawn, ConstantTorqueLoad):
        return load.Load(load.CONSTANT_TORQUE, drawn.torque_nm, 1.0)
    if isinstance(drawn, ConstantPowerLoad):
        return load.Load(load.CONSTANT_POWER, drawn.power_w, 1.0)
    return load.Load(load.FAN, drawn.torque_nm, drawn.speed_rpm * RADIANS_PER_RPM)


def run_scenario(
    scenario: Scenario,
    controller: Controller,
    *,
    progress: SharedProgress | None = None,
    trace_every: int = 0,
) -> closed_loop.ClosedLoopRun:
    """Reset a controller and run it through a scenario.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    controller : Controller
        The candidate's instance.
    progress : SharedProgress, optional
        Memory in which a parent process follows the run.
    trace_every : int
        Keep every n-th control period in the trace; 0 keeps none.

    Returns
    -------
    ClosedLoopRun
        What was observed; its windows are those of `observed_windows`.

    Raises
    ------
    CandidateFault
        When the candidate raises or answers with what is no command.
    HarnessFault
        When the plant itself fails.
    """
    speed_times, speed_values = profile_arrays(scenario.speed_rpm)
    load_times, load_values = profile_arrays(scenario.load_profile)
    supply_times, supply_values = profile_arrays(scenario.supply_profile)
    schedule = closed_loop.Schedule(
        speed_times, speed_values * RADIANS_PER_RPM, load_times, load_values, supply_times, supply_values
    )
    nameplate = scenario.nameplate()
    drive = scenario.motor.drive(scenario.scales)
    with progress.run() if progress is not None else nullcontext():
        controller.reset(nameplate)
        run = closed_loop.run_closed_loop(
            drive,
            plant_load(scenario),
            schedule,
            step_address=controller.step_address,
            state_address=controller.state_address,
            initial_speed=scenario.initial_speed_rpm * RADIANS_PER_RPM,
            base_speed=nameplate.base_speed,
            control_period=scenario.control_period_s,
            duration=scenario.duration_s,
            windows=observed_windows(scenario),
            sense=progress.sense if progress is not None else None,
            sensed_currents=progress.phase_currents if progress is not None else None,
            progress=progress.steps if progress is not None else None,
            trace_every=trace_every,
        )
    if run.status != closed_loop.FINISHED:
        _raise_ending(run, controller)
    return run


def _raise_ending(run: closed_loop.ClosedLoopRun, controller: Controller) -> None:
    sense = last_sense(run)
    step = int(run.steps)
    if run.status == closed_loop.STOPPED and controller.fault is not None:
        raise CandidateFault(controller.fault)
    if run.status == closed_loop.NOT_FINITE:
        command = run.last_command[0]
        values = ", ".join(f"{name} = {command[name]}" for name in (command.dtype.names or ())[1:])
        message = f"the command is not finite: {values}"
        raise CandidateFault(
            Fault(
                FaultKind.INVALID_OUTPUT, message, "step", step=step, time=sense.time, sense=sense._asdict()
            )
        )
    raise HarnessFault(f"the plant ended with status {run.status} at step {step}, {sense.time:g} s")


def last_sense(run: closed_loop.ClosedLoopRun) -> Sense:
    """Give the last Sense of a run.

    Parameters
    ----------
    run : ClosedLoopRun
        The run.

    Returns
    -------
    Sense
        What the controller was told last.
    """
    record = run.last_sense[0]
    scalars = {name: float(record[name]) for name in Sense._fields if name != "phase_currents"}
    return Sense(phase_currents=tuple(run.last_currents.tolist()), **scalars)
