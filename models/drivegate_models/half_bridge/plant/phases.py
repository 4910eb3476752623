"""Advance of all phases of the drive at constant speed, supply and command."""

from __future__ import annotations

from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.half_bridge.plant.phase import advance_phase
from drivegate_models.machine import ledger, segments
from drivegate_models.machine.advance_status import COMPLETED


class Phases(NamedTuple):
    """State of the m phases and space for the segments of one advance; the arrays are updated in place."""

    currents: NDArray[np.float64]
    """Phase currents, shape (m,) (A)."""
    sectors: NDArray[np.int64]
    """Window of each phase, shape (m,): 1, 0 or -1."""
    latches: NDArray[np.int64]
    """Comparator of each phase, shape (m,): 1 on, 0 off."""
    magnitudes: NDArray[np.float64]
    """Integral of each phase's current magnitude over the last advance, shape (m,) (A s)."""
    rows: NDArray[np.float64]
    """Segments of the last advance, shape (m, n, segments.FIELDS); with n = 0 none are stored."""
    row_counts: NDArray[np.int64]
    """Number of segments of each phase, shape (m,)."""


def make_phases(drive: Drive, longest_advance: float = 0.0) -> Phases:
    """Return phases at rest: no current, latches on.

    `longest_advance`: maximum length of an advance whose segments are stored (s), with space for every segment that the
    drive can produce in that time; 0 to store none.
    """
    count = drive.phases
    capacity = 0
    if longest_advance > 0.0:
        # A segment without space is dropped. The capacity covers the steepest current that supply and back-EMF can
        # drive together, plus corners and window edges.
        band = drive.hysteresis_band
        swing = 2.5 * drive.half_supply_voltage / drive.inductance
        chops = longest_advance * swing / band if band > 0.0 else 0.0
        capacity = 64 + 4 * drive.emf_slopes.size + int(2.0 * chops)
    return Phases(
        currents=np.zeros(count),
        sectors=np.zeros(count, np.int64),
        latches=np.ones(count, np.int64),
        magnitudes=np.zeros(count),
        rows=np.zeros((count, capacity, segments.FIELDS)),
        row_counts=np.zeros(count, np.int64),
    )


@inlined
def advance_phases(
    drive: Drive,
    phases: Phases,
    angle: float,
    speed: float,
    upper: float,
    lower: float,
    reference: float,
    advance: float,
    duration: float,
    totals: NDArray[np.float64],
) -> int:
    """Advance every phase exactly, by `drivegate_models.half_bridge.plant.phase.advance_phase`.

    - `phases`: state before the advance; replaced by the state after it, with the segments.
    - `angle`: electrical angle of the first phase at the start (rad).
    - `speed`: constant shaft speed (rad/s).
    - `upper`, `lower`: voltages of the half-sources (V).
    - `reference`: current reference i* (A).
    - `advance`: advance angle (rad electrical).
    - `duration`: length of the advance (s).
    - `totals`, shape (ledger.ENTRIES,): the exact integrals of the advance are added to it.
    - Result: a status of `drivegate_models.machine.advance_status`.
    """
    status = COMPLETED
    # Read the arrays once for all phases: every access to an array in a tuple counts a reference.
    corners = drive.emf_angles
    corner_values = drive.emf_values
    corner_slopes = drive.emf_slopes
    currents = phases.currents
    sectors = phases.sectors
    latches = phases.latches
    rows = phases.rows
    row_counts = phases.row_counts
    magnitudes = phases.magnitudes
    for phase in range(drive.phases):
        before = totals[ledger.MAGNITUDE]
        outcome = advance_phase(
            drive,
            corners,
            corner_values,
            corner_slopes,
            phase,
            currents,
            sectors,
            latches,
            angle - phase * pi / drive.phases,
            speed,
            upper,
            lower,
            reference,
            advance,
            duration,
            totals,
            rows,
            row_counts,
        )
        # The ledger sums over all phases, but each phase has its own current sensor.
        magnitudes[phase] = totals[ledger.MAGNITUDE] - before
        if outcome != COMPLETED:
            status = outcome
    return status
