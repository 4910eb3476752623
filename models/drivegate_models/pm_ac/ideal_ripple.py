"""Peak-to-peak torque of ideal modulation: on ideal switches, and with the best that the drive's modulator can do.

On ideal switches, each control period has the voltage of the steady state. With dead time and forward drops, a
controller that knows the drive and its currents exactly chooses the duty ratios for which the currents at the end of
the control period are those on ideal switches. What counter steps round, it corrects as a current regulator does, once
a sample shows it and the answer acts. What remains is the drive's own. Where the modulator omits pulses, there is no
ideal: each answer to an omitted pulse decides whether the next one is omitted.
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
CORRECTED: Final = 0.2
"""Share of an error of the currents that is corrected in a control period (1).

It is the bandwidth over the sampling rate of a current regulator that stays stable with a delay of 1.5 periods. One
that corrects all of it at once has less ripple, but only on a machine that it knows exactly.
"""
SPARE: Final = 0.02
"""Length of the shortest pulse of ideal modulation beyond what the modulator gives, over the time between updates: that
much regulators vary their pulses (1)."""
LEAD: Final = 24
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


@inlined
def _has_short_pulse(ratios: NDArray[np.float64], shortest: float) -> bool:
    """Return True if one of the duty ratios, shape (3,), has a pulse or a gap below a length (1) that is not 0."""
    for leg in range(3):
        pulse = min(ratios[leg], 1.0 - ratios[leg])
        if 0.0 < pulse < shortest:
            return True
    return False


@unallocating
def _follow_ideal(
    drive: PmAcDrive,
    phases: PmAcPhases,
    steady: _Steady,
    shortest: float,
    ignored: int,
    currents: NDArray[np.float64],
    workspace: _Workspace,
) -> float:
    """Return the peak-to-peak torque on ideal switches (N m).

    - `phases`: state before the first control period; replaced by the state after the last.
    - `shortest`: length over the time between updates, below which no pulse or gap may be (1).
    - `ignored`: number of control periods at the start that are not evaluated.
    - `currents`, shape (n, 2): receives the d-axis and q-axis currents at the end of each control period (A).
    - Result: infinite if a pulse or gap is shorter, or if the plant's advance fails.
    """
    least = inf
    most = -inf
    for k in range(currents.shape[0]):
        along, across = _voltage_in(steady, k)
        rail = clamped_rail(steady.kind, along, across, 1.0 if steady.turning >= 0.0 else -1.0)
        write_ratios(workspace.ratios, along, across, steady.link, rail)
        if _has_short_pulse(workspace.ratios, shortest):
            return inf
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
    left = 1.0 - CORRECTED
    for k in range(first, currents.shape[0]):
        direct = currents[k, 0] + left * (predicted.rotor_currents[0] - currents[k - 1, 0])
        quadrature = currents[k, 1] + left * (predicted.rotor_currents[1] - currents[k - 1, 1])
        if _choose_ratios(exact, predicted, steady, k, direct, quadrature, workspace) != COMPLETED:
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


def _shortest(drive: PmAcDrive, period: float) -> float:
    """Return the shortest pulse of ideal modulation in a control period (s), over the time between updates (1)."""
    modulator = drive.modulator
    if modulator.minimum_pulse <= 0.0:
        return 0.0
    # What compensates dead time takes as much from a pulse at most.
    kept = modulator.minimum_pulse + modulator.dead_time
    return float(kept * modulator.control_every / period + SPARE)


def has_ideal_switches(drive: PmAcDrive) -> bool:
    """Return True if nothing of the bridge and its modulator has to be compensated."""
    modulator = drive.modulator
    return not any((modulator.counter_levels, modulator.dead_time, drive.switch_drop, drive.diode_drop))


def spread_samples(speed: float, part: float, watched: int) -> tuple[float, int]:
    """Return a speed next to a given one, and control periods whose samples lie all over a part of a cycle.

    Where a current passes zero between two samples decides what dead time leaves of it. If a part of a cycle has whole
    control periods, that is the same in each part, and by chance more or less than elsewhere.

    - `speed`: speed of the shaft (rad/s).
    - `part`: what the shaft turns until the torque repeats itself, over the control period (rad/s).
    - `watched`: number of control periods to evaluate, about (1).
    """
    fewest = max(round(watched * abs(speed) / part), FEWEST_PARTS)
    if fewest * part > LONGEST_SPREAD * abs(speed):
        return speed, watched
    # The nearest speed, which takes nearly the same voltage. One of these numbers of parts is prime, or a power of 2,
    # and next to any number of periods is one that has no factor in common with it.
    ways = [
        (abs(parts * part / periods - abs(speed)), parts, periods)
        for parts in range(fewest, fewest + fewest // 4 + 1)
        for nearest in [round(parts * part / abs(speed))]
        for periods in (nearest - 1, nearest, nearest + 1)
        if gcd(periods, parts) == 1
    ]
    _, parts, periods = min(ways)
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

    The controller knows the drive and its currents exactly: it compensates dead time and forward drops. What the
    counter rounds, it sees in the next sample, and corrects by `CORRECTED` of it in each control period.

    - `speed`: constant speed of the shaft (rad/s).
    - `link`: voltage of the dc link (V).
    - `currents`: mean d-axis and q-axis currents (A).
    - `ignored`: number of control periods at the start that are not evaluated, in which the currents settle.
    - `watched`: number of evaluated control periods after them.
    - `period`: control period (s).
    - `kind`: kind of modulation, as in `modulation_kind`.
    - Result: maximum minus minimum torque at any instant (N m); infinite where the voltage takes pulses that are nearly
      too short for the modulator, and if the plant's advance fails.
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
    swing = float(
        _follow_ideal(ideal, phases, steady, _shortest(drive, period), int(ignored), ends, workspace)
    )
    if has_ideal_switches(drive) or swing == inf:
        return swing
    exact = drive._replace(modulator=modulator._replace(dead_time=drive.modulator.dead_time))
    return float(
        _follow_compensated(
            drive, exact, make_phases(follows_torque=True), steady, int(ignored), ends, workspace
        )
    )
