"""What a controller of duty ratios senses in every period of a run, with the run's own trace."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tests.models.duty_runs import COLUMN, PERIOD
from tests.models.schedules import schedule_of

from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.restarting import Restarts
from drivegate_models.machine.load import LOCKED, Load
from drivegate_models.pm_ac.closed_loop import DutyRun, prepared_duty_loop
from drivegate_models.pm_ac.loop_inputs import DutyLoopInputs
from drivegate_models.pm_ac.plant.drive import PmAcDrive

Answer = Callable[[Any, Any], None]
"""From the record of a Sense to that of a command, which it fills in."""
_STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


@dataclass(frozen=True)
class Recorded:
    """A run and all that its controller sensed."""

    drive: PmAcDrive
    run: DutyRun
    senses: NDArray[Any]
    """Shape (n,) of DUTY_SENSE."""
    currents: NDArray[np.float64]
    """Where `phase_currents` of each Sense pointed, shape (n, 3) (A)."""

    def column(self, name: str) -> NDArray[np.float64]:
        """Return a column of the trace."""
        return self.run.trace[:, COLUMN[name]]

    def turned(self, begin: float = 0.0) -> NDArray[np.float64]:
        """Return the angle that the shaft has turned to at the start of each period, whole turns included (rad)."""
        before = np.concatenate(([0.0], self.column("speed")[:-1]))
        return begin + np.cumsum(before) * PERIOD


def _record(address: int, layout: np.dtype[Any]) -> Any:
    buffer = (ctypes.c_char * layout.itemsize).from_address(address)
    return np.frombuffer(buffer, layout).view(np.recarray)[0]


def _address(function: Any) -> int:
    return int(ctypes.cast(function, ctypes.c_void_p).value or 0)


def motoring(drive: PmAcDrive, share: float = 1.2) -> Answer:
    """Return answers of a voltage along the EMF when it acts, a share of its size."""
    ahead = drive.modulator.update_delay + 0.5

    def answer(sense: Any, command: Any) -> None:
        electrical = drive.pole_pairs * sense.speed
        size = share * electrical * drive.magnet_flux / sense.supply_voltage
        angle = drive.pole_pairs * sense.angle + ahead * electrical * PERIOD + 0.5 * pi
        for leg, name in enumerate(("first_duty", "second_duty", "third_duty")):
            command[name] = 0.5 + size * cos(angle - leg * 2.0 * pi / 3.0)

    return answer


def recorded(
    drive: PmAcDrive,
    speed: float,
    steps: int,
    answer: Answer,
    restarts: Sequence[int] = (),
    **options: Any,
) -> Recorded:
    """Run answers on a shaft whose speed is held, and record what is sensed; resets do nothing but come."""
    turning = options.get("turning")
    every = (
        steps + options.get("resting", 0) + options.get("waiting", 0) + (turning.periods if turning else 0)
    )
    senses, currents = np.zeros(every, DUTY_SENSE), np.zeros((every, 3))
    count = 0

    def step(_state: int, sense_address: int, command_address: int) -> None:
        nonlocal count
        sense, command = _record(sense_address, DUTY_SENSE), _record(command_address, DUTY_COMMAND)
        senses[count] = sense
        currents[count] = (ctypes.c_double * 3).from_address(int(sense["phase_currents"]))
        count += 1
        answer(sense, command)

    kept, reset = _STEP(step), _STEP(lambda *_: None)
    schedule = options.pop("schedule", None) or schedule_of(speed, 0.5 * drive.link_voltage)
    run = prepared_duty_loop(
        DutyLoopInputs(
            drive=drive,
            load=Load(LOCKED),
            schedule=schedule,
            control_period=PERIOD,
            duration=steps * PERIOD,
            initial_speed=speed,
            **options,
        ),
        SteppedController(_address(kept), 0),
        Restarts(np.array(restarts, np.int64), _address(reset)),
    ).run()
    assert run.status == COMPLETED
    return Recorded(drive, run, senses, currents)
