"""Peak-to-peak torque of ideal modulation: on ideal switches, and with the best that the drive's modulator can do.

On ideal switches, each control period has the voltage of the steady state. With dead time and forward drops, a
controller that knows the drive and its currents exactly chooses the duty ratios for which the currents at the end of
the control period are those on ideal switches. What counter steps and a shortest pulse round, it corrects as soon as a
sample shows it and the answer acts. What remains is the drive's own.
"""

from __future__ import annotations

from math import copysign, gcd, inf
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.machine.rotor_frame import of_phase
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.fundamental import steady_voltages
from drivegate_models.pm_ac.modulation_kind import CONTINUOUS
from drivegate_models.pm_ac.plant.advance import PmAcPhases, follow_period, make_phases
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive, alignment_of
from drivegate_models.pm_ac.zero_sequence import clamped_rail, write_ratios

TRIALS: Final = 8
"""Trials of duty ratios in a control period; each adds the voltage that the one before lacked."""
LEAD: Final = 8
"""Control periods in which the compensation settles before the evaluated ones; even, as a carrier's period may be."""
FEWEST_PARTS: Final = 8
"""Parts of a cycle in which samples lie at different places, at least."""
LONGEST_SPREAD: Final = 1000
"""Control periods up to which they do; a slower current is sampled several times next to zero."""


class _Steady(NamedTuple):
    """The steady state that modulation is to produce."""

    speed: float
    """Speed of the shaft (rad/s)."""
    turning: float
    """Electrical angle of a control period (rad)."""
    link: float
    """Voltage of the dc link (V)."""
    direct: float
    """d-axis voltage (V)."""
    quadrature: float
    """q-axis voltage (V)."""
    period: float
    """Control period (s)."""
    kind: int
    """Kind of modulation, as in `modulation_kind`."""


class _Workspace(NamedTuple):
    """Work space: duty ratios, and a machine for trials."""

    ratios: NDArray[np.float64]
    """Duty ratios of a trial, shape (3,) (1)."""
    best: NDArray[np.float64]
    """Duty ratios of the best trial, shape (3,) (1)."""
    legs: NDArray[np.int64]
    """`LEG_PWM` for each leg, shape (3,)."""
    bounds: NDArray[np.float64]
    """Minimum and maximum torque of the last control period, shape (2,) (N m)."""
    totals: NDArray[np.float64]
    """Exact integrals, shape (ledger.ENTRIES,)."""
    trial: PmAcPhases
    """Machine that a trial advances."""
    predicted: PmAcPhases
    """Machine as the controller expects it at the start of a control period."""


@inlined
def _voltage_in(steady: _Steady, number: int) -> tuple[float, float]:
    """Return the voltage of a control period in the stationary frame (V); the first one begins at angle 0."""
    half = 0.5 * steady.turning
    # A voltage that stands still while the rotor turns past it is less in the rotor's frame, by sin(x)/x.
    stretch = 1.0 + half * half / 6.0
    cosine, sine = cosine_sine(number * steady.turning + half)
    return (
        stretch * (cosine * steady.direct - sine * steady.quadrature),
        stretch * (sine * steady.direct + cosine * steady.quadrature),
    )


@unallocating
def _advance(
    drive: PmAcDrive,
    phases: PmAcPhases,
    steady: _Steady,
    number: int,
    ratios: NDArray[np.float64],
    workspace: _Workspace,
) -> int:
    """Advance a machine by a control period; `workspace.bounds` receives the extremes of its torque."""
    every = drive.modulator.control_every
    length = steady.period / every
    turning = drive.pole_pairs * steady.speed * length
    workspace.bounds[0] = inf
    workspace.bounds[1] = -inf
    for part in range(every):
        status = follow_period(
            drive,
            phases,
            number * steady.turning + part * turning,
            steady.speed,
            steady.link,
            ratios,
            workspace.legs,
            alignment_of(drive.modulator.updates, number),
            length,
            workspace.totals,
        )
        if status != COMPLETED:
            return int(status)
        workspace.bounds[0] = min(workspace.bounds[0], phases.torque_bounds[0])
        workspace.bounds[1] = max(workspace.bounds[1], phases.torque_bounds[1])
    return COMPLETED


@inlined
def _copy_state(source: PmAcPhases, target: PmAcPhases) -> None:
    """Copy the state of machine and modulators."""
    target.rotor_currents[0] = source.rotor_currents[0]
    target.rotor_currents[1] = source.rotor_currents[1]
    for leg in range(3):
        target.gates.levels[leg] = source.gates.levels[leg]
        target.gates.waits[leg] = source.gates.waits[leg]
        target.legs.signs[leg] = source.legs.signs[leg]


