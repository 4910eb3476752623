"""Derive the motor of `paper-5-phase` from what the paper publishes, and compare it with the stored drive.

    python docs/paper_calibration.py            # exit code 1 if the stored drive differs by more than rounding
    python docs/paper_calibration.py --json     # also the sensitivities

Three published facts fix three unknowns: back-EMF constant, inductance and width of the back-EMF's flat top.
The paper's angles are read as the smallest ones at which the published torque can still be produced at the
current limit ("necessary", Fig. 6). An angle jumps or vanishes as the constants vary, while the torque at the
current limit is smooth in them; so the fit compares torques, and the facts are then checked as published.
Regulator ideal, core loss nil, resistance assumed.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from math import degrees, radians
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_models.errors import HarnessFault
from drivegate_models.half_bridge.plant.drive import Drive, make_drive
from drivegate_models.machine.constants_fit import ConstantsFit, fit_constants
from drivegate_models.machine.emf import trapezoid_corners
from drivegate_models.steady.angle_search import torque_at_limit, torque_demand
from drivegate_models.steady.oracle import feasible_edge, greatest_torque_at_limit
from drivegate_models.steady.plant import AnyDrive
from drivegate_models.units import RADIANS_PER_RPM

ASSUMED_RESISTANCE: float = 0.08
"""Winding resistance, which the paper neglects (ohm)."""
ASSUMED_FLUX_DENSITY: float = 0.8
"""Flux density in the gap from which the fit starts (T)."""

# Table 1 of the paper, which the fit takes as given.
_LIMIT = 26.0
_BASE_SPEED = 500.0


@dataclass(frozen=True)
class PublishedFigures:
    """The published figures that the fit uses, each to the digits the paper gives."""

    worst_ripple_angle: float = 52.0
    """Necessary advance angle at 1500 rpm, Fig. 6 (deg)."""
    worst_ripple_torque: float = 9.8
    """Torque at 1500 rpm, Fig. 10 (N m)."""
    middle_angle: float = 40.0
    """Advance angle at 1200 rpm, Fig. 9 (deg)."""
    middle_torque: float = 11.88
    """Torque at 1200 rpm, Fig. 9 (N m)."""
    rated_power: float = 1500.0
    """Rated power at 500 rpm and 26 A, Table 1 (W)."""


ROUNDING: Mapping[str, float] = {
    "worst_ripple_angle": 0.5,
    "worst_ripple_torque": 0.05,
    "middle_angle": 0.5,
    "middle_torque": 0.005,
    "rated_power": 50.0,
}
"""Half of the last published digit of each figure, in the figure's unit."""


@dataclass(frozen=True)
class MotorConstants:
    """The constants of the motor that the paper leaves open."""

    emf_constant: float
    """Peak back-EMF of a phase a shaft speed (V s/rad)."""
    inductance: float
    """Inductance of a phase (H)."""
    emf_flat: float
    """Width of the back-EMF's flat top (rad electrical)."""
    resistance: float = ASSUMED_RESISTANCE
    """Resistance of a phase (ohm)."""


@dataclass(frozen=True)
class ComparedFigure:
    """One published figure beside the same figure of a motor."""

    name: str
    """What it is, and where it is published."""
    published: float
    """As the paper has it, in `unit`."""
    ours: float
    """As the motor has it, in `unit`."""
    residual: float
    """Ours less the published one, in `unit`."""
    unit: str
    """Unit."""


@dataclass(frozen=True)
class Sensitivity:
    """How far the fitted constants move when one input of the fit does."""

    cause: str
    """The input."""
    change: float
    """Its change, in its own unit."""
    emf_constant: float
    """Change of the back-EMF constant (V s/rad)."""
    inductance: float
    """Change of the inductance (H)."""
    emf_flat: float
    """Change of the flat top's width (rad electrical)."""


