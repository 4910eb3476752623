"""The energy ledger of the shaft: works by kind, summed apart from the motion, against the change of kinetic energy.

In every control period::

    change of kinetic energy = MACHINE + BROUGHT - BRAKE - POWER - FAN - FRICTION - ROLLING - DRAG - HOIST - GRADE
    BRAKE, POWER, FAN, FRICTION, ROLLING, DRAG >= 0
    HOIST, GRADE = m g h

A work is a torque times the angle turned at the mean speed, in two parts where the shaft comes to rest within the
period. The height h follows from that angle and the weight, whatever torque has moved the shaft. A shaft whose speed is
prescribed has no ledger: its dynamometer supplies any energy.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.load import HOIST as HOIST_LOAD
from drivegate_models.machine.load import LOCKED, VEHICLE, Load

MACHINE: Final = 0
"""Work of the electromagnetic torque, without the drag by which floating phases supply their core loss (J)."""
BRAKE: Final = 1
"""Work of a constant torque (J)."""
POWER: Final = 2
"""Work of a constant power load (J)."""
FAN: Final = 3
"""Work of a fan (J)."""
FRICTION: Final = 4
"""Work of the shaft's friction (J)."""
ROLLING: Final = 5
"""Work of a vehicle's rolling resistance (J)."""
DRAG: Final = 6
"""Work of a vehicle's drag (J)."""
HOIST: Final = 7
"""Energy by which the weight on a drum is lifted (J); negative if it comes down."""
GRADE: Final = 8
"""Energy by which a vehicle is lifted on its road (J); negative downhill."""
BROUGHT: Final = 9
"""Energy of inertia that is coupled while it turns at the shaft's speed, less that of inertia that is uncoupled (J)."""
STOPPED: Final = 10
"""Energy taken by a rotor that locks (J)."""
BEGIN: Final = 11
"""Kinetic energy before the first control period (J)."""
KINETIC: Final = 12
"""Kinetic energy after the last control period (J)."""
INERTIA: Final = 13
"""Inertia of rotor and load in the last control period (kg m2); 0 before the first one."""
THROUGHPUT: Final = 14
"""Sum of the magnitudes of all works (J)."""
WORST: Final = 15
"""Maximum energy that a period misses or gains against the laws, over its throughput (1)."""
ENTRIES: Final = 16
"""Length of the array."""

OPPOSING: Final = ("BRAKE", "POWER", "FAN", "FRICTION", "ROLLING", "DRAG")
"""Names of the works that are never negative."""

# Energies below it (J) are not compared: shares of them lose digits to underflow.
_LEAST: Final = 1e-200


@inlined
def lifted_energy(load: Load, factor: float, angle: float) -> float:
    """Return the energy m g h by which a load's weight is lifted while the shaft turns by an angle (rad) (J)."""
    if load.kind == HOIST_LOAD:
        return load.size * factor * angle
    if load.kind == VEHICLE:
        # Weight times the way of the vehicle, times the sine of the slope.
        return load.size * angle * (factor / sqrt(1.0 + factor * factor))
    return 0.0


@inlined
def _share(energy: float, throughput: float) -> float:
    """Return the magnitude of an energy over the throughput (1); inf for what is not a number."""
    if throughput <= _LEAST:
        return 0.0
    share = abs(energy) / throughput
    return share if share == share else inf


@inlined
def account_shaft(
    account: NDArray[np.float64],
    load: Load,
    factor: float,
    inertia: float,
    motion: tuple[float, float, float],
    length: float,
    machine: float,
    opposing: float,
    drag: float,
    friction: float,
    damping: float,
) -> None:
    """Add a control period to the ledger, and check its laws.

    - `account`, shape (ENTRIES,): zeros at first, updated.
    - `load`, `factor`: load, and the factor on its size, or a vehicle's grade (1).
    - `inertia`: inertia of rotor and load in the period (kg m2).
    - `motion`: speed at the start, change of speed (rad/s), and share of the period before a standstill (1).
    - `length`: length of the period (s).
    - `machine`: mean torque of the machine, less its core drag (N m).
    - `opposing`, `drag`: torque of the load that opposes the rotation, and a vehicle's drag, a part of it (N m).
    - `friction`, `damping`: friction torque (N m), and friction torque over speed (N m s/rad).
    """
    begin, gained, share = motion
    end = begin + gained
    if account[INERTIA] == 0.0:
        account[INERTIA] = inertia
        account[BEGIN] = account[KINETIC] = 0.5 * inertia * begin * begin
    before = account[KINETIC]
    brought = 0.0 if inertia == account[INERTIA] else (inertia / account[INERTIA] - 1.0) * before
    mean, after = 0.5 * (begin + end), 0.0
    if share < 1.0:
        mean, after = 0.5 * begin, 0.5 * end
    first, second = mean * share * length, after * (1.0 - share) * length
    angle, way = first + second, abs(first) + abs(second)
    work = machine * angle
    loaded = opposing * way
    rubbed = friction * way + damping * (mean * first + after * second)
    lifted = lifted_energy(load, factor, angle)
    kinetic = 0.5 * inertia * end * end
    missing = kinetic - before - brought - work + loaded + rubbed + lifted
    moved = abs(work) + abs(loaded) + abs(rubbed) + abs(lifted)
    # NaN must not count as a loss either, hence the shares of both laws.
    driven = min(loaded, 0.0) + min(rubbed, 0.0)
    throughput = kinetic + before + moved
    account[WORST] = max(account[WORST], _share(missing, throughput), _share(driven, throughput))
    account[MACHINE] += work
    account[FRICTION] += rubbed
    if load.kind == VEHICLE:
        account[ROLLING] += loaded - drag * way
        account[DRAG] += drag * way
        account[GRADE] += lifted
    elif load.kind == HOIST_LOAD:
        account[HOIST] += lifted
    elif load.kind != LOCKED:
        # The kinds of load are numbered in the order of their entries.
        account[BRAKE + load.kind - 1] += loaded
    account[BROUGHT] += brought
    account[KINETIC] = kinetic
    account[INERTIA] = inertia
    account[THROUGHPUT] += moved + abs(brought)


@inlined
def stop_shaft(account: NDArray[np.float64]) -> None:
    """Add to the ledger, shape (ENTRIES,), that the rotor locks and takes the kinetic energy."""
    account[STOPPED] += account[KINETIC]
    account[KINETIC] = 0.0


def shaft_error(account: NDArray[np.float64]) -> float:
    """Return the worst violation of a run's ledger: of any control period, or of the whole run (1).

    `account`, shape (ENTRIES,): the ledger. Result: energy against the laws over the throughput.
    """
    taken = sum(float(account[entry]) for entry in (BRAKE, POWER, FAN, FRICTION, ROLLING, DRAG, HOIST, GRADE))
    expected = float(account[BEGIN] + account[MACHINE] + account[BROUGHT] - account[STOPPED]) - taken
    throughput = float(account[BEGIN] + account[KINETIC] + account[STOPPED] + account[THROUGHPUT])
    missing = abs(float(account[KINETIC]) - expected)
    whole = missing / throughput if throughput > _LEAST else 0.0
    worst = max(float(account[WORST]), whole)
    return worst if worst == worst else inf
