"""Drives of the half-bridge kind drawn at random within stated bounds, only such whose rating can be met."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, floor
from random import Random
from types import MappingProxyType
from typing import Any, Final

from drivegate.drives.drawn_bounds import BOUNDS, DIGITS, SINES, Bound, rounded
from drivegate.drives.rating import rated_drive
from drivegate.drives.reach import rating_is_met
from drivegate.drives.required_ripple import UnreachableRipple, unreachable_ripple
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.provenance import Provenance
from drivegate_models.errors import HarnessFault
from drivegate_models.units import RADIANS_PER_RPM

MOST_DRAWS: Final = 1000
"""Draws after which the bounds, not chance, must be what is wrong."""


@dataclass(frozen=True)
class DrawnDrive:
    """A drive that was drawn."""

    document: DriveDocument
    """The drive."""
    rejected: int
    """Number of drives that were drawn before it and have a rating that no controller can meet."""


def drawn_drive(seed: int, number: int) -> DrawnDrive:
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
        The drive, and how many were drawn before it that no controller could be judged on.
    """
    for rejected, document in zip(range(MOST_DRAWS), draws(seed, number), strict=False):
        drive = rated_drive(document)
        if not rating_is_met(drive):
            continue
        missed = unreachable_ripple(drive)
        if all(point.nearest_percent for point in missed):
            return DrawnDrive(_with_ripple(document, missed), rejected)
    raise none_is_met(seed, number)


def none_is_met(seed: int, number: int) -> HarnessFault:
    """Tell that the bounds leave no drive whose rating can be met."""
    return HarnessFault(
        f"none of {MOST_DRAWS} drives drawn with seed {seed} for number {number} meets its rating"
    )


def _with_ripple(document: DriveDocument, missed: Sequence[UnreachableRipple]) -> DriveDocument:
    """Require the ripple that the drive can have, where it cannot have the paper's."""
    if not missed:
        return document
    allowed = float(max(point.nearest_percent for point in missed))
    told = {"ripple_percent": "computed: the least in whole percent that can be met at the least current sum"}
    return document.replaced(ripple_percent=allowed, provenance={**document.provenance, "requirements": told})


def draws(seed: int, number: int) -> Iterator[DriveDocument]:
    """Draw drives without end, whether or not their rating can be met."""
    source = Random(f"{seed}/{number}")
    while True:
        yield _document(f"drawn-{seed}-{number:03d}", source)


def per_unit_values(drive: DriveDocument) -> dict[str, float]:
    """Give a drive's values without its size: what controllers of drives of any size have in common.

    Parameters
    ----------
    drive : DriveDocument
        The drive.

    Returns
    -------
    dict
        By quantity: voltages over half the supply, currents over their limit, impedances over the quotient of both,
        at base speed, and the rest as `drivegate.drives.drawn_bounds.BOUNDS` has it under the same name.
    """
    machine, inverter, rating = drive.machine, drive.inverter, drive.rating
    speed = rating.base_speed_rpm * RADIANS_PER_RPM
    torque = rating.rated_power_w / speed
    impedance = inverter.supply_voltage_v / rating.current_limit_a
    emf = machine.emf_constant_v_s_per_rad * speed
    rated_current = rating.rated_power_w / (machine.phases * inverter.window_deg / 180.0 * emf)
    shape = {} if machine.emf_flat_deg is None else {"flat": machine.emf_flat_deg / inverter.window_deg}
    return {
        "phase_current": rating.rated_power_w / (inverter.supply_voltage_v * machine.phases),
        "base_frequency": machine.pole_pairs * rating.base_speed_rpm / 60.0,
        "speed_range": rating.highest_speed_rpm / rating.base_speed_rpm,
        "overspeed": rating.overspeed_rpm / rating.highest_speed_rpm,
        "idle": 1.0 - inverter.window_deg / 180.0,
        **shape,
        "emf": emf / inverter.supply_voltage_v,
        "reactance": machine.inductance_h * machine.pole_pairs * speed / impedance,
        "resistance": machine.resistance_ohm / impedance,
        "current_limit": rating.current_limit_a / rated_current,
        "band": inverter.hysteresis_band_a / rating.current_limit_a,
        "mechanical_time": machine.inertia_kg_m2 * speed / torque,
        "core_loss": machine.core_loss_conductance_s * impedance,
        "friction": machine.friction_n_m / torque,
        "viscous_friction": machine.viscous_friction_n_m_s_per_rad * speed / torque,
    }


