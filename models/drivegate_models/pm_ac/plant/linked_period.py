"""A control period of a link with a capacitor, as far as nothing changes but by the gates: many segments at once.

The power series of currents and voltage are computed one segment after the other, each from the end of the one before.
The integrals over all segments are then the same arithmetic, which is vectorized. A segment in which a current or the
voltage may come near an event is left to the general advance.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import unallocating
from drivegate_models.machine import ledger
from drivegate_models.machine.rotor_frame import RotorFrame
from drivegate_models.pm_ac.plant.advance import PmAcPhases
from drivegate_models.pm_ac.plant.circuit import Circuit
from drivegate_models.pm_ac.plant.dc_link import CLAMPED, VOLTAGE
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.linked_propagation import band_of, propagate_linked
from drivegate_models.pm_ac.plant.linked_series import Feed
from drivegate_models.pm_ac.plant.linked_sums import (
    FEW_ORDERS,
    add_link,
    add_machine,
    integrate_linked,
    peak_of_series,
)
from drivegate_models.pm_ac.plant.pattern import lay_out
from drivegate_models.pm_ac.plant.rows import TIME

LONGEST_PERIOD: Final = 0.75
"""Maximum period times the rotor's electrical speed (1): it turns by less than an eighth of a turn in it."""


@unallocating
def pass_linked_segments(
    drive: PmAcDrive,
    circuit: Circuit,
    feed: Feed,
    phases: PmAcPhases,
    frame: RotorFrame,
    begin: float,
    duration: float,
    follows_thresholds: bool,
    totals: NDArray[np.float64],
) -> tuple[int, float, RotorFrame]:
    """Pass the segments before the next one with a possible event, and add them to both ledgers.

    `feed`: what acts on the capacitor until the end of the period; its source has no inductance. `begin`: time in the
    period, at which no leg is held (s). `duration`: length of the period (s). Returns the number of segments, and time
    (s) and currents after the last of them.
    """
    legs, link, series, rows = phases.legs, phases.dc_link, phases.series, phases.rows
    if link.state[CLAMPED] != 0.0 or abs(circuit.electrical) * duration > LONGEST_PERIOD:
        return 0, begin, frame
    band = band_of(drive, link, feed.source, follows_thresholds)
    if not band.lowest < link.state[VOLTAGE] < band.highest:
        return 0, begin, frame
    pattern = lay_out(circuit, legs, phases.gates, phases.upcoming, begin, duration, rows)
    if pattern.segments == 0:
        return 0, begin, frame
    count, after, voltage, orders = propagate_linked(
        circuit, feed, legs, link, series, frame, band, pattern.segments, rows
    )
    if count == 0:
        return 0, begin, frame
    # Two calls, so that each is compiled without the coefficients that only the other needs.
    if orders <= FEW_ORDERS:
        integrate_linked(circuit, feed.source, count, True, rows)
    else:
        integrate_linked(circuit, feed.source, count, False, rows)
    totals[ledger.PEAK] = max(totals[ledger.PEAK], peak_of_series(series, rows, count))
    add_machine(drive, circuit, rows, count, phases.magnitudes, totals)
    end = rows[TIME + count]
    add_link(drive, feed, link, end - begin, count, rows)
    link.state[VOLTAGE] = voltage
    return count, end, after
