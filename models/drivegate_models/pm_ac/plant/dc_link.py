"""Capacitor, source and brake chopper of a dc link that is not ideal: constants, state and ledger (SI units)."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined

RECTIFIER: Final = 0
"""The source takes no current back."""
BATTERY: Final = 1
"""The source takes current back."""


class DcLink(NamedTuple):
    """Constants of a dc link; without a capacitance it is ideal, and its voltage is that of the source."""

    capacitance: float = 0.0
    """Capacitance (F); 0 for an ideal link."""
    source_resistance: float = 0.0
    """Resistance between source and capacitor (ohm)."""
    source: int = RECTIFIER
    """`RECTIFIER` or `BATTERY`."""
    limit: float = 0.0
    """Greatest permitted voltage (V); above it the overvoltage comparator trips."""
    charge_limit: float = 0.0
    """Greatest mean current that the source takes back (A); the plant does not enforce it."""
    discharge_limit: float = 0.0
    """Greatest mean current of the source (A); the plant does not enforce it."""
    chopper_on: float = 0.0
    """Voltage at which the brake chopper turns on by itself (V)."""
    chopper_off: float = 0.0
    """Voltage at which it turns off by itself (V)."""
    chopper_conductance: float = 0.0
    """Conductance of the chopper while it is on (S); 0 without a chopper."""
    source_inductance: float = 0.0
    """Inductance between source and capacitor (H)."""


VOLTAGE: Final = 0
"""Voltage of the capacitor (V)."""
CHOPPER: Final = 1
"""1 while the chopper is on."""
SOURCE: Final = 2
"""1 while the source is connected and its diodes conduct, 0 otherwise."""
CLAMPED: Final = 3
"""1 while the bridge's diodes keep an empty capacitor at 0 V."""
PENDING: Final = 4
"""Core and switching loss of the preceding control period, which the link supplies in this one (W)."""
CURRENT: Final = 5
"""Current of a source with an inductance (A); 0 for one without, whose current follows from the voltage."""
STATES: Final = 6

DRAWN: Final = 0
"""Energy from the source's voltage (J)."""
RESISTED: Final = 1
"""Loss in the source's resistance (J)."""
BURNT: Final = 2
"""Loss in the chopper (J)."""
SUPPLIED: Final = 3
"""Core and switching loss that the link has supplied (J)."""
BRIDGE: Final = 4
"""Energy into the bridge (J)."""
SOURCE_CHARGE: Final = 5
"""Charge from the source (A s)."""
BRIDGE_CHARGE: Final = 6
"""Charge into the bridge, with that for core and switching losses (A s)."""
FLUX: Final = 7
"""Integral of the voltage (V s)."""
THROUGHPUT: Final = 8
"""Sum of the magnitudes of all these energies in each segment (J)."""
HIGHEST: Final = 9
"""Maximum of the voltage (V)."""
LOWEST: Final = 10
"""Minimum of the voltage (V)."""
ENTRIES: Final = 11


class LinkState(NamedTuple):
    """State of a link and its ledger over the last control period; the arrays are updated in place."""

    state: NDArray[np.float64]
    """State, shape (STATES,)."""
    totals: NDArray[np.float64]
    """Exact integrals over the last control period, shape (ENTRIES,)."""
    voltage: NDArray[np.float64]
    """Work space: series of the voltage (V)."""
    bridge: NDArray[np.float64]
    """Work space: series of the current into the bridge (A)."""
    source: NDArray[np.float64]
    """Work space: series of the current of a source with an inductance (A)."""
    product: NDArray[np.float64]
    """Work space: series in which an event is searched."""


def make_link_state(terms: int) -> LinkState:
    """Return the state of an empty link; `terms` is the maximum number of coefficients of a series."""
    series = (np.zeros(terms), np.zeros(terms), np.zeros(terms), np.zeros(terms))
    return LinkState(np.zeros(STATES), np.zeros(ENTRIES), *series)


@inlined
def is_ideal(link: DcLink) -> bool:
    """Return True if the link's voltage is that of the source."""
    return link.capacitance == 0.0


@inlined
def charge_link(link: LinkState, voltage: float) -> None:
    """Set the link to a voltage (V) with the chopper off."""
    for entry in range(STATES):
        link.state[entry] = 0.0
    link.state[VOLTAGE] = voltage


@inlined
def link_energy(constants: DcLink, link: LinkState) -> float:
    """Return the energy of the capacitor and of the source's inductance (J)."""
    voltage, current = link.state[VOLTAGE], link.state[CURRENT]
    charged = 0.5 * constants.capacitance * voltage * voltage
    return float(charged + 0.5 * constants.source_inductance * current * current)