@inlined
def _set_currents(phases: PmAcPhases, direct: float, quadrature: float, angle: float) -> None:
    """Set the currents of the rotor frame (A) at an angle (rad), and the signs of the phase currents."""
    phases.rotor_currents[0] = direct
    phases.rotor_currents[1] = quadrature
    cosine, sine = cosine_sine(angle)
    along = cosine * direct - sine * quadrature
    across = sine * direct + cosine * quadrature
    for leg in range(3):
        value = of_phase(leg, along, across)
        phases.legs.signs[leg] = 1 if value > 0.0 else -1 if value < 0.0 else 0


@unallocating
def _follow_ideal(
    drive: PmAcDrive,
    phases: PmAcPhases,
    steady: _Steady,
    ignored: int,
    currents: NDArray[np.float64],
    workspace: _Workspace,
) -> float:
    """Return the peak-to-peak torque on ideal switches (N m).

    - `phases`: state before the first control period; replaced by the state after the last.
    - `ignored`: number of control periods at the start that are not evaluated.
    - `currents`, shape (n, 2): receives the d-axis and q-axis currents at the end of each control period (A).
    - Result: infinite if the plant's advance fails.
    """
    least = inf
    most = -inf
    for k in range(currents.shape[0]):
        along, across = _voltage_in(steady, k)
        rail = clamped_rail(steady.kind, along, across, 1.0 if steady.turning >= 0.0 else -1.0)
        write_ratios(workspace.ratios, along, across, steady.link, rail)
        if _advance(drive, phases, steady, k, workspace.ratios, workspace) != COMPLETED:
            return inf
        currents[k, 0] = phases.rotor_currents[0]
        currents[k, 1] = phases.rotor_currents[1]
        if k >= ignored:
            least = min(least, workspace.bounds[0])
            most = max(most, workspace.bounds[1])
    return most - least


@unallocating
def _choose_ratios(
    drive: PmAcDrive,
    phases: PmAcPhases,
    steady: _Steady,
    number: int,
    direct: float,
    quadrature: float,
    workspace: _Workspace,
) -> int:
    """Find the duty ratios of a control period that bring the currents nearest to given ones (A) at its end.

    `phases`: state at the start. `workspace.best` receives the duty ratios. A trial adds the mean voltage that the one
    before lacked: the distance of the flux linkage from the requested one, over the period. The best trial counts,
    since a current that rests at zero, or a leg at its rail, may leave all of them at a distance.
    """
    along, across = _voltage_in(steady, number)
    sense = 1.0 if steady.turning >= 0.0 else -1.0
    rail = clamped_rail(steady.kind, along, across, sense)
    cosine, sine = cosine_sine((number + 0.5) * steady.turning)
    least = inf
    for _ in range(TRIALS):
        write_ratios(workspace.ratios, along, across, steady.link, rail)
        _copy_state(phases, workspace.trial)
        status = _advance(drive, workspace.trial, steady, number, workspace.ratios, workspace)
        if status != COMPLETED:
            return int(status)
        missing_along = drive.direct_inductance * (direct - workspace.trial.rotor_currents[0])
        missing_across = drive.quadrature_inductance * (quadrature - workspace.trial.rotor_currents[1])
        distance = missing_along * missing_along + missing_across * missing_across
        if distance < least:
            least = distance
            for leg in range(3):
                workspace.best[leg] = workspace.ratios[leg]
        along += (cosine * missing_along - sine * missing_across) / steady.period
        across += (sine * missing_along + cosine * missing_across) / steady.period
    return COMPLETED


