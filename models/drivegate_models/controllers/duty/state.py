"""State of the field-oriented controllers, one record in the buffer that the caller provides."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.duty.records import DUTY_SENSE

LEAST_CURRENT: Final = 0
"""Least current that gives the torque, weakened as far as the voltage asks for."""
UNWEAKENED: Final = 1
"""Least current, whatever the voltage."""
MODELLED_LOSS: Final = 2
"""Least loss of a model of copper and core."""
SEARCHED_LOSS: Final = 3
"""Least power from the link, found by trying."""

AIMS: Final = {
    "foc": LEAST_CURRENT,
    "foc-mtpa": UNWEAKENED,
    "foc-loss-model": MODELLED_LOSS,
    "foc-loss-search": SEARCHED_LOSS,
    "predictive-flux": LEAST_CURRENT,
    "direct-torque": LEAST_CURRENT,
}
"""The controllers, and what each chooses its currents for."""

OF_CURRENTS: Final = 0
"""PI regulators of the currents."""
BY_PREDICTION: Final = 1
"""The stator flux is led by prediction."""
OF_TORQUE: Final = 2
"""PI regulators of the torque and of the stator flux's magnitude."""

REGULATIONS: Final = {"predictive-flux": BY_PREDICTION, "direct-torque": OF_TORQUE}
"""What leads to these currents where it is not their own regulators."""

FOC_STATE: Final = np.dtype(
    [
        # Which currents are chosen, and what leads to them; set before reset, which leaves both.
        ("aim", np.int64),
        ("regulation", np.int64),
        # Constants, set by reset.
        ("regulates_speed", np.int64),
        ("control_period", np.float64),
        ("pole_pairs", np.float64),
        ("resistance", np.float64),
        ("direct_inductance", np.float64),
        ("quadrature_inductance", np.float64),
        ("magnet_flux", np.float64),
        ("core_loss_conductance", np.float64),
        ("current_limit", np.float64),
        # At the current limit, where the voltage is free.
        ("greatest_torque", np.float64),
        # Current along the magnet's axis beyond which there is no weakening.
        ("deepest", np.float64),
        # Time from sampling to the middle of the period in which the answer acts.
        ("lead", np.float64),
        ("speed_gain", np.float64),
        ("speed_integral_step", np.float64),
        ("torque_step", np.float64),
        # What dead time takes from the duty ratio of a phase that carries a current, and the current from which on it
        # takes all of that.
        ("dead_ratio", np.float64),
        ("dead_current", np.float64),
        ("direct_gain", np.float64),
        ("quadrature_gain", np.float64),
        ("direct_integral_step", np.float64),
        ("quadrature_integral_step", np.float64),
        ("weakening_step", np.float64),
        # Regulators.
        ("speed_integral", np.float64),
        # Torque that is gone for.
        ("torque", np.float64),
        # Flux y of the last current along the magnet's axis that gave a torque with least current.
        ("added_flux", np.float64),
        ("direct_integral", np.float64),
        ("quadrature_integral", np.float64),
        # Share of the undistorted voltage that references are made for.
        ("voltage_share", np.float64),
        # Prediction of the flux: whether an answer acts a period later, the voltage given, what predictions have missed
        # (V), and what is foreseen of the flux for the next step.
        ("delay", np.int64),
        ("direct_given", np.float64),
        ("quadrature_given", np.float64),
        ("direct_missed", np.float64),
        ("quadrature_missed", np.float64),
        ("direct_foreseen", np.float64),
        ("quadrature_foreseen", np.float64),
        # Regulation of torque and flux: currents on the way to their reference, now and in the last two periods.
        ("direct_way", np.float64, (3,)),
        ("quadrature_way", np.float64, (3,)),
        # Search for the least power: control periods in which a current settles and is looked at, at least, at most and
        # now; speed at which a period is a sixth of the field's turn, and the inertia over a period.
        ("search_settling", np.int64),
        ("search_shortest", np.float64),
        ("search_longest", np.float64),
        ("search_sixth", np.float64),
        ("search_looking", np.int64),
        ("search_inertia", np.float64),
        # What it adds to the current along the magnet's axis, by how much that changes, and how often that was right.
        ("search_offset", np.float64),
        ("search_step", np.float64),
        ("search_gains", np.int64),
        # How far it is in one place, sums of the power and of the first and second half of the speed there, both in
        # the place before, and where it began.
        ("search_count", np.int64),
        ("search_sum", np.float64),
        ("search_early", np.float64),
        ("search_late", np.float64),
        ("search_power", np.float64),
        ("search_pace", np.float64),
        ("search_torque", np.float64),
        ("search_speed", np.float64),
        # What it goes by, with the shaft led on past a Hall edge that is overdue: by how much at most, from which speed
        # on, by how much now, and the state, angle and speed that the switches gave before.
        ("seen", DUTY_SENSE),
        ("led_on_longest", np.float64),
        ("led_on_from", np.float64),
        ("led_on", np.float64),
        ("hall_before", np.int64),
        ("hall_angle", np.float64),
        ("hall_speed", np.float64),
        # Plausibility: its constants, the code of the first fault, whether a step has been seen, what was seen in it,
        # and for how long, or by how much of the field's turning, each thing has been implausible.
        ("base_speed", np.float64),
        ("slowing_step", np.float64),
        ("stall_periods", np.int64),
        ("fault", np.int64),
        ("is_watching", np.int64),
        ("angle_before", np.float64),
        ("angle_drift", np.float64),
        ("speed_seen", np.float64),
        ("sum_count", np.int64),
        ("speed_count", np.int64),
        ("stall_count", np.int64),
        ("passed", np.float64, (3,)),
    ],
    align=True,
)
"""In SI units; speeds are electrical, but for the speed regulator's gains, which make torque of the shaft's."""


def foc_state(name: str) -> NDArray[Any]:
    """Make the state of a controller, for reset to fill in.

    Parameters
    ----------
    name : str
        One of `AIMS`.

    Returns
    -------
    array of FOC_STATE, shape (1,)
        Nothing is set but its aim and its regulation.
    """
    state = np.zeros(1, FOC_STATE)
    state["aim"] = AIMS[name]
    state["regulation"] = REGULATIONS.get(name, OF_CURRENTS)
    return state
