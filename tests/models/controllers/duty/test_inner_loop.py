"""Controllers of current reference and advance angle run on duty ratios, through the inner loop of currents."""

from __future__ import annotations

import ctypes
import math

import numpy as np
import pytest
from tests.models.duty_runs import COLUMN, PERIOD, course, limits_of, nameplate_of, rating
from tests.models.pm_ac.conftest import INTERIOR, SURFACE

from drivegate_models.contract.current.records import COMMAND, SENSE, nameplate_record
from drivegate_models.contract.duty.records import duty_nameplate_record
from drivegate_models.controllers.current.builtin import SEARCHES, reset_function, step_function
from drivegate_models.controllers.current.state import CONTROLLER_STATE
from drivegate_models.controllers.duty.inner_loop import (
    INNER_STATE,
    inner_reset_function,
    inner_state,
    inner_step_function,
)
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.schedule import Course, steady
from drivegate_models.machine.load import CONSTANT_TORQUE, LOCKED, Load
from drivegate_models.pm_ac.closed_loop import DutyRun, prepared_duty_loop
from drivegate_models.pm_ac.loop_inputs import DutyLoopInputs
from drivegate_models.pm_ac.oracle import CURRENT, Limits, least_at
from drivegate_models.pm_ac.outer_nameplate import outer_nameplate
from drivegate_models.pm_ac.plant.drive import PmAcDrive, make_pm_ac_drive

_STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


def run_inner(
    drive: PmAcDrive, load: Load, speed: Course, duration: float, outer: tuple[int, int], periods: int
) -> DutyRun:
    """Run a step of current references, by its addresses, on a drive."""
    state = inner_state(*outer, periods)
    assert state.dtype == INNER_STATE
    inner_reset_function()(state, duty_nameplate_record(nameplate_of(drive)))
    return prepared_duty_loop(
        DutyLoopInputs(
            drive=drive,
            load=load,
            schedule=course(drive, speed, steady(1.0)),
            control_period=PERIOD,
            duration=duration,
            initial_speed=float(speed.values[0]),
        ),
        SteppedController(inner_step_function().address, state.ctypes.data),
    ).run()


def run_builtin(drive: PmAcDrive, name: str, torque: float, speed: Course, duration: float) -> DutyRun:
    """Run a built-in controller of current references on a drive, at half a millisecond."""
    _, power = rating(drive)
    nameplate = outer_nameplate(nameplate_of(drive)._replace(rated_power=0.7 * power), 5)
    state = np.zeros(1, CONTROLLER_STATE)
    reset_function()(state, nameplate_record(nameplate), SEARCHES[name])
    outer = (step_function().address, state.ctypes.data)
    return run_inner(drive, Load(CONSTANT_TORQUE, torque), speed, duration, outer, 5)


@pytest.mark.parametrize("constants", [INTERIOR, SURFACE], ids=["interior", "surface"])
@pytest.mark.parametrize(("speed", "share"), [(1.2, 0.7), (1.5, 0.3), (3.0, 0.7)])
def test_the_reference_finds_the_least_current(
    constants: dict[str, float], speed: float, share: float
) -> None:
    drive = make_pm_ac_drive(**constants)
    base, power = rating(drive)
    run = run_builtin(drive, "reference", 0.7 * share * power / (speed * base), steady(speed * base), 6.0)
    assert run.status == COMPLETED
    late = run.trace[-3000:]
    assert late[:, COLUMN["speed"]].mean() == pytest.approx(speed * base, rel=1e-3)
    current = np.hypot(late[:, COLUMN["direct"]], late[:, COLUMN["quadrature"]]).mean()
    made = late[:, COLUMN["torque"]].mean()
    least = least_at(drive, limits_of(drive), speed * base, made, CURRENT)
    # Less than the least may be taken in overmodulation, which the oracle's limit of voltage leaves out.
    assert current == pytest.approx(least.current, rel=1e-2)
    assert run.worst_balance < 1e-9


