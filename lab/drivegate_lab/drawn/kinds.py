"""The kinds of drives that can be drawn at random: what their tables cannot say."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from math import ceil, floor, isnan, sqrt
from random import Random
from types import MappingProxyType
from typing import Final

from drivegate.drives.abilities import ability_of, refusals
from drivegate.drives.angle_ability import rating_is_met
from drivegate.drives.rating import rated_drive
from drivegate.drives.required_ripple import ripple_percent_of_all
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.inverter import UPDATES
from drivegate_lab.drawn.drawing import Bound, DrawnKind, Values, bounds_of, rounded
from drivegate_models.units import RADIANS_PER_RPM

SINES: Final = 0.25
"""Share of the half-bridge and star drives that have a sine EMF instead of a trapezoid."""
FEWEST_PERIODS: Final = 20.0
"""Control periods of a PM AC drive in an electrical period at the highest speed, at least (1)."""
DOUBLE: Final = 0.5
"""Share of the PM AC drives whose duty ratios are updated twice in a period of the carrier."""
IDEAL: Final = 0.25
"""Share of the PM AC drives whose switches and diodes have no drops."""
IGBT_LINK_V: Final = 200.0
"""Least voltage of a link with IGBTs (V); below, the switches are MOSFETs."""
IGBT_LOWEST_V: Final = 1.0
"""Least drop of an IGBT or of the diode next to it (V)."""
MOSFET_V: Final = (0.02, 0.2)
"""Least and greatest drop of a MOSFET (V)."""
EXACT: Final = 0.5
"""Share of the PM AC drives without a shortest pulse, and of those without a counter."""
FEWEST_COUNTS: Final = 250
"""Least steps of a counter."""
_PHASE: Final = sqrt(3.0)
_APPARENT: Final = 1.5
_OF_LEGS: Final = bounds_of("half-bridge")
_OF_STAR: Final = bounds_of("star")
_OF_PM_AC: Final = bounds_of("pm-ac")


def _draw_supply(current: Bound, bound: Bound, source: Random, values: Values) -> None:
    """Draw half the supply, from what makes the current of a leg neither tiny nor huge."""
    power = values["rated_power_w"]
    lowest = max(bound.lowest, power / (values["phases"] * current.highest))
    highest = min(bound.highest, power / (values["phases"] * current.lowest))
    values[bound.key] = values["voltage"] = bound.between(source, lowest, highest)


def _draw_window(bound: Bound, source: Random, values: Values) -> None:
    """Draw how many phases conduct at a time."""
    phases = values["phases"]
    conducting = source.randint(ceil(phases * (1.0 - bound.highest)), floor(phases * (1.0 - bound.lowest)))
    values |= {"conducting": conducting, bound.key: rounded(180.0 * conducting / phases)}


def _draw_shape(bound: Bound, source: Random, values: Values) -> None:
    values["emf_shape"] = "sine" if source.random() < SINES else "trapezoid"
    flat = bound.value(bound.drawn(source), values)
    if values["emf_shape"] == "trapezoid":
        values[bound.key] = flat


def _draw_emf(bound: Bound, source: Random, values: Values) -> None:
    drawn = bound.drawn(source)
    values[bound.key] = bound.value(drawn, values)
    values["rated_current"] = values["rated_power_w"] / (values["conducting"] * drawn * values["voltage"])


def _measured_by(drive: DriveDocument) -> dict[str, float]:
    machine, inverter, rating = drive.machine, drive.inverter, drive.rating
    emf = machine.emf_constant_v_s_per_rad * (rating.base_speed_rpm * RADIANS_PER_RPM)
    return {
        "voltage": inverter.supply_voltage_v,
        "idle": 1.0 - inverter.window_deg / 180.0,
        "rated_current": rating.rated_power_w / (machine.phases * inverter.window_deg / 180.0 * emf),
    }


def _accepted(document: DriveDocument) -> DriveDocument | None:
    """Require the ripple that the drive can have, where it cannot have the paper's."""
    drive = rated_drive(document)
    if not rating_is_met(drive):
        return None
    percent = ripple_percent_of_all(drive)
    if isnan(percent):
        return None
    if percent <= 100.0 * drive.limits.ripple:
        return document
    source = {
        "ripple_percent": "computed: the least in whole percent that every angle with an allowed current sum meets"
    }
    return document.replaced(
        ripple_percent=percent, provenance={**document.provenance, "requirements": source}
    )


def _draw_apparent_power(bound: Bound, source: Random, values: Values) -> None:
    values["apparent_power"] = bound.drawn(source)


def _draw_link(bound: Bound, source: Random, values: Values) -> None:
    """Draw the link's voltage, from what makes the current neither tiny nor huge."""
    current, product = _OF_PM_AC["current"], values["apparent_power"] * _PHASE / _APPARENT
    lowest, highest = (
        max(bound.lowest, product / current.highest),
        min(bound.highest, product / current.lowest),
    )
    values[bound.key] = bound.between(source, lowest, highest)
    voltage = values["voltage"] = values[bound.key] / _PHASE
    limit = values["current_limit_a"] = rounded(values["apparent_power"] / (_APPARENT * voltage))
    values["apparent_power"] = _APPARENT * voltage * limit


