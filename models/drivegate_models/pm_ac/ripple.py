"""Peak-to-peak torque at constant speed: for given duty ratios, and for ideal space-vector modulation."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.machine.rotor_frame import of_phase
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.fundamental import steady_voltages
from drivegate_models.pm_ac.plant.advance import PmAcPhases, follow_period, make_phases
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive, alignment_of


@unallocating
def swing_of_updates(
    drive: PmAcDrive,
    phases: PmAcPhases,
    angle: float,
    speed: float,
    link: float,
    ratios: NDArray[np.float64],
    legs: NDArray[np.int64],
    first: int,
    ignored: int,
    period: float,
    totals: NDArray[np.float64],
) -> float:
    """Return maximum minus minimum torque of the carrier's updates after the ignored ones.

    - `phases`: state before the first one, with `torque_bounds`; replaced by the state after the last.
    - `ratios`, `legs`, shape (n, 3): what acts in each.
    - `first`: number of the first one, on which the alignment depends.
    - `totals`, shape (ledger.ENTRIES,): the exact integrals are added to it.
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
                link,
                ratios[k],
                legs[k],
                alignment_of(drive.modulator.updates, first + k),
                period,
                totals,
            )
            != COMPLETED
        ):
            return inf
        if k >= ignored:
            least = min(least, phases.torque_bounds[0])
            most = max(most, phases.torque_bounds[1])
    return most - least


def commanded_swing(
    drive: PmAcDrive,
    currents: tuple[float, float],
    angle: float,
    speed: float,
    link: float,
    ratios: NDArray[np.float64],
    legs: NDArray[np.int64],
    *,
    first: int,
    ignored: int,
    period: float,
) -> float:
    """Return the peak-to-peak torque under given duty ratios.

    - `currents`: d-axis and q-axis currents at the start (A).
    - `angle`: electrical angle at the start (rad).
    - `speed`: constant speed of the shaft (rad/s).
    - `link`: voltage of the dc link (V).
    - `ratios`, shape (n, 3): duty ratios that act in each control period (1).
    - `legs`, shape (n, 3): states of the legs in each control period.
    - `first`: number of the first control period. With two updates per carrier period it must be even: every lower
      switch is on at its start.
    - `ignored`: number of control periods at the start that are not evaluated.
    - `period`: control period (s).
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
            float(link),
            np.repeat(ratios, every, axis=0),
            np.repeat(legs, every, axis=0),
            int(first),
            int(ignored) * every,
            float(period) / every,
            totals,
        )
    )


@inlined
def _write_ideal(ratios: NDArray[np.float64], along: float, across: float, link: float) -> None:
    """Write the duty ratios of a voltage in the stationary frame (V), centred in the link voltage (V)."""
    second, third = of_phase(1, along, across), of_phase(2, along, across)
    middle = 0.5 * (max(along, second, third) + min(along, second, third))
    ratios[0] = 0.5 + (along - middle) / link
    ratios[1] = 0.5 + (second - middle) / link
    ratios[2] = 0.5 + (third - middle) / link


@unallocating
def _ideal_ratios(
    direct: float, quadrature: float, turning: float, link: float, ratios: NDArray[np.float64]
) -> None:
    """Write the duty ratios of steady d-q voltages (V) for each control period, beginning at angle 0."""
    half = 0.5 * turning
    # A voltage that stands still while the rotor turns past it is less in the rotor's frame, by sin(x)/x.
    stretch = 1.0 + half * half / 6.0
    for k in range(ratios.shape[0]):
        cosine, sine = cosine_sine(k * turning + half)
        along = stretch * (cosine * direct - sine * quadrature)
        across = stretch * (sine * direct + cosine * quadrature)
        _write_ideal(ratios[k], along, across, link)


def ideal_swing(
    drive: PmAcDrive,
    speed: float,
    link: float,
    currents: tuple[float, float],
    *,
    ignored: int,
    watched: int,
    period: float,
) -> float:
    """Return the peak-to-peak torque of ideal space-vector modulation at steady currents.

    Ideal switches, without dead time and counter quantization, apply the voltage of the steady state in each control
    period. The zero sequence centres the maximum and the minimum duty ratio; these are the duty ratios of space
    vectors with equal zero vectors (Holmes and Lipo, "Pulse Width Modulation for Power Converters", IEEE Press, 2003,
    chapter 6).

    - `speed`: constant speed of the shaft (rad/s).
    - `link`: voltage of the dc link (V).
    - `currents`: mean d-axis and q-axis currents (A).
    - `ignored`: number of control periods at the start that are not evaluated, in which the currents settle.
    - `watched`: number of evaluated control periods after them.
    - `period`: control period (s).
    - Result: maximum minus minimum torque at any instant (N m); infinite if the plant's advance fails.
    """
    electrical = drive.pole_pairs * speed
    voltages = steady_voltages(drive, float(electrical), *currents)
    modulator = Modulator(updates=drive.modulator.updates, control_every=drive.modulator.control_every)
    ratios = np.empty((ignored + watched, 3))
    _ideal_ratios(*voltages, float(electrical * period), float(link), ratios)
    return commanded_swing(
        drive._replace(modulator=modulator, switch_drop=0.0, diode_drop=0.0),
        currents,
        0.0,
        speed,
        link,
        ratios,
        np.full(ratios.shape, LEG_PWM, np.int64),
        first=0,
        ignored=ignored,
        period=period,
    )
