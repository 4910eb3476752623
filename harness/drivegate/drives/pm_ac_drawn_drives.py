"""PM AC drives drawn at random within stated bounds, only such whose rating can be met."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from random import Random
from types import MappingProxyType
from typing import Final

from drivegate.drives.drawn_bounds import rounded
from drivegate.drives.drawn_drives import MOST_DRAWS, DrawnDrive, none_is_met, told_bounds
from drivegate.drives.pm_ac_drawn_bounds import DOUBLE, FEWEST_PERIODS, PM_AC_BOUNDS
from drivegate.drives.pm_ac_reach import unreachable_duty
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.inverter import UPDATES
from drivegate_cases.drive.provenance import Provenance
from drivegate_models.units import RADIANS_PER_RPM

_PHASE: Final = sqrt(3.0)
_APPARENT: Final = 1.5


def drawn_pm_ac_drive(seed: int, number: int) -> DrawnDrive:
    """Draw a drive whose rating can be met.

    Parameters
    ----------
    seed : int
        Seed of all drives.
    number : int
        Number of the drive; it follows from seed and number alone.

    Returns
    -------
    DrawnDrive
        The drive, and how many were drawn before it whose rating no controller can meet.
    """
    for rejected, document in zip(range(MOST_DRAWS), pm_ac_draws(seed, number), strict=False):
        if unreachable_duty(document) is None:
            return DrawnDrive(document, rejected)
    raise none_is_met(seed, number)


def pm_ac_draws(seed: int, number: int) -> Iterator[PmAcDocument]:
    """Draw drives without end, whether or not their rating can be met."""
    source = Random(f"pm-ac/{seed}/{number}")
    while True:
        yield _document(f"drawn-pm-ac-{seed}-{number:03d}", source)


def pm_ac_per_unit_values(drive: DriveDocument) -> dict[str, float]:
    """Give a drive's values without its size.

    Parameters
    ----------
    drive : DriveDocument
        A drive of the kind.

    Returns
    -------
    dict
        By quantity, as `drivegate.drives.pm_ac_drawn_bounds.PM_AC_BOUNDS` has it under the same name: voltages over
        what the link gives a phase without distortion, impedances over the quotient of that and the current limit.
    """
    assert isinstance(drive, PmAcDocument), "the values are those of a machine in the rotor's frame"
    machine, inverter, rating = drive.machine, drive.inverter, drive.rating
    voltage, limit = inverter.link_voltage_v / _PHASE, rating.current_limit_a
    speed = rating.base_speed_rpm * RADIANS_PER_RPM
    torque, electrical = rating.rated_power_w / speed, machine.pole_pairs * speed
    impedance, apparent = voltage / limit, _APPARENT * voltage * limit
    return {
        "apparent_power": apparent,
        "current": limit,
        "base_frequency": machine.pole_pairs * rating.base_speed_rpm / 60.0,
        "speed_range": rating.highest_speed_rpm / rating.base_speed_rpm,
        "overspeed": rating.overspeed_rpm / rating.highest_speed_rpm,
        "emf": machine.magnet_flux_v_s * electrical / voltage,
        "reactance": machine.direct_inductance_h * electrical / impedance,
        "saliency": machine.quadrature_inductance_h / machine.direct_inductance_h,
        "resistance": machine.resistance_ohm / impedance,
        "power": rating.rated_power_w / apparent,
        "control_frequency": 1.0 / drive.control_period_s,
        "dead_time": inverter.dead_time_s / drive.control_period_s,
        "mechanical_time": machine.inertia_kg_m2 * speed / torque,
        "core_loss": machine.core_loss_conductance_s * impedance,
        "friction": machine.friction_n_m / torque,
        "viscous_friction": machine.viscous_friction_n_m_s_per_rad * speed / torque,
    }


def _document(name: str, source: Random) -> PmAcDocument:
    """Draw all values in a fixed order, so that a seed means the same drive for ever."""
    draw = {key: bound.drawn for key, bound in PM_AC_BOUNDS.items()}
    pole_pairs = PM_AC_BOUNDS["pole_pairs"].drawn_whole(source)
    apparent = draw["apparent_power"](source)
    link = _link(source, apparent)
    voltage = link / _PHASE
    limit = rounded(apparent / (_APPARENT * voltage))
    base_speed = rounded(60.0 * draw["base_frequency"](source) / pole_pairs)
    highest_speed = rounded(base_speed * draw["speed_range"](source))
    overspeed = rounded(highest_speed * draw["overspeed"](source))
    speed, impedance = base_speed * RADIANS_PER_RPM, voltage / limit
    electrical = pole_pairs * speed
    direct = rounded(impedance * draw["reactance"](source) / electrical)
    saliency = draw["saliency"](source)
    power = rounded(_APPARENT * voltage * limit * draw["power"](source))
    torque = power / speed
    frequency = _control_frequency(source, pole_pairs * highest_speed / 60.0)
    carrier = "double" if source.random() < DOUBLE else "single"
    drawn = PmAcDocument.model_validate(
        {
            "schema": 1,
            "name": name,
            "kind": "pm-ac",
            "machine": {
                "pole_pairs": pole_pairs,
                "resistance_ohm": rounded(impedance * draw["resistance"](source)),
                "direct_inductance_h": direct,
                "quadrature_inductance_h": rounded(direct * saliency),
                "magnet_flux_v_s": rounded(voltage * draw["emf"](source) / electrical),
                "core_loss_conductance_s": rounded(draw["core_loss"](source) / impedance),
                "inertia_kg_m2": rounded(draw["mechanical_time"](source) * torque / speed),
                "friction_n_m": rounded(draw["friction"](source) * torque),
                "viscous_friction_n_m_s_per_rad": rounded(draw["viscous_friction"](source) * torque / speed),
            },
            "inverter": {
                "link_voltage_v": link,
                "carrier_frequency_hz": rounded(frequency / UPDATES[carrier]),
                "carrier": carrier,
                "dead_time_s": rounded(draw["dead_time"](source) / frequency),
            },
            "rating": {
                "base_speed_rpm": base_speed,
                "highest_speed_rpm": highest_speed,
                "overspeed_rpm": overspeed,
                "rated_power_w": power,
                "current_limit_a": limit,
            },
        }
    )
    return drawn.replaced(provenance=_provenance(drawn))


def _link(source: Random, apparent: float) -> float:
    """Draw the link's voltage, from what makes the current neither tiny nor huge."""
    volts, current = PM_AC_BOUNDS["link"], PM_AC_BOUNDS["current"]
    product = apparent * _PHASE / _APPARENT
    lowest = max(volts.lowest, product / current.highest)
    highest = min(volts.highest, product / current.lowest)
    return volts.between(source, lowest, highest)


