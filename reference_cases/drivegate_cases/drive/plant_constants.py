"""From a drive's document to the constants of its plant."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from drivegate_models.machine.emf import sine_corners, table_corners, trapezoid_corners

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from drivegate_cases.drive.inverter import Inverter
    from drivegate_cases.drive.machine import Machine
    from drivegate_cases.drive.scales import Scales
    from drivegate_models.steady.plant import AnyDrive


def plant_constants(
    kind: str, machine: Machine, inverter: Inverter, current_limit_a: float, scales: Scales
) -> AnyDrive:
    """Return the constants of a plant in SI units that differs from its drive by `scales`.

    They are of the type of the drive's kind, by which compiled functions find the plant.
    """
    angles, values = _emf_corners(machine)
    return _MAKE[kind](
        inverter,
        phases=machine.phases,
        pole_pairs=machine.pole_pairs,
        resistance=machine.resistance_ohm * scales.resistance,
        inductance=machine.inductance_h * scales.inductance,
        emf_constant=machine.emf_constant_v_s_per_rad * scales.emf_constant,
        emf_angles=angles,
        emf_values=values,
        half_supply_voltage=inverter.supply_voltage_v,
        hysteresis_band=inverter.hysteresis_band_a,
        window=math.radians(inverter.window_deg),
        current_limit=current_limit_a,
        core_loss_conductance=machine.core_loss_conductance_s,
        inertia=machine.inertia_kg_m2 * scales.inertia,
        friction=machine.friction_n_m + scales.friction_added_n_m,
        viscous_friction=machine.viscous_friction_n_m_s_per_rad,
        switch_drop=inverter.switch_drop_v,
        diode_drop=inverter.diode_drop_v,
        turn_on_energy=inverter.turn_on_energy_j,
        turn_off_energy=inverter.turn_off_energy_j,
    )


def _emf_corners(machine: Machine) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if machine.emf_shape == "table":
        angles = [math.radians(angle) for angle, _ in machine.emf_table]
        return table_corners(angles, [value for _, value in machine.emf_table])
    if machine.emf_shape == "sine":
        return sine_corners()
    assert machine.emf_flat_deg is not None, "a trapezoid without its flat width is refused on entry"
    return trapezoid_corners(math.radians(machine.emf_flat_deg))


def _half_bridge(_inverter: Inverter, **constants: Any) -> AnyDrive:
    from drivegate_models.half_bridge.plant.drive import make_drive

    return make_drive(**constants)


def _star(inverter: Inverter, **constants: Any) -> AnyDrive:
    from drivegate_models.star.plant.drive import REGULATIONS, make_star_drive

    return make_star_drive(regulation=REGULATIONS[inverter.regulation or "every-half"], **constants)


_MAKE: Final[Mapping[str, Callable[..., AnyDrive]]] = {"half-bridge": _half_bridge, "star": _star}