@unallocating
def _follow_compensated(
    drive: PmAcDrive,
    exact: PmAcDrive,
    phases: PmAcPhases,
    steady: _Steady,
    ignored: int,
    currents: NDArray[np.float64],
    workspace: _Workspace,
) -> float:
    """Return the peak-to-peak torque of a controller that follows currents by the best duty ratios (N m).

    With a delay, it chooses them from the sample before, and from what its last ones do if nothing rounds them.

    - `exact`: the drive with a modulator that rounds nothing, by which the controller chooses.
    - `phases`: machine with modulators that have commanded the lower switches; its state is replaced.
    - `ignored`: number of control periods at the start that are not evaluated.
    - `currents`, shape (n, 2): d-axis and q-axis currents to have at the end of each control period (A).
    - Result: infinite if the plant's advance fails.
    """
    first = max(ignored - LEAD, 1)
    if drive.modulator.updates == 2:
        # Every lower switch is on at the start of an even one.
        first += first % 2
    _set_currents(phases, currents[first - 1, 0], currents[first - 1, 1], first * steady.turning)
    predicted = workspace.predicted
    _copy_state(phases, predicted)
    least = inf
    most = -inf
    for k in range(first, currents.shape[0]):
        if (
            _choose_ratios(exact, predicted, steady, k, currents[k, 0], currents[k, 1], workspace)
            != COMPLETED
        ):
            return inf
        if drive.modulator.update_delay > 0:
            _copy_state(phases, predicted)
            if _advance(exact, predicted, steady, k, workspace.best, workspace) != COMPLETED:
                return inf
        if _advance(drive, phases, steady, k, workspace.best, workspace) != COMPLETED:
            return inf
        if drive.modulator.update_delay == 0:
            _copy_state(phases, predicted)
        if k >= ignored:
            least = min(least, workspace.bounds[0])
            most = max(most, workspace.bounds[1])
    return most - least


def has_ideal_switches(drive: PmAcDrive) -> bool:
    """Return True if nothing of the bridge and its modulator has to be compensated."""
    modulator = drive.modulator
    rounding = (modulator.counter_levels, modulator.dead_time, modulator.minimum_pulse)
    return not any((*rounding, drive.switch_drop, drive.diode_drop))


def spread_samples(speed: float, part: float, watched: int) -> tuple[float, int]:
    """Return a speed next to a given one, and control periods whose samples lie all over a part of a cycle.

    Where a current passes zero between two samples decides what dead time leaves of it. If a part of a cycle has whole
    control periods, that is the same in each part, and by chance more or less than elsewhere.

    - `speed`: speed of the shaft (rad/s).
    - `part`: what the shaft turns until the torque repeats itself, over the control period (rad/s).
    - `watched`: number of control periods to evaluate, about (1).
    """
    parts = max(round(watched * abs(speed) / part), FEWEST_PARTS)
    periods = round(parts * part / abs(speed))
    if periods > LONGEST_SPREAD:
        return speed, watched
    while gcd(periods, parts) > 1:
        periods += 1
    return copysign(parts * part / periods, speed), periods


def ideal_swing(
    drive: PmAcDrive,
    speed: float,
    link: float,
    currents: tuple[float, float],
    *,
    ignored: int,
    watched: int,
    period: float,
    kind: int = CONTINUOUS,
) -> float:
    """Return the peak-to-peak torque of ideal modulation at steady currents.

    The controller knows the drive and its currents exactly: it compensates dead time and forward drops. What counter
    and shortest pulse round, it sees in the next sample.

    - `speed`: constant speed of the shaft (rad/s).
    - `link`: voltage of the dc link (V).
    - `currents`: mean d-axis and q-axis currents (A).
    - `ignored`: number of control periods at the start that are not evaluated, in which the currents settle.
    - `watched`: number of evaluated control periods after them.
    - `period`: control period (s).
    - `kind`: kind of modulation, as in `modulation_kind`.
    - Result: maximum minus minimum torque at any instant (N m); infinite if the plant's advance fails.
    """
    electrical = drive.pole_pairs * speed
    direct, quadrature = steady_voltages(drive, float(electrical), float(currents[0]), float(currents[1]))
    steady = _Steady(
        float(speed),
        float(electrical * period),
        float(link),
        float(direct),
        float(quadrature),
        float(period),
        int(kind),
    )
    workspace = _Workspace(
        np.zeros(3),
        np.zeros(3),
        np.full(3, LEG_PWM, np.int64),
        np.zeros(2),
        np.zeros(ledger.ENTRIES),
        make_phases(follows_torque=True),
        make_phases(follows_torque=True),
    )
    modulator = Modulator(updates=drive.modulator.updates, control_every=drive.modulator.control_every)
    ideal = drive._replace(modulator=modulator, switch_drop=0.0, diode_drop=0.0)
    ends = np.zeros((ignored + watched, 2))
    phases = make_phases(follows_torque=True)
    _set_currents(phases, float(currents[0]), float(currents[1]), 0.0)
    swing = float(_follow_ideal(ideal, phases, steady, int(ignored), ends, workspace))
    if has_ideal_switches(drive) or swing == inf:
        return swing
    exact = drive._replace(modulator=modulator._replace(dead_time=drive.modulator.dead_time))
    return float(
        _follow_compensated(
            drive, exact, make_phases(follows_torque=True), steady, int(ignored), ends, workspace
        )
    )
