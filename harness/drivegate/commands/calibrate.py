"""``drivegate calibrate``: the motor derived anew from the published facts."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import ExitCode, Outcome
from drivegate.commands.options import json_option
from drivegate.drives.kinds import DEFAULT_MOTOR

if TYPE_CHECKING:
    from rich.console import Console

    from drivegate_models.half_bridge.steady.calibration import Calibration, Fact, MotorConstants

SCHEMA = 1

_SHOWN = {
    "emf_constant_v_s_per_rad": (1.0, "EMF constant", "V·s/rad"),
    "inductance_h": (1e3, "inductance", "mH"),
    "emf_flat_deg": (1.0, "flat width of the EMF", "°"),
}


@click.command("calibrate")
@json_option
def command() -> Outcome:
    """Derive the motor anew from the published facts, and compare it with the stored one."""
    from drivegate_cases.motor.motor import load_motor
    from drivegate_models.half_bridge.steady.calibration import calibrate, published_facts

    stored = load_motor(DEFAULT_MOTOR)
    # The facts are read with an ideal regulator and without core loss, as in the fit.
    ideal = stored.replaced(hysteresis_band_a=0.0, core_loss_conductance_s=0.0).drive()
    calibration = calibrate(resistance=stored.resistance_ohm)
    fitted, spread = _constants(calibration.constants), _constants(calibration.spread)
    constants = [
        {
            "key": key,
            "fitted": fitted[key],
            "spread": spread[key],
            "stored": getattr(stored, key),
            "agrees": abs(getattr(stored, key) - fitted[key]) <= spread[key],
        }
        for key in _SHOWN
    ]
    facts = _facts(calibration.facts, published_facts(ideal))
    document = {
        "schema": SCHEMA,
        "motor": stored.name,
        "agrees": all(row["agrees"] for row in (*constants, *facts)),
        "resistance_ohm": stored.resistance_ohm,
        "constants": constants,
        "facts": facts,
        **_evidence(calibration),
    }
    code = ExitCode.PASSED if document["agrees"] else ExitCode.FAILED
    return Outcome(document, lambda console: _show(console, document), code)


def _constants(constants: MotorConstants) -> dict[str, float]:
    return {
        "emf_constant_v_s_per_rad": constants.emf_constant,
        "inductance_h": constants.inductance,
        "emf_flat_deg": degrees(constants.emf_flat),
    }


def _facts(fitted: tuple[Fact, ...], stored: tuple[Fact, ...]) -> list[dict[str, Any]]:
    from drivegate_models.half_bridge.steady.calibration import ROUNDING

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


def _show(console: Console, document: dict[str, Any]) -> None:
    from drivegate.output.console import number, plain, table

    numbers = ("published", "± by rounding", "fitted", "stored")
    facts = table("published fact", *numbers, "unit", "agrees", right=numbers)
    for fact in document["facts"]:
        values = (number(fact[key]) for key in ("published", "rounding", "ours", "stored"))
        facts.add_row(plain(fact["name"]), *values, plain(fact["unit"]), "yes" if fact["agrees"] else "no")
    console.print(facts)
    columns = ("fitted", "± by rounding", "stored")
    constants = table("constant", *columns, "unit", "agrees", right=columns)
    for row in document["constants"]:
        scale, name, unit = _SHOWN[row["key"]]
        values = (number(scale * row[key], 4) for key in ("fitted", "spread", "stored"))
        constants.add_row(name, *values, unit, "yes" if row["agrees"] else "no")
    console.print(constants)
    largest = max(abs(residual) for residual in document["torque_residuals_nm"])
    flux = document["geometry"]["flux_density_t"]
    console.print(
        plain(f"the fit leaves {largest:.1e} N·m of its three torques; condition {document['condition']:.0f}")
    )
    console.print(plain(f"the EMF constant asks for {flux:.2f} T in the gap with the published geometry"))
    if document["agrees"]:
        console.print(plain(f"the stored motor '{document['motor']}' agrees with the fit", "green"))
    else:
        told = f"the stored motor '{document['motor']}' differs from the fit by more than rounding explains"
        console.print(plain(told, "bold red"))
    console.print(
        plain("next: drivegate point shows what the motor does; --json has the sensitivities", "dim")
    )