def _document(name: str, source: Random) -> DriveDocument:
    """Draw all values in a fixed order, so that a seed means the same drive for ever."""
    draw = {key: bound.drawn for key, bound in BOUNDS.items()}
    phases = BOUNDS["phases"].drawn_whole(source)
    pole_pairs = BOUNDS["pole_pairs"].drawn_whole(source)
    power = draw["rated_power"](source)
    supply = _supply(source, power, phases)
    base_speed = rounded(60.0 * draw["base_frequency"](source) / pole_pairs)
    highest_speed = rounded(base_speed * draw["speed_range"](source))
    overspeed = rounded(highest_speed * draw["overspeed"](source))
    conducting = _conducting(source, phases)
    window = rounded(180.0 * conducting / phases)
    shape = _shape(source, window)

    speed = base_speed * RADIANS_PER_RPM
    torque = power / speed
    emf = draw["emf"](source)
    rated_current = power / (conducting * emf * supply)
    limit = rounded(rated_current * draw["current_limit"](source))
    impedance = supply / limit
    drawn = DriveDocument.model_validate(
        {
            "schema": 1,
            "name": name,
            "kind": "half-bridge",
            "machine": {
                "phases": phases,
                "pole_pairs": pole_pairs,
                "resistance_ohm": rounded(impedance * draw["resistance"](source)),
                "inductance_h": rounded(impedance * draw["reactance"](source) / (pole_pairs * speed)),
                "emf_constant_v_s_per_rad": rounded(emf * supply / speed),
                **shape,
                "core_loss_conductance_s": rounded(draw["core_loss"](source) / impedance),
                "inertia_kg_m2": rounded(draw["mechanical_time"](source) * torque / speed),
                "friction_n_m": rounded(draw["friction"](source) * torque),
                "viscous_friction_n_m_s_per_rad": rounded(draw["viscous_friction"](source) * torque / speed),
            },
            "inverter": {
                "supply_voltage_v": supply,
                "hysteresis_band_a": rounded(limit * draw["band"](source)),
                "window_deg": window,
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


def _conducting(source: Random, phases: int) -> int:
    """Draw how many phases conduct at a time."""
    idle = BOUNDS["idle"]
    return source.randint(ceil(phases * (1.0 - idle.highest)), floor(phases * (1.0 - idle.lowest)))


def _supply(source: Random, power: float, phases: int) -> float:
    """Draw half the supply, from what makes the current of a leg neither tiny nor huge."""
    volts, current = BOUNDS["supply"], BOUNDS["phase_current"]
    lowest = max(volts.lowest, power / (phases * current.highest))
    highest = min(volts.highest, power / (phases * current.lowest))
    return volts.between(source, lowest, highest)


def _shape(source: Random, window: float) -> dict[str, Any]:
    is_sine = source.random() < SINES
    flat = rounded(window * BOUNDS["flat"].drawn(source))
    return {"emf_shape": "sine"} if is_sine else {"emf_shape": "trapezoid", "emf_flat_deg": flat}


_DRAWN_AS: Final = MappingProxyType(
    {
        "machine": {
            "phases": "phases",
            "pole_pairs": "pole_pairs",
            "resistance_ohm": "resistance",
            "inductance_h": "reactance",
            "emf_constant_v_s_per_rad": "emf",
            "emf_flat_deg": "flat",
            "core_loss_conductance_s": "core_loss",
            "inertia_kg_m2": "mechanical_time",
            "friction_n_m": "friction",
            "viscous_friction_n_m_s_per_rad": "viscous_friction",
        },
        "inverter": {"supply_voltage_v": "supply", "hysteresis_band_a": "band", "window_deg": "idle"},
        "rating": {
            "base_speed_rpm": "base_frequency",
            "highest_speed_rpm": "speed_range",
            "overspeed_rpm": "overspeed",
            "rated_power_w": "rated_power",
            "current_limit_a": "current_limit",
        },
    }
)
"""The bound that the values of each key follow from."""


def _provenance(drive: DriveDocument) -> Provenance:
    """Tell of each value what was drawn, and within which bounds."""
    told = told_bounds(_DRAWN_AS, BOUNDS, per_unit_values(drive))
    told["machine"]["emf_shape"] = f"drawn: a sine in {SINES:.0%} of the drives, a trapezoid in the others"
    if drive.machine.emf_flat_deg is None:
        del told["machine"]["emf_flat_deg"]
    return told


def told_bounds(
    drawn_as: Mapping[str, Mapping[str, str]], bounds: Mapping[str, Bound], values: Mapping[str, float]
) -> Provenance:
    """Tell of each key of each table what was drawn, by the name of the bound that its value follows from."""
    return {
        table: {key: _told_bound(bounds[name], values.get(name)) for key, name in keys.items()}
        for table, keys in drawn_as.items()
    }


def _told_bound(bound: Bound, value: float | None) -> str:
    """Tell what was drawn; what stands in the document itself is not told again."""
    unit = f" {bound.unit}" if bound.unit else ""
    within = f"from {bound.lowest:g} to {bound.highest:g}{unit}"
    if value is None:
        return f"drawn: {within}"
    return f"drawn: {bound.quantity} {value:.{DIGITS}g}, {within}"
