"""The table of angles that the correct designs have of their drive."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Final

import numpy as np

from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_lab.candidates.angle_table import AngleTable, angle_table
from drivegate_lab.kernels.designs.state import TABLE_ROWS
from drivegate_lab.kernels.designs.table_values import (
    ANGLES_DEG,
    CURRENT_SUMS,
    DRIVE,
    FIRST_SPEED_RPM,
    SPEED_STEP_RPM,
)
from drivegate_models.units import RADIANS_PER_RPM

_KEPT: Final = 20
# A supply that is low by a tenth, at the greatest speed but for a little, counts as a speed so far beyond.
_BEYOND_OVERSPEED: Final = 1.05


@lru_cache(maxsize=_KEPT)
def table_of(drive: DriveDocument) -> AngleTable:
    """Return the table of a drive: the one that is included, or one that is computed, in a second or two."""
    packaged = load_drive(DRIVE)
    if _per_unit(drive) == _per_unit(packaged):
        return _in_units(drive, packaged)
    rating = drive.rating
    base = rating.base_speed_rpm * RADIANS_PER_RPM
    last = _BEYOND_OVERSPEED * rating.overspeed_rpm * RADIANS_PER_RPM
    return angle_table(drive.plant(), base, last, TABLE_ROWS, rating.rated_power_w)


def _per_unit(drive: DriveDocument) -> tuple[Any, ...]:
    """Return what the table of a drive follows from, in shares of its base values."""
    machine, inverter, rating = drive.machine, drive.inverter, drive.rating
    volts, amperes = inverter.supply_voltage_v, rating.current_limit_a
    speed = rating.base_speed_rpm
    ohms, torque, joules = volts / amperes, volts * amperes / speed, volts * amperes / speed
    return (
        *(machine.phases, machine.emf_shape, machine.emf_flat_deg, machine.emf_table, inverter.window_deg),
        machine.resistance_ohm / ohms,
        machine.inductance_h * machine.pole_pairs * speed / ohms,
        machine.emf_constant_v_s_per_rad * speed / volts,
        machine.core_loss_conductance_s * ohms,
        machine.friction_n_m / torque,
        machine.viscous_friction_n_m_s_per_rad * speed / torque,
        inverter.hysteresis_band_a / amperes,
        *(inverter.switch_drop_v / volts, inverter.diode_drop_v / volts),
        *(inverter.turn_on_energy_j / joules, inverter.turn_off_energy_j / joules),
        rating.rated_power_w / (volts * amperes),
    )


def _in_units(drive: DriveDocument, packaged: DriveDocument) -> AngleTable:
    """Return the table that is included, in the units of a drive with the same shares."""
    faster = drive.rating.base_speed_rpm / packaged.rating.base_speed_rpm
    larger = drive.rating.current_limit_a / packaged.rating.current_limit_a
    return AngleTable(
        FIRST_SPEED_RPM * RADIANS_PER_RPM * faster,
        SPEED_STEP_RPM * RADIANS_PER_RPM * faster,
        larger * np.array(CURRENT_SUMS),
        np.radians(np.array(ANGLES_DEG)),
    )
