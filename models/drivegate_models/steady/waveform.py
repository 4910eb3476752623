"""Currents, voltages and torque over one electrical cycle, evaluated exactly from the plant's segments."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import kernel
from drivegate_models.machine import ledger, segments
from drivegate_models.machine.period import APERIODIC
from drivegate_models.machine.winding_current import current_after
from drivegate_models.steady.plant import (
    AnyDrive,
    advance_phases,
    make_phases,
    periodic_start,
    torque_period,
)
from drivegate_models.steady.steady_state import KEPT_TIME

# Number of equal steps of a cycle.
_SAMPLES = 720


@dataclass(frozen=True)
class Waveforms:
    """One electrical cycle of the steady state, beginning with the first phase's positive window."""

    times: NDArray[np.float64]
    """Sampling times, never decreasing, shape (n,) (s). They include every event of every phase; some occur twice."""
    currents: NDArray[np.float64]
    """Phase currents, shape (m, n) (A)."""
    shapes: NDArray[np.float64]
    """Shape of each phase's back-EMF, shape (m, n) (1)."""
    voltages: NDArray[np.float64]
    """Terminal voltages, shape (m, n) (V); at a step, the value before it."""
    torque: NDArray[np.float64]
    """Electromagnetic torque, shape (n,) (N m)."""
    cycle: float
    """Length of the electrical cycle (s)."""
    certified: bool
    """True if the state repeats after this one cycle; otherwise it is one of many different settled cycles."""

    @property
    def angles(self) -> NDArray[np.float64]:
        """Electrical angle turned since the window opened, shape (n,) (rad)."""
        return self.times * (2.0 * pi / self.cycle)


@kernel
def sample_rows(
    rows: NDArray[np.float64],
    row_counts: NDArray[np.int64],
    times: NDArray[np.float64],
    currents: NDArray[np.float64],
    shapes: NDArray[np.float64],
    voltages: NDArray[np.float64],
) -> None:
    """Evaluate the segments of one advance; a time between two segments belongs to the earlier one.

    `rows`, shape (m, k, segments.FIELDS): segments of each phase, without gaps. `row_counts`, shape (m,): number of
    segments of each phase. `times`, shape (n,): increasing, from the start of the advance (s). `currents`, `shapes`,
    `voltages`, shape (m, n): receive current (A), back-EMF shape (1) and terminal voltage (V).
    """
    for phase in range(rows.shape[0]):
        position = 0
        for k in range(times.size):
            # Compare with the next start, not with this segment's end: the two differ by rounding.
            while position < row_counts[phase] - 1 and rows[phase, position + 1, segments.START] < times[k]:
                position += 1
            row = rows[phase, position]
            # By rounding, another phase's event may be after this segment's end.
            offset = min(max(times[k] - row[segments.START], 0.0), row[segments.LENGTH])
            current, _ = current_after(
                row[segments.CURRENT],
                row[segments.SLOPE],
                row[segments.CURVATURE],
                row[segments.RATE],
                offset,
            )
            currents[phase, k] = current
            shapes[phase, k] = row[segments.SHAPE] + row[segments.SHAPE_RATE] * offset
            voltages[phase, k] = row[segments.VOLTAGE] + row[segments.VOLTAGE_RATE] * offset


def periodic_waveforms(drive: AnyDrive, speed: float, reference: float, advance: float) -> Waveforms:
    """Return one electrical cycle of the steady state at one operating point.

    `speed`: shaft speed (rad/s), above 0. `reference`: current reference i* (A). `advance`: advance angle (rad
    electrical). Result: exact values at equal steps and at every event, as in the paper's Figs. 6, 9 and 10.
    """
    supply = drive.half_supply_voltage
    phases = make_phases(drive, KEPT_TIME)
    periods = periodic_start(drive, phases, make_phases(drive), speed, supply, reference, advance)
    electrical = drive.pole_pairs * speed
    cycle = 2.0 * pi / electrical
    grid = np.linspace(0.0, cycle, _SAMPLES + 1)
    pieces = int(cycle / KEPT_TIME) + 1
    length = cycle / pieces
    angle = 0.5 * (pi - drive.window) - advance
    unused = np.zeros(ledger.ENTRIES)
    parts = []
    for piece in range(pieces):
        start = piece * length
        advance_phases(
            drive,
            phases,
            angle + electrical * start,
            speed,
            supply,
            supply,
            reference,
            advance,
            length,
            unused,
        )
        inside = np.append(grid[(grid >= start) & (grid < start + length)] - start, length)
        counts = enumerate(phases.row_counts.tolist())
        events = [phases.rows[phase, :count, segments.START] for phase, count in counts]
        times = np.unique(np.clip(np.concatenate([inside, *events]), 0.0, length))
        values = np.zeros((3, drive.phases, times.size))
        sample_rows(phases.rows, phases.row_counts, times, values[0], values[1], values[2])
        # The next piece must not begin before this one ends, by rounding.
        parts.append((np.minimum(times + start, (piece + 1) * length), values))
    currents, shapes, voltages = np.concatenate([values for _, values in parts], axis=2)
    return Waveforms(
        times=np.concatenate([times for times, _ in parts]),
        currents=currents,
        shapes=shapes,
        voltages=voltages,
        torque=drive.emf_constant * np.sum(shapes * currents, axis=0),
        cycle=cycle,
        certified=periods != APERIODIC and round(cycle / torque_period(drive, electrical)) % periods == 0,
    )
