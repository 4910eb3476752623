"""The closed loop of duty ratios against the same algorithm by hand in C: in lock-step, and how much slower."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_lab.bench.workbench import NotMeasured, Value, Workbench
from drivegate_models.contract.duty.records import DUTY_COMMAND, duty_command_record, duty_nameplate_record
from drivegate_models.controllers.duty.foc import reset_function, step_function
from drivegate_models.controllers.duty.state import FOC_STATE
from drivegate_models.machine import ledger
from drivegate_models.pm_ac.closed_loop import DutyRun
from drivegate_models.pm_ac.loop_records import TRACE
from duty_rates import PERIOD, SPEED, TORQUE, foc_run, interior_drive, interior_nameplate
from yardstick_ratio import LOCK_STEP_TOLERANCE, TURNS, compiled_library, ratio_in_turns

SIMULATED: Final = 8.0
"""Simulated time of a run (s)."""
RECORD: Final = ("speed", "torque", "direct", "quadrature", "peak_current", "input_power")
"""What the yardstick records of each control period, in SI units, by the names of drivegate's trace."""
SOURCE: Final = "duty.c"
"""Its source."""


class _Task(ctypes.Structure):
    _fields_ = [
        *(
            (name, ctypes.c_double)
            for name in (
                "resistance",
                "direct",
                "quadrature",
                "flux",
                "core",
                "inertia",
                "friction",
                "viscous",
                "current_limit",
                "pole_pairs",
                "link",
                "load",
                "reference",
                "period",
                "speed",
            )
        ),
        ("steps", ctypes.c_int64),
        ("step", ctypes.c_void_p),
        ("state", ctypes.c_void_p),
        ("fresh", ctypes.c_char * DUTY_COMMAND.itemsize),
    ]


class DutyYardstick:
    """The compiled yardstick, with the run that `duty_rates` measures."""

    def __init__(self, library: Path, simulated: float) -> None:
        self._run = ctypes.CDLL(str(library)).duty_yardstick_run
        self._run.restype = ctypes.c_double
        self._state = np.zeros(1, FOC_STATE)
        drive = interior_drive(0.0)
        self._nameplate = duty_nameplate_record(interior_nameplate(drive))
        self._task = _Task(
            resistance=drive.resistance,
            direct=drive.direct_inductance,
            quadrature=drive.quadrature_inductance,
            flux=drive.magnet_flux,
            core=drive.core_loss_conductance,
            inertia=drive.inertia,
            friction=drive.friction,
            viscous=drive.viscous_friction,
            current_limit=drive.current_limit,
            pole_pairs=drive.pole_pairs,
            link=drive.link_voltage,
            load=TORQUE,
            reference=SPEED,
            period=PERIOD,
            speed=SPEED,
            steps=round(simulated / PERIOD),
            step=step_function().address,
            state=self._state.ctypes.data,
        )
        fresh = duty_command_record().tobytes()
        ctypes.memmove(ctypes.addressof(self._task) + _Task.fresh.offset, fresh, len(fresh))

    def __call__(self, rows: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """Reset the controller, run, and return the ledger's totals; `rows` receives each control period."""
        self._state[:] = 0
        reset_function()(self._state, self._nameplate)
        totals = np.zeros(ledger.ENTRIES)
        kept = None if rows is None else ctypes.c_void_p(rows.ctypes.data)
        worst = self._run(ctypes.byref(self._task), ctypes.c_void_p(totals.ctypes.data), kept)
        if not worst <= LOCK_STEP_TOLERANCE:
            raise NotMeasured(f"the yardstick misses {worst:.0e} of a control period's energy")
        return totals

    def rows(self) -> NDArray[np.float64]:
        """Return room for what it records."""
        return np.zeros((self._task.steps, len(RECORD)))


def yardstick_ratio(bench: Workbench) -> Value:
    """Measure the closed loop of duty ratios against the yardstick in C, run by run in turns."""
    simulated = bench.simulated(SIMULATED)
    yardstick = DutyYardstick(compiled_library(bench.scratch, SOURCE), simulated)

    def ours() -> DutyRun:
        drive = interior_drive(0.0)
        return foc_run(drive, interior_nameplate(drive), SPEED, TORQUE, simulated)

    rows = yardstick.rows()
    totals = yardstick(rows)
    apart = difference(ours(), rows, totals)
    return ratio_in_turns((ours, yardstick), simulated, TURNS * bench.rounds, apart)


def difference(run: DutyRun, rows: NDArray[np.float64], totals: NDArray[np.float64]) -> float:
    """Return the greatest difference of both in any control period or integral, over the greatest value of each."""
    signals = [_apart(run.trace[:, TRACE.index(name)], rows[:, column]) for column, name in enumerate(RECORD)]
    integrals = [entry for entry in range(ledger.ENTRIES) if entry not in (ledger.EVENTS, ledger.SWITCHING)]
    return max(*signals, *(_apart(run.totals[entry], totals[entry]) for entry in integrals))


def _apart(ours: Any, theirs: Any) -> float:
    """Return the greatest difference over the greatest value, or the difference itself where there is none."""
    size = float(np.max(np.abs(ours)))
    return float(np.max(np.abs(ours - theirs))) / (size or 1.0)
