"""A drive in the quantities of a data sheet, in which poles taken for pairs and terminal for phase values are seen."""

from __future__ import annotations

from math import sqrt
from typing import Any, Final

from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.usual_values import unusual_keys
from drivegate_models.units import RADIANS_PER_RPM

_SQRT3: Final = sqrt(3.0)
_FEWEST_PERIODS: Final = 24.0
"""Control periods in an electrical period at the highest speed below which the pole pairs are doubted."""
_MOST_RESISTIVE: Final = 0.5
"""Share of the phase voltage that the resistance may take at the current limit before it is doubted."""
_TERMINAL: Final = ("resistance_ohm", "inductance_h", "direct_inductance_h", "quadrature_inductance_h")


def sheet_values(drive: DriveDocument) -> dict[str, float]:
    """Return a drive's values as data sheets state them, by names with units.

    Between two terminals a star has twice the resistance of a phase. The stall torque is that of the link's voltage
    over this resistance at standstill, with two phases conducting and without a current limit.
    """
    machine = drive.machine
    values = {"link_voltage_v": _link(drive), "poles": 2.0 * machine.pole_pairs}
    emf = _line_emf(drive)
    if emf is None:
        return values | {"phase_resistance_ohm": machine.resistance_ohm}
    resistance = 2.0 * machine.resistance_ohm
    return values | {
        "speed_constant_rpm_per_v": 1.0 / (emf * RADIANS_PER_RPM),
        "torque_constant_nm_per_a": emf,
        "terminal_resistance_ohm": resistance,
        "stall_torque_nm": emf * values["link_voltage_v"] / resistance,
    }


def _link(drive: DriveDocument) -> float:
    if isinstance(drive, PmAcDocument):
        return drive.inverter.link_voltage_v
    return 2.0 * drive.inverter.supply_voltage_v


def _line_emf(drive: DriveDocument) -> float | None:
    """Return the peak EMF between two terminals over the speed (V·s/rad); None where phases share no star."""
    if isinstance(drive, PmAcDocument):
        return _SQRT3 * drive.machine.pole_pairs * drive.machine.magnet_flux_v_s
    return 2.0 * drive.machine.emf_constant_v_s_per_rad if drive.kind == "star" else None


def sheet_in_words(values: dict[str, float], pole_pairs: int) -> str:
    """Write such values in the order of a data sheet."""
    parts = [
        f"link {values['link_voltage_v']:.4g} V",
        f"{values['poles']:.0f} poles (pole_pairs = {pole_pairs})",
    ]
    if "phase_resistance_ohm" in values:
        return ", ".join([*parts, f"{values['phase_resistance_ohm']:.4g} Ω a phase"])
    return ", ".join(
        [
            *parts,
            f"Kv {values['speed_constant_rpm_per_v']:.4g} rpm/V",
            f"Kt {values['torque_constant_nm_per_a']:.4g} N·m/A",
            f"{values['terminal_resistance_ohm']:.4g} Ω between terminals",
            f"stall torque {values['stall_torque_nm']:.4g} N·m",
        ]
    )


def doubtful_values(drive: DriveDocument, *, is_refused: bool, accepts: Any) -> tuple[str, ...]:
    """Ask whether poles were taken for pole pairs, or terminal values for those of a phase, where it looks like that.

    Parameters
    ----------
    drive : DriveDocument
        The drive.
    is_refused : bool
        Whether its rating is out of reach.
    accepts : callable
        Returns True if a rating of another drive is within reach.
    """
    found = []
    pairs = drive.machine.pole_pairs
    if pairs % 2 == 0 and (
        _periods(drive) < _FEWEST_PERIODS <= 2.0 * _periods(drive)
        or (is_refused and accepts(drive.replaced(pole_pairs=pairs // 2)))
    ):
        found.append(
            f"pole_pairs is {pairs}, which are {2 * pairs} poles: does the data sheet state {pairs} poles? Then write "
            f"pole_pairs = {pairs // 2}"
        )
    known = {key: float(drive.value(key)) / 2.0 for key in _TERMINAL if key in drive.table_of_key()}
    share = _resistive_share(drive)
    if known.keys() & unusual_keys(drive).keys():
        # A value in another unit has been asked about, and half of it would be no better.
        return tuple(found)
    if share > _MOST_RESISTIVE or (is_refused and accepts(drive.replaced(**known))):
        halved = ", ".join(f"{key} = {value:g}" for key, value in known.items())
        found.append(
            f"the resistance takes {100.0 * share:.3g} % of the phase voltage at the current limit: does the data "
            f"sheet state resistance and inductance between terminals? Then write half of them: {halved}"
        )
    return tuple(found)


def _periods(drive: DriveDocument) -> float:
    """Count control periods in an electrical period at the highest speed; infinite where no carrier is stated."""
    if not isinstance(drive, PmAcDocument):
        return float("inf")
    frequency = drive.machine.pole_pairs * drive.rating.highest_speed_rpm / 60.0
    return 1.0 / (frequency * drive.inverter.control_period_s)


def _resistive_share(drive: DriveDocument) -> float:
    """Return the part of a phase's voltage that its resistance takes at the current limit (1)."""
    volts = _link(drive) / _SQRT3 if isinstance(drive, PmAcDocument) else 0.5 * _link(drive)
    return float(drive.machine.resistance_ohm * drive.rating.current_limit_a / volts)
