"""The yardstick: the closed loop written by hand in C, compiled here and run in lock-step with drivegate's own."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.native.bounded_command import COMPILATION, run_bounded
from drivegate.candidates.native.compiler import C, found_compiler, include_folder
from drivegate.scenarios.plant_inputs import plant_load, plant_schedule
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import HarnessFault, InputError
from drivegate_models.machine.load import CONSTANT_TORQUE
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate.candidates.controller import Controller
    from drivegate_cases.scenario.scenario import Scenario
    from drivegate_models.steady.plant import AnyDrive

FLAGS: Final = ("-std=c11", "-O3", "-march=native", "-ffp-contract=fast")
"""Flags that the yardstick is compiled with."""
FOLDER: Final = Path(__file__).resolve().parent / "c_yardstick"
"""Its folder."""
SOURCE: Final = "yardstick.c"
"""Name of its source there."""
RECORD: Final = ("speed", "current_reference", "advance", "current_sum", "impulse", "source")
"""What it can record of each control period, in SI units."""

_CONSTANTS = (
    "resistance",
    "inductance",
    "emf_constant",
    "half_supply_voltage",
    "hysteresis_band",
    "window",
    "current_limit",
    "core_loss_conductance",
    "inertia",
    "friction",
    "viscous_friction",
    "switch_drop",
    "diode_drop",
    "turn_on_energy",
    "turn_off_energy",
)
_LEDGER_ENTRIES = 13


class _Drive(ctypes.Structure):
    _fields_ = [
        ("phases", ctypes.c_int64),
        ("pole_pairs", ctypes.c_int64),
        *((name, ctypes.c_double) for name in _CONSTANTS),
        ("pieces", ctypes.c_int64),
        ("emf_angles", ctypes.c_void_p),
        ("emf_values", ctypes.c_void_p),
        ("emf_slopes", ctypes.c_void_p),
    ]


class _Task(ctypes.Structure):
    _fields_ = [
        ("initial_speed", ctypes.c_double),
        ("speed_reference", ctypes.c_double),
        ("base_speed", ctypes.c_double),
        ("control_period", ctypes.c_double),
        ("steps", ctypes.c_int64),
        ("load_points", ctypes.c_int64),
        ("load_times", ctypes.c_void_p),
        ("load_torques", ctypes.c_void_p),
        ("step", ctypes.c_void_p),
        ("state", ctypes.c_void_p),
    ]


class _Result(ctypes.Structure):
    _fields_ = [
        ("totals", ctypes.c_double * _LEDGER_ENTRIES),
        ("speed", ctypes.c_double),
        ("shaft_energy", ctypes.c_double),
        ("input_energy", ctypes.c_double),
        ("kinetic_residual", ctypes.c_double),
        ("worst_mismatch", ctypes.c_double),
    ]


@dataclass(frozen=True)
class YardstickRun:
    """What the yardstick makes of a run.

    Attributes
    ----------
    totals : ndarray, shape (drivegate_models.machine.ledger.ENTRIES,)
        Exact integrals over the run, in the ledger's order.
    speed : float
        Speed at the end (rad/s).
    mismatch : float
        Worst residual of the energy in a control period, over its throughput (1).
    rows : ndarray, shape (n, len(RECORD))
        One row for each control period; n = 0 where none was requested.
    """

    totals: NDArray[np.float64]
    speed: float
    mismatch: float
    rows: NDArray[np.float64]


class Yardstick:
    """The compiled yardstick."""

    def __init__(self, library: Path) -> None:
        self._run = ctypes.CDLL(str(library)).yardstick_run
        self._run.restype = ctypes.c_int

    def prepared(self, scenario: Scenario, controller: Controller | None = None) -> PreparedRun:
        """Lay out a run, so that nothing but the run itself is timed."""
        return PreparedRun(self._run, scenario, controller)


class PreparedRun:
    """A run that the yardstick makes as often as it is called."""

    def __init__(self, function: Any, scenario: Scenario, controller: Controller | None) -> None:
        load, schedule = plant_load(scenario), plant_schedule(scenario)
        steady = (
            schedule.speed,
            schedule.supply,
            schedule.imbalance,
            schedule.resistance,
            schedule.emf_constant,
        )
        if load.kind != CONSTANT_TORQUE or any(np.ptp(course.values) > 0.0 for course in steady):
            raise HarnessFault("the yardstick knows constant torque at steady speed and supply only")
        self._function, self._controller, self._scenario = function, controller, scenario
        drive: AnyDrive = scenario.drive.plant(scenario.scales)
        # The supply that a schedule gives is the one that the plant has.
        drive = drive._replace(half_supply_voltage=float(schedule.supply.values[0]))
        times, torques = schedule.load.times, load.size * schedule.load.values
        self._arrays = (times, torques, drive.emf_angles, drive.emf_values, drive.emf_slopes)
        self._drive = _Drive(
            phases=drive.phases,
            pole_pairs=drive.pole_pairs,
            pieces=drive.emf_slopes.size,
            emf_angles=drive.emf_angles.ctypes.data,
            emf_values=drive.emf_values.ctypes.data,
            emf_slopes=drive.emf_slopes.ctypes.data,
            **{name: getattr(drive, name) for name in _CONSTANTS},
        )
        self._task = _Task(
            initial_speed=scenario.initial_speed_rpm * RADIANS_PER_RPM,
            speed_reference=float(schedule.speed.values[0]),
            base_speed=scenario.nameplate().base_speed,
            control_period=scenario.control_period_s,
            steps=scenario.control_periods,
            load_points=times.size,
            load_times=times.ctypes.data,
            load_torques=torques.ctypes.data,
            step=controller.step_address if controller is not None else None,
            state=controller.state_address if controller is not None else None,
        )

    def __call__(self, *, recorded: bool = False) -> YardstickRun:
        """Reset the controller and run."""
        if self._controller is not None:
            self._controller.reset(self._scenario.nameplate())
        rows = np.zeros((self._task.steps if recorded else 0, len(RECORD)))
        result = _Result()
        status = self._function(
            ctypes.byref(self._drive),
            ctypes.byref(self._task),
            ctypes.byref(result),
            ctypes.c_void_p(rows.ctypes.data if recorded else None),
        )
        if status != 0:
            raise HarnessFault("the yardstick's run came to no end")
        return YardstickRun(np.array(result.totals), result.speed, result.worst_mismatch, rows)


def build_yardstick(folder: Path, scratch: Path, name: str = SOURCE) -> Path:
    """Compile a yardstick."""
    library = scratch / Path(name).with_suffix(".so")
    source = str(folder.resolve() / name)
    words = [*found_compiler(C), *FLAGS, "-fPIC", "-shared", f"-I{include_folder()}", source]
    environment = {"LC_ALL": "C", "TMPDIR": str(scratch)}
    ended = run_bounded(
        [*words, "-o", str(library), "-lm"], folder=scratch, environment=environment, bounds=COMPILATION
    )
    if ended.status != 0:
        reported = next(
            (line for line in ended.output.splitlines() if "error" in line), "it reported nothing"
        )
        raise InputError(
            f"{shown_path(folder / name)} does not compile with {' '.join(FLAGS)}: {one_line(reported)}"
        )
    return library
