"""The motor derived anew from the published facts, beside the stored one."""

from __future__ import annotations

from math import degrees
from typing import Any, Final

from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.steady.calibration import (
    ROUNDING,
    Calibration,
    ComparedFigure,
    MotorConstants,
    calibrate,
    published_facts,
)

SCHEMA: Final = 1


def calibration_document(stored: DriveDocument) -> dict[str, Any]:
    """Fit the motor's constants to the facts, and compare them with those of a stored drive."""
    # The facts are read with an ideal regulator and without core loss, as in the fit.
    ideal = stored.replaced(hysteresis_band_a=0.0, core_loss_conductance_s=0.0).plant()
    calibration = calibrate(resistance=stored.machine.resistance_ohm)
    fitted, spread = _constants(calibration.constants), _constants(calibration.spread)
    constants = [
        {
            "key": key,
            "fitted": fitted[key],
            "spread": spread[key],
            "stored": stored.value(key),
            "agrees": abs(stored.value(key) - fitted[key]) <= spread[key],
        }
        for key in fitted
    ]
    facts = _facts(calibration.facts, published_facts(ideal))
    return {
        "schema": SCHEMA,
        "drive": stored.name,
        "agrees": all(row["agrees"] for row in (*constants, *facts)),
        "resistance_ohm": stored.machine.resistance_ohm,
        "constants": constants,
        "facts": facts,
        **_evidence(calibration),
    }


def _constants(constants: MotorConstants) -> dict[str, float]:
    return {
        "emf_constant_v_s_per_rad": constants.emf_constant,
        "inductance_h": constants.inductance,
        "emf_flat_deg": degrees(constants.emf_flat),
    }


def _facts(fitted: tuple[ComparedFigure, ...], stored: tuple[ComparedFigure, ...]) -> list[dict[str, Any]]:
    roundings = (ROUNDING["worst_ripple_angle"], ROUNDING["middle_angle"], ROUNDING["rated_power"])
    return [
        {
            "name": ours.name,
            "published": ours.published,
            "rounding": rounding,
            "ours": ours.ours,
            "residual": ours.residual,
            "stored": theirs.ours,
            "stored_residual": theirs.residual,
            "agrees": abs(theirs.residual) <= rounding,
            "unit": ours.unit,
        }
        for ours, theirs, rounding in zip(fitted, stored, roundings, strict=True)
    ]


def _evidence(calibration: Calibration) -> dict[str, Any]:
    geometry = calibration.geometry
    return {
        "torque_residuals_nm": list(calibration.torque_residuals),
        "condition": calibration.condition,
        "sensitivities": [
            {
                "cause": row.cause,
                "change": row.change,
                "emf_constant_v_s_per_rad": row.emf_constant,
                "inductance_h": row.inductance,
                "emf_flat_deg": degrees(row.emf_flat),
            }
            for row in calibration.sensitivities
        ],
        "geometry": {
            "series_turns": geometry.series_turns,
            "core_length_m": geometry.core_length,
            "radius_m": geometry.radius,
            "flux_density_t": geometry.flux_density,
        },
    }
