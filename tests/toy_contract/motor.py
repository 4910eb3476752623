"""The plant: armature current and speed of a DC motor, exact over a control period of constant voltage."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.linalg import expm

from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.scenario.piecewise import value_from
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

DRIVE_FILE = Path(__file__).with_name("toy-motor.json")
SENSE = np.dtype(
    [("struct_size", "i8"), ("time", "f8"), ("speed", "f8"), ("phase_currents", "i8"), ("reference", "f8")]
)
COMMAND = np.dtype([("struct_size", "i8"), ("voltage", "f8")])
STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


class ToySense(NamedTuple):
    struct_size: int
    time: float
    speed: float
    phase_currents: tuple[float, ...]
    reference: float


class ToyDrive(DriveDocument):
    contract = "toy"
    kind: Literal["toy-motor"] = Field(description="kind of drive")  # type: ignore[assignment]
    __hash__ = DriveDocument.__hash__


@dataclass(frozen=True)
class ToyRun:
    scenario: Scenario
    trace: NDArray[np.float64]
    """Time (s), speed (rad/s), current (A), voltage (V), shape (steps, 4)."""
    commands: NDArray[Any]

    @property
    def digest(self) -> int:
        return hash(self.commands.tobytes())


def run_motor(scenario: Scenario, step: Any) -> ToyRun:
    """Run a step function, from records of sense, current and command to nothing, against the motor."""
    machine, period = scenario.drive.machine, scenario.control_period_s
    k, r = machine.emf_constant_v_s_per_rad, machine.resistance_ohm
    load = scenario.load.torque_at(scenario.speed_rpm[0][1], 1.0)  # type: ignore[union-attr]
    # Of current, speed, voltage and load torque, the last two are constant in a period.
    rates = np.zeros((4, 4))
    rates[0, :3] = np.array([-r, -k, 1.0]) / machine.inductance_h
    rates[1] = np.array([k, 0.0, 0.0, -1.0]) / machine.inertia_kg_m2
    ahead = expm(rates * period)
    current, speed = 0.0, scenario.initial_speed_rpm * RADIANS_PER_RPM
    rows, commands = np.zeros((scenario.control_periods, 4)), np.zeros(scenario.control_periods, COMMAND)
    sense, currents = np.zeros(1, SENSE), np.zeros(machine.phases)
    sense["struct_size"], sense["phase_currents"] = SENSE.itemsize, currents.ctypes.data
    for place in range(scenario.control_periods):
        now = place * period
        currents[0], sense["time"], sense["speed"] = current, now, speed
        sense["reference"] = value_from(scenario.speed_rpm, now) * RADIANS_PER_RPM
        commands[place]["struct_size"] = COMMAND.itemsize
        step(sense, commands[place : place + 1])
        voltage = commands[place]["voltage"]
        rows[place] = now, speed, current, voltage
        current, speed, *_ = ahead @ np.array([current, speed, voltage, load])
    return ToyRun(scenario, rows, commands)


def called(controller: Any) -> Any:
    """Return what steps a controller by its addresses."""
    function = STEP(controller.step_address)
    return lambda sense, command: function(controller.state_address, sense.ctypes.data, command.ctypes.data)


def toy_drive() -> ToyDrive:
    return load_drive(DRIVE_FILE)  # type: ignore[return-value]