@dataclass(frozen=True)
class GeometryCheck:
    """The back-EMF constant against Table 1: ``k_e = 2 N B l r``."""

    series_turns: int
    """Turns in series a phase: 10 coils of 26 turns over 5 phases."""
    core_length: float
    """Core length (m)."""
    radius: float
    """Inner radius of the stator (m)."""
    flux_density: float
    """Flux density in the gap that the fitted constant requires (T)."""


@dataclass(frozen=True)
class Calibration:
    """Fitted constants, and how well and how firmly they follow from the published facts."""

    constants: MotorConstants
    """The fitted constants."""
    facts: tuple[ComparedFigure, ...]
    """The published facts beside the fitted motor's."""
    torque_residuals: tuple[float, float, float]
    """What the fit leaves of its three torques (N m)."""
    condition: float
    """Condition number of the torques' derivatives by the logarithms of the constants."""
    sensitivities: tuple[Sensitivity, ...]
    """Shift of the constants with half a last digit of each published figure, and with the resistance."""
    spread: MotorConstants
    """Half-width of each constant's range, all published roundings taken at their worst together."""
    geometry: GeometryCheck
    """Cross-check with Table 1, which the fit does not use."""


def geometry_check(emf_constant: float) -> GeometryCheck:
    """Return the gap flux density that a back-EMF constant requires with the paper's geometry.

    Parameters
    ----------
    emf_constant : float
        Peak back-EMF a shaft speed (V s/rad).

    Returns
    -------
    GeometryCheck
        With the turns, length and radius of Table 1. The coils span 198 electrical degrees, which costs a
        flat top of the gap's field 18 degrees of width and nothing of its height.
    """
    turns, length, radius = 52, 0.100, 0.043
    return GeometryCheck(turns, length, radius, emf_constant / (2.0 * turns * length * radius))


def calibration_drive(constants: MotorConstants) -> Drive:
    """Return the paper's drive with given constants, an ideal regulator and no core loss.

    Parameters
    ----------
    constants : MotorConstants
        What the paper leaves open.

    Returns
    -------
    Drive
        With phases, poles, supply, windows and current limit as published.
    """
    angles, values = trapezoid_corners(constants.emf_flat)
    return make_drive(
        phases=5,
        pole_pairs=11,
        resistance=constants.resistance,
        inductance=constants.inductance,
        emf_constant=constants.emf_constant,
        emf_angles=angles,
        emf_values=values,
        half_supply_voltage=48.0,
        hysteresis_band=0.0,
        window=radians(144.0),
        current_limit=_LIMIT,
    )


def _torque_at_limit(drive: AnyDrive, speed_rpm: float, advance: float) -> float:
    return torque_at_limit(torque_demand(drive, speed_rpm * RADIANS_PER_RPM), advance)


def published_facts(drive: AnyDrive, figures: PublishedFigures | None = None) -> tuple[ComparedFigure, ...]:
    """Return the facts that the fit uses beside those of a drive, in the paper's own terms.

    Parameters
    ----------
    drive : AnyDrive
        Any drive.
    figures : PublishedFigures, optional
        The published figures.

    Returns
    -------
    tuple of ComparedFigure
        Two necessary angles (deg) and the rated power (W).
    """
    chosen = figures or PublishedFigures()
    edges = [
        (
            "necessary angle at 1500 rpm (Fig. 6)",
            1500.0,
            chosen.worst_ripple_torque,
            chosen.worst_ripple_angle,
        ),
        ("angle at 1200 rpm (Fig. 9)", 1200.0, chosen.middle_torque, chosen.middle_angle),
    ]
    facts = []
    for name, speed_rpm, torque, angle in edges:
        ours = degrees(feasible_edge(drive, speed_rpm * RADIANS_PER_RPM, torque))
        facts.append(ComparedFigure(name, angle, ours, ours - angle, "deg"))
    base_speed = _BASE_SPEED * RADIANS_PER_RPM
    power = greatest_torque_at_limit(drive, base_speed).torque * base_speed
    excess = power - chosen.rated_power
    facts.append(
        ComparedFigure("power at 500 rpm and 26 A (Table 1)", chosen.rated_power, power, excess, "W")
    )
    return tuple(facts)


