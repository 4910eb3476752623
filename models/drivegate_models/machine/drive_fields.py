"""The fields that the constants of every drive with a back-EMF shape have."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate_models.machine.emf import full_cycle


def drive_fields(
    *,
    phases: int,
    pole_pairs: int,
    emf_angles: NDArray[np.float64],
    emf_values: NDArray[np.float64],
    **constants: float,
) -> dict[str, Any]:
    """Return the fields of a drive's constants, in SI units.

    `phases`, `pole_pairs`: number of phases and of pole pairs. `emf_angles`, `emf_values`, shape (k,): corners of the
    positive half cycle of the back-EMF shape (rad, 1); see `drivegate_models.machine.emf`. `constants`: the other
    fields, in their units; missing ones have their defaults. Result: with the shape's corners over the whole cycle.
    """
    angles, values = full_cycle(emf_angles, emf_values)
    # Each kernel is compiled for one type of drive; an int instead of a float would compile it a second time.
    return {
        "phases": int(phases),
        "pole_pairs": int(pole_pairs),
        "emf_angles": angles,
        "emf_values": values,
        "emf_slopes": np.diff(values) / np.diff(angles),
        **{name: float(constant) for name, constant in constants.items()},
    }
