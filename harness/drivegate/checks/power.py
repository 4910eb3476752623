"""Checks of the input power: the plant's own law, and a candidate's estimate."""

from __future__ import annotations

from drivegate.check import Check
from drivegate.margin import Margin
from drivegate.run_record import RunRecord
from drivegate_models import observation

TOLERANCE = 1e-9
"""Greatest relative difference of powers that counts as equal (1)."""


def _relative(error: float) -> str:
    return f"{error:.1e} relative" if error > 0.0 else "exact"


def exchanged_power(record: RunRecord) -> Margin:
    """Judge the plant's power balance (paper, "Optimal Efficiency Control").

    In every control period the energy exchanged with the half-sources, V_half(j) |i_j| summed over the
    phases, less twice what flows back, is what the windings take: copper, shaft, devices, and storage.

    Parameters
    ----------
    record : RunRecord
        The run.

    Returns
    -------
    Margin
        Of the worst control period.
    """
    error = float(record.run.run[observation.RUN_EXCHANGE_ERROR])
    return Margin("PWR-1", 1.0 - error / TOLERANCE, _relative(error))


def estimated_power(record: RunRecord) -> Margin | None:
    """Judge a candidate's estimate of its input power.

    Parameters
    ----------
    record : RunRecord
        The run.

    Returns
    -------
    Margin or None
        Of the worst step; None for a candidate that makes no estimate.
    """
    if record.run.run[observation.RUN_POWER_ESTIMATES] == 0.0:
        if record.declaration.estimates_power:
            return Margin("PWR-2", -1.0, "declared, but every estimate is NaN")
        return None
    error = float(record.run.run[observation.RUN_POWER_ERROR_RELATIVE])
    return Margin("PWR-2", 1.0 - error / TOLERANCE, _relative(error))


PWR_1 = Check(
    "PWR-1",
    "The power exchanged with the half-sources equals their voltage times the magnitudes of the phase currents, "
    "and the net input power is that less twice what flows back.",
    "P4",
    "plant",
    "required",
    "1e-9 relative in every control period",
    "every run",
    exchanged_power,
)
PWR_2 = Check(
    "PWR-2",
    "An estimate of the input power equals half supply voltage times current magnitude sum of the Sense given.",
    "P4",
    "candidate",
    "required",
    "1e-9 relative",
    "every run of a candidate that estimates its input power",
    estimated_power,
)