def _guess() -> MotorConstants:
    """Return where the fit starts: Table 1 with a usual flux density, and round values beside it."""
    unit = geometry_check(1.0).flux_density
    return MotorConstants(ASSUMED_FLUX_DENSITY / unit, 2.5e-3, radians(120.0))


def _residuals(
    constants: NDArray[np.float64], resistance: float, figures: PublishedFigures
) -> NDArray[np.float64]:
    """Return the torques at the current limit less the published ones (N m), shape (3,)."""
    emf_constant, inductance, flat = (float(value) for value in constants)
    drive = calibration_drive(MotorConstants(emf_constant, inductance, flat, resistance))
    # Torques at published angles, not angles at published torques: an angle can jump or vanish.
    worst = _torque_at_limit(drive, 1500.0, radians(figures.worst_ripple_angle))
    middle = _torque_at_limit(drive, 1200.0, radians(figures.middle_angle))
    rated = greatest_torque_at_limit(drive, _BASE_SPEED * RADIANS_PER_RPM).torque
    required = figures.rated_power / (_BASE_SPEED * RADIANS_PER_RPM)
    return np.array([worst - figures.worst_ripple_torque, middle - figures.middle_torque, rated - required])


def _fitted(
    figures: PublishedFigures, resistance: float, start: MotorConstants
) -> tuple[MotorConstants, ConstantsFit]:
    """Return the constants, and the fit with residuals and derivatives in newton metres."""
    found = fit_constants(
        lambda constants: _residuals(constants, resistance, figures),
        [start.emf_constant, start.inductance, start.emf_flat],
        [0.1, 1e-4, radians(10.0)],
        [1.0, 2e-2, radians(170.0)],
    )
    if not found.converged:
        raise HarnessFault(f"the calibration did not converge: {found.message}")
    emf_constant, inductance, flat = (float(value) for value in found.values)
    return MotorConstants(emf_constant, inductance, flat, resistance), found


def _shifted(
    cause: str, change: float, figures: PublishedFigures, resistance: float, origin: MotorConstants
) -> Sensitivity:
    moved, _ = _fitted(figures, resistance, origin)
    return Sensitivity(
        cause,
        change,
        moved.emf_constant - origin.emf_constant,
        moved.inductance - origin.inductance,
        moved.emf_flat - origin.emf_flat,
    )


def calibrate(figures: PublishedFigures | None = None, resistance: float = ASSUMED_RESISTANCE) -> Calibration:
    """Fit back-EMF constant, inductance and flat width to the published facts.

    The three torque residuals carry equal weights; three unknowns meet three facts exactly, so that weights
    would change nothing. What is uncertain is shown by the sensitivities instead.

    Parameters
    ----------
    figures : PublishedFigures, optional
        The published figures.
    resistance : float
        Assumed winding resistance (ohm).

    Returns
    -------
    Calibration
        Constants, facts, residuals and sensitivities; the same for the same input.

    Raises
    ------
    HarnessFault
        If the fit does not converge.
    """
    chosen = figures or PublishedFigures()
    constants, found = _fitted(chosen, resistance, _guess())
    worst, middle, rated = (float(residual) for residual in found.residuals)
    # One figure at a time; to first order the magnitudes add up to the worst of all roundings together.
    roundings = [
        _shifted(name, half, replace(chosen, **{name: getattr(chosen, name) + half}), resistance, constants)
        for name, half in ROUNDING.items()
    ]
    # The resistance is assumed, so what the assumption does is shown beside the roundings.
    quarter = 0.25 * resistance
    from_resistance = _shifted("resistance", quarter, chosen, resistance + quarter, constants)
    return Calibration(
        constants=constants,
        facts=published_facts(calibration_drive(constants), chosen),
        torque_residuals=(worst, middle, rated),
        condition=found.condition,
        sensitivities=(*roundings, from_resistance),
        spread=MotorConstants(
            sum(abs(row.emf_constant) for row in roundings),
            sum(abs(row.inductance) for row in roundings),
            sum(abs(row.emf_flat) for row in roundings),
            0.0,
        ),
        geometry=geometry_check(constants.emf_constant),
    )


