"""Checks of the input power: the plant's own law, and a candidate's estimate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Moment, at_most
from drivegate.contracts.current.checks.shown import around
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.run import plant_sensors
from drivegate_models.machine import ledger
from drivegate_models.machine.shaft_ledger import shaft_error

TOLERANCE = 1e-9
"""Greatest relative difference of powers that counts as equal (1)."""


def _relative(error: float) -> str:
    return f"{error:.1e} relative" if error > 0.0 else "exact"


def exchanged_power(record: CurrentRecord) -> Margin:
    """Judge the plant's power balance (paper, "Optimal Efficiency Control").

    In every control period the energy exchanged with the half-sources, V_half(j) |i_j| summed over the
    phases, less twice what flows back, is what the windings take: copper, shaft, devices, and storage. On the
    shaft, the machine's work is that of load and friction and the change of kinetic energy.
    """
    circuit, shaft = record.run.observed.exchange_error, shaft_error(record.run.shaft)
    exchanged = float(record.run.totals[ledger.EXCHANGED])
    returned = float(record.run.totals[ledger.RETURNED])
    share = 2.0 * returned / exchanged if exchanged > 0.0 else 0.0
    on_shaft = f", on the shaft {_relative(shaft)}" if shaft > 0.0 else ""
    measured = f"{_relative(circuit)}{on_shaft}; net power {100.0 * share:.3g} % below the exchanged one"
    return Margin("PWR-1", at_most(max(circuit, shaft), TOLERANCE), measured)


def estimated_power(record: CurrentRecord) -> Margin | None:
    if record.run.observed.power_estimates == 0.0:
        if record.declaration.estimates_power:
            return Margin("PWR-2", -1.0, "declared, but every estimate is NaN")
        return None
    error = record.run.observed.power_error_relative
    margin = Margin("PWR-2", at_most(error, TOLERANCE), _relative(error))
    step = plant_sensors(record.scenario).converters.current_step
    if step == 0.0:
        return margin
    lowest = min(voltage for _, voltage in record.scenario.supply_profile)
    deviation = record.run.observed.power_error
    by_step = Margin("PWR-2", at_most(deviation, step * lowest), f"{deviation:.3g} W at most")
    return max(margin, by_step, key=lambda judged: judged.value)


def estimate_moment(record: CurrentRecord) -> Moment | None:
    """Show the estimate and the product that it should be, around their greatest difference."""
    if record.steps is None or record.run.observed.power_estimates == 0.0:
        return None
    sense, period = record.steps["sense"], record.scenario.control_period_s
    estimates, products = record.steps["command"]["input_power"], _products(record)
    errors = np.nan_to_num(np.abs(estimates - products) / np.maximum(products, 1.0))
    place = int(np.argmax(errors))
    times = np.arange(len(sense)) * (record.scenario.duration_s / len(sense) if len(sense) else period)
    known = np.flatnonzero(np.isfinite(estimates))
    if not known.size:
        return None
    courses = [("estimate", estimates[known]), ("V Σ|i|", products[known])]
    words = f"{estimates[place]:.4g} W of {products[place]:.4g} W"
    at = int(np.searchsorted(known, place))
    return around(times[known], at, courses, "input power (W)", (), words)


def _products(record: CurrentRecord) -> NDArray[np.float64]:
    """Return what an estimate should be at each step that was kept, shape (n,) (W)."""
    assert record.steps is not None, "the steps were kept"
    sense = record.steps["sense"]
    products: NDArray[np.float64] = sense["half_supply_voltage"] * sense["current_magnitude_sum"]
    count = max(round(record.declaration.power_window_s / record.scenario.control_period_s), 1)
    sums = np.concatenate([np.zeros(1), np.cumsum(products)])
    begins = np.maximum(np.arange(len(products)) + 1 - count, 0)
    ends = np.arange(len(products)) + 1
    return (sums[ends] - sums[begins]) / (ends - begins) if count > 1 else products


PWR_1 = Check(
    id="PWR-1",
    every_run=True,
    requirement=(
        "The power exchanged with the half-sources equals their voltage times the magnitudes of the phase currents, "
        "and the net input power is that less twice what flows back. On the shaft the machine's work equals that of "
        "load and friction and the change of kinetic energy, nothing that opposes the rotation drives it, and a "
        "weight takes m g h."
    ),
    source="P4",
    subject="plant",
    limit="1e-9 relative in every control period",
    scenarios="every run",
    formula=(
        "1 - greatest |exchanged - 2 returned - spent| / throughput / 1e-9; likewise 1 - greatest |machine - load - "
        "friction - lifted - kinetic| / throughput / 1e-9"
    ),
    why="Every comparison of currents and powers rests on it. It is drivegate's own obligation, not the candidate's.",
    evaluate=exchanged_power,
)
PWR_2 = Check(
    id="PWR-2",
    every_run=True,
    requirement=(
        "An estimate of the input power equals half supply voltage times current magnitude sum of the Sense given, "
        "of that step alone or their mean over the time that the candidate declares."
    ),
    source="P4",
    limit="1e-9 relative, or one step of the converter",
    scenarios="every run of a candidate that estimates its input power",
    formula=(
        "1 - greatest |estimate - V Σ|i|| / (V Σ|i|) / 1e-9; through a converter also 1 - greatest difference / "
        "(supply voltage × step of current)"
    ),
    why="The search of the paper takes this product for the input power; a wrong one leads it to a wrong angle.",
    evaluate=estimated_power,
    moment=estimate_moment,
)