def test_the_search_improves_on_the_initial_line() -> None:
    drive = make_pm_ac_drive(**INTERIOR)
    base, power = rating(drive)
    ends = []
    for name in ("initial", "reference"):
        run = run_builtin(drive, name, 0.21 * power / (1.5 * base), steady(1.5 * base), 6.0)
        late = run.trace[-3000:]
        ends.append(np.hypot(late[:, COLUMN["direct"]], late[:, COLUMN["quadrature"]]).mean())
    assert ends[1] < 0.9 * ends[0], f"{ends[1]:.3f} A with the search, {ends[0]:.3f} A without"


def test_the_nameplate_states_the_line_of_least_current() -> None:
    drive = make_pm_ac_drive(**INTERIOR)
    base, power = rating(drive)
    stated = outer_nameplate(nameplate_of(drive)._replace(rated_power=0.7 * power), 5)
    assert stated.control_period == pytest.approx(5e-4)
    limits = Limits(drive.current_limit, 0.95 * limits_of(drive).voltage)
    for speed in (base, 3.0 * base):
        least = least_at(drive, limits, speed, 0.7 * power / speed, CURRENT)
        angle = stated.advance_start + stated.advance_slope * (speed - base)
        assert angle == pytest.approx(math.atan2(-least.direct, least.quadrature), rel=1e-12)


def answering(
    current: float, angle: float, seen: list[tuple[float, ...]], size: int | None = None
) -> tuple[object, int]:
    """Return an outer step that always answers the same and notes what it sees, and its address."""

    def step(_state: int, sense: int, command: int) -> None:
        buffer = (ctypes.c_char * COMMAND.itemsize).from_address(command)
        record = np.frombuffer(buffer, COMMAND)
        record.flags.writeable = True
        assert record["struct_size"][0] == COMMAND.itemsize
        record["current_reference"] = current
        record["advance_angle"] = angle
        if size is not None:
            record["struct_size"] = size
        stated = np.frombuffer((ctypes.c_char * SENSE.itemsize).from_address(sense), SENSE)[0]
        seen.append(
            tuple(float(stated[name]) for name in ("time", "current_magnitude_sum", "half_supply_voltage"))
        )

    kept = _STEP(step)
    return kept, int(ctypes.cast(kept, ctypes.c_void_p).value or 0)


def test_reference_and_angle_become_currents_of_the_rotor_frame() -> None:
    drive = make_pm_ac_drive(**INTERIOR)
    seen: list[tuple[float, ...]] = []
    kept, address = answering(3.0, 0.5, seen)
    run = run_inner(drive, Load(LOCKED, 0.0), steady(50.0), 0.1, (address, 0), 5)
    assert kept is not None
    assert run.status == COMPLETED
    late = run.trace[-100:]
    assert late[:, COLUMN["direct"]].mean() == pytest.approx(-3.0 * math.sin(0.5), rel=2e-2)
    assert late[:, COLUMN["quadrature"]].mean() == pytest.approx(3.0 * math.cos(0.5), rel=2e-2)
    assert [row[0] for row in seen] == pytest.approx([5.0 * PERIOD * k for k in range(200)])
    # Three sines of 3 A.
    assert np.mean([row[1] for row in seen[100:]]) == pytest.approx(3.0 * 6.0 / math.pi, rel=2e-2)
    assert seen[-1][2] == pytest.approx(0.5 * drive.link_voltage)


@pytest.mark.parametrize(
    ("current", "size", "status"), [(math.nan, None, NOT_FINITE), (1.0, -1, STOPPED)], ids=["nan", "stop"]
)
def test_an_outer_controller_without_an_answer_ends_the_run(
    current: float, size: int | None, status: int
) -> None:
    drive = make_pm_ac_drive(**INTERIOR)
    kept, address = answering(current, 0.0, [], size)
    run = run_inner(drive, Load(CONSTANT_TORQUE, 0.0), steady(10.0), 0.01, (address, 0), 1)
    assert kept is not None
    assert (run.status, run.steps) == (status, 0)