def _control_frequency(source: Random, highest: float) -> float:
    """Draw how often the controller steps, often enough in an electrical period of the highest speed."""
    bound = PM_AC_BOUNDS["control_frequency"]
    return bound.between(source, max(bound.lowest, FEWEST_PERIODS * highest), bound.highest)


_DRAWN_AS: Final = MappingProxyType(
    {
        "machine": {
            "pole_pairs": "pole_pairs",
            "resistance_ohm": "resistance",
            "direct_inductance_h": "reactance",
            "quadrature_inductance_h": "saliency",
            "magnet_flux_v_s": "emf",
            "core_loss_conductance_s": "core_loss",
            "inertia_kg_m2": "mechanical_time",
            "friction_n_m": "friction",
            "viscous_friction_n_m_s_per_rad": "viscous_friction",
        },
        "inverter": {
            "link_voltage_v": "link",
            "carrier_frequency_hz": "control_frequency",
            "dead_time_s": "dead_time",
        },
        "rating": {
            "base_speed_rpm": "base_frequency",
            "highest_speed_rpm": "speed_range",
            "overspeed_rpm": "overspeed",
            "rated_power_w": "power",
            "current_limit_a": "apparent_power",
        },
    }
)
"""The bound that the values of each key follow from."""


def _provenance(drive: PmAcDocument) -> Provenance:
    """Tell of each value what was drawn, and within which bounds."""
    told = told_bounds(_DRAWN_AS, PM_AC_BOUNDS, pm_ac_per_unit_values(drive))
    told["inverter"]["carrier"] = f"drawn: double in {DOUBLE:.0%} of the drives, single in the others"
    return told