_SHOWN: Final = {
    "emf_constant": ("EMF constant (V·s/rad)", 1.0),
    "inductance": ("inductance (mH)", 1e3),
    "emf_flat": ("flat width of the EMF (deg)", degrees(1.0)),
}
_STORED: Final = {
    "emf_constant": "emf_constant_v_s_per_rad",
    "inductance": "inductance_h",
    "emf_flat": "emf_flat_deg",
}


def comparison(stored: DriveDocument) -> dict[str, Any]:
    """Return the calibration next to the constants and facts of a stored drive, in SI units and the facts' own.

    Parameters
    ----------
    stored : DriveDocument
        A half-bridge drive with a trapezoidal EMF.

    Returns
    -------
    dict
        Keys ``agrees``, ``constants`` and ``facts`` (with published, fitted and stored values), and ``calibration``.
    """
    # The facts are read with an ideal regulator and without core loss, as in the fit.
    ideal = stored.replaced(hysteresis_band_a=0.0, core_loss_conductance_s=0.0).plant()
    calibration = calibrate(resistance=stored.machine.resistance_ohm)
    constants = {}
    for name, key in _STORED.items():
        fitted, spread = getattr(calibration.constants, name), getattr(calibration.spread, name)
        value = radians(stored.value(key)) if name == "emf_flat" else stored.value(key)
        agrees = abs(value - fitted) <= spread
        constants[name] = {"fitted": fitted, "spread": spread, "stored": value, "agrees": agrees}
    roundings = (ROUNDING["worst_ripple_angle"], ROUNDING["middle_angle"], ROUNDING["rated_power"])
    facts = [
        {**asdict(fact), "rounding": rounding, "stored": own.ours, "agrees": abs(own.residual) <= rounding}
        for fact, own, rounding in zip(calibration.facts, published_facts(ideal), roundings, strict=True)
    ]
    agrees = all(row["agrees"] for row in (*constants.values(), *facts))
    return {"agrees": agrees, "constants": constants, "facts": facts, "calibration": asdict(calibration)}


def table_lines(compared: Mapping[str, Any]) -> list[str]:
    """Return a comparison as lines of text."""
    columns = ("published", "± by rounding", "fitted", "stored", "agrees")
    lines = ["".join(f"{column:>16}" for column in columns)]
    for fact in compared["facts"]:
        values = (fact["published"], fact["rounding"], fact["ours"], fact["stored"])
        lines.append(_line(values, fact["agrees"], f"{fact['name']} ({fact['unit']})"))
    for name, row in compared["constants"].items():
        title, scale = _SHOWN[name]
        values = (None, *(scale * row[key] for key in ("spread", "fitted", "stored")))
        lines.append(_line(values, row["agrees"], title))
    calibration = compared["calibration"]
    largest = max(map(abs, calibration["torque_residuals"]))
    flux = calibration["geometry"]["flux_density"]
    lines.append(
        f"the fit leaves {largest:.1e} N·m of its three torques; condition {calibration['condition']:.0f}"
    )
    lines.append(f"the EMF constant requires {flux:.2f} T in the gap with the published geometry")
    return lines


def _line(values: Sequence[float | None], agrees: bool, title: str) -> str:
    cells = ("" if value is None else f"{value:.4g}" for value in values)
    return "".join(f"{cell:>16}" for cell in (*cells, "yes" if agrees else "no")) + f"  {title}"


def main() -> int:
    """Print the comparison, and return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "--json", action="store_true", help="print one JSON document, in SI units and radians"
    )
    as_json = parser.parse_args().json
    compared = comparison(load_drive("paper-5-phase"))
    print(json.dumps(compared, indent=2) if as_json else "\n".join(table_lines(compared)))  # noqa: T201
    return 0 if compared["agrees"] else 1


if __name__ == "__main__":
    sys.exit(main())
