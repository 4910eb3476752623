"""The derived motor on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from drivegate.output.console import number, plain, table

if TYPE_CHECKING:
    from rich.console import Console

_SHOWN: Final = {
    "emf_constant_v_s_per_rad": (1.0, "EMF constant", "V·s/rad"),
    "inductance_h": (1e3, "inductance", "mH"),
    "emf_flat_deg": (1.0, "flat width of the EMF", "°"),
}


def show_calibration(console: Console, document: dict[str, Any]) -> None:
    """Print facts and constants, fitted and stored."""
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
    console.print(plain(f"the EMF constant requires {flux:.2f} T in the gap with the published geometry"))
    if document["agrees"]:
        console.print(plain(f"the stored drive '{document['drive']}' agrees with the fit", "green"))
    else:
        message = (
            f"the stored drive '{document['drive']}' differs from the fit by more than rounding explains"
        )
        console.print(plain(message, "bold red"))
    console.print(
        plain("next: drivegate point shows what the motor does; --json has the sensitivities", "dim")
    )