def _draw_control_frequency(bound: Bound, source: Random, values: Values) -> None:
    """Draw how often the controller steps, often enough in an electrical period of the highest speed."""
    highest = values["pole_pairs"] * values["highest_speed_rpm"] / 60.0
    frequency = bound.between(source, max(bound.lowest, FEWEST_PERIODS * highest), bound.highest)
    values["carrier"] = "double" if source.random() < DOUBLE else "single"
    values[bound.key] = rounded(frequency / UPDATES[values["carrier"]])
    values["control_frequency"] = frequency


def _draw_dead_time(bound: Bound, source: Random, values: Values) -> None:
    values[bound.key] = rounded(bound.drawn(source) / values["control_frequency"])


def _draw_switch_drop(bound: Bound, source: Random, values: Values) -> None:
    """Draw what the bridge is made of, and the drop of its switches: none, that of an IGBT or that of a MOSFET."""
    has_drops, is_igbt = source.random() >= IDEAL, values["link_voltage_v"] >= IGBT_LINK_V
    lowest, highest = (IGBT_LOWEST_V, bound.highest) if is_igbt else MOSFET_V
    drop = bound.between(source, lowest, highest)
    values[bound.key] = drop if has_drops else 0.0


def _draw_diode_drop(bound: Bound, source: Random, values: Values) -> None:
    """Draw the drop of the diodes; the channel of a MOSFET conducts both ways, so that it has one drop."""
    drop, switch = bound.between(source, IGBT_LOWEST_V, bound.highest), values["switch_drop_v"]
    values[bound.key] = drop if switch >= IGBT_LOWEST_V else switch


def _draw_minimum_pulse(bound: Bound, source: Random, values: Values) -> None:
    has_one, drawn = source.random() >= EXACT, bound.drawn(source)
    values[bound.key] = rounded(drawn / values["control_frequency"]) if has_one else 0.0


def _draw_counter(bound: Bound, source: Random, values: Values) -> None:
    has_one, drawn = source.random() >= EXACT, bound.between(source, FEWEST_COUNTS, bound.highest)
    values[bound.key] = round(drawn) if has_one else 0


def _pm_ac_measured_by(drive: DriveDocument) -> dict[str, float]:
    period, voltage = drive.control_period_s or 0.0, drive.value("link_voltage_v") / _PHASE
    return {
        "voltage": voltage,
        "apparent_power": _APPARENT * voltage * drive.rating.current_limit_a,
        "control_period": period,
        "control_frequency": 1.0 / period,
    }


def _pm_ac_accepted(document: DriveDocument) -> DriveDocument | None:
    # A check also refuses a rotor so heavy that runs would take minutes.
    return document if ability_of(document).accepts(document) and not refusals(document) else None


def _of_legs(kind: str, bounds: Mapping[str, Bound], *, seed: str, names: str) -> DrawnKind:
    """Return how drives are drawn whose phases are on half-bridge legs."""
    return DrawnKind(
        kind=kind,
        document=DriveDocument,
        seed=seed,
        names=names,
        bounds=bounds,
        draws_of={
            "supply": partial(_draw_supply, bounds["phase_current"]),
            "idle": _draw_window,
            "flat": _draw_shape,
            "emf": _draw_emf,
        },
        measured_by=_measured_by,
        remarks={"emf_shape": f"drawn: a sine in {SINES:.0%} of the drives, a trapezoid in the others"},
        accepted=_accepted,
    )


HALF_BRIDGE: Final = _of_legs("half-bridge", _OF_LEGS, seed="", names="drawn-")
"""Drives of the paper's kind."""
STAR: Final = _of_legs("star", _OF_STAR, seed="star/", names="drawn-star-")
"""Drives of three phases in a star, as conventional brushless DC drives are."""
PM_AC: Final = DrawnKind(
    kind="pm-ac",
    document=PmAcDocument,
    seed="pm-ac/",
    names="drawn-pm-ac-",
    bounds=_OF_PM_AC,
    draws_of={
        "apparent_power": _draw_apparent_power,
        "link": _draw_link,
        "control_frequency": _draw_control_frequency,
        "dead_time": _draw_dead_time,
        "switch_drop": _draw_switch_drop,
        "diode_drop": _draw_diode_drop,
        "minimum_pulse": _draw_minimum_pulse,
        "counter": _draw_counter,
    },
    measured_by=_pm_ac_measured_by,
    remarks={"carrier": f"drawn: double in {DOUBLE:.0%} of the drives, single in the others"},
    accepted=_pm_ac_accepted,
)
"""Drives of three sinusoidal phases on a two-level bridge."""
DRAWN_KINDS: Final[Mapping[str, DrawnKind]] = MappingProxyType(
    {kind.kind: kind for kind in (HALF_BRIDGE, STAR, PM_AC)}
)
"""How drives are drawn, by the names of their kinds."""
