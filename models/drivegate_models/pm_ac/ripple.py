"""Peak-to-peak torque at constant speed for given duty ratios."""

from __future__ import annotations

from math import inf
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import unallocating
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.machine.rotor_frame import of_phase
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.plant.advance import PmAcPhases, follow_period, make_phases
from drivegate_models.pm_ac.plant.drive import PmAcDrive, alignment_of

NONE_KEPT: Final = np.empty((0, 2))
"""No room for extremes."""


@unallocating
def swing_of_updates(
    drive: PmAcDrive,
    phases: PmAcPhases,
    angle: float,
    speed: float,
    links: NDArray[np.float64],
    ratios: NDArray[np.float64],
    legs: NDArray[np.int64],
    first: int,
    ignored: int,
    period: float,
    totals: NDArray[np.float64],
    extremes: NDArray[np.float64],
) -> float:
    """Return maximum minus minimum torque of the carrier's updates after the ignored ones.

    - `phases`: state before the first one, with `torque_bounds`; replaced by the state after the last.
    - `links`, shape (n,): voltage of the dc link in each (V).
    - `ratios`, `legs`, shape (n, 3): what acts in each.
    - `first`: number of the first one, on which the alignment depends.
    - `totals`, shape (ledger.ENTRIES,): the exact integrals are added to it.
    - `extremes`, shape (k, 2): receives minimum and maximum torque of the first k updates (N m).
    - Other arguments: as for `commanded_swing`, but `period` is that of an update.
    - Result: N m; infinite if the plant's advance fails.
    """
    turning = drive.pole_pairs * speed * period
    least = inf
    most = -inf
    for k in range(ratios.shape[0]):
        if (
            follow_period(
                drive,
                phases,
                angle + k * turning,
                speed,
                links[k],
                ratios[k],
                legs[k],
                alignment_of(drive.modulator.updates, first + k),
                period,
                totals,
            )
            != COMPLETED
        ):
            return inf
        if k < extremes.shape[0]:
            extremes[k, 0] = phases.torque_bounds[0]
            extremes[k, 1] = phases.torque_bounds[1]
        if k >= ignored:
            least = min(least, phases.torque_bounds[0])
            most = max(most, phases.torque_bounds[1])
    return most - least


def commanded_swing(
    drive: PmAcDrive,
    currents: tuple[float, float],
    angle: float,
    speed: float,
    links: NDArray[np.float64],
    ratios: NDArray[np.float64],
    legs: NDArray[np.int64],
    *,
    first: int,
    ignored: int,
    period: float,
    extremes: NDArray[np.float64] = NONE_KEPT,
) -> float:
    """Return the peak-to-peak torque under given duty ratios.

    - `currents`: d-axis and q-axis currents at the start (A).
    - `angle`: electrical angle at the start (rad).
    - `speed`: constant speed of the shaft (rad/s).
    - `links`, shape (n,): voltage of the dc link in each control period (V).
    - `ratios`, shape (n, 3): duty ratios that act in each control period (1).
    - `legs`, shape (n, 3): states of the legs in each control period.
    - `first`: number of the first control period. With two updates per carrier period it must be even: every lower
      switch is on at its start.
    - `ignored`: number of control periods at the start that are not evaluated.
    - `period`: control period (s).
    - `extremes`, shape (k, 2): receives minimum and maximum torque of the first k carrier updates (N m).
    - Result: maximum minus minimum torque at any instant (N m); infinite if the plant's advance fails.
    """
    phases = make_phases(follows_torque=True)
    phases.rotor_currents[:] = currents
    cosine, sine = cosine_sine(float(angle))
    along = cosine * currents[0] - sine * currents[1]
    across = sine * currents[0] + cosine * currents[1]
    values = [of_phase(leg, along, across) for leg in range(3)]
    phases.legs.signs[:] = [1 if value > 0.0 else -1 if value < 0.0 else 0 for value in values]
    totals = np.zeros(ledger.ENTRIES)
    every = drive.modulator.control_every
    return float(
        swing_of_updates(
            drive,
            phases,
            float(angle),
            float(speed),
            np.repeat(links, every),
            np.repeat(ratios, every, axis=0),
            np.repeat(legs, every, axis=0),
            int(first),
            int(ignored) * every,
            float(period) / every,
            totals,
            extremes,
        )
    )
