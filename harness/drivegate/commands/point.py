"""``drivegate point``: the steady state at one operating point."""

from __future__ import annotations

from math import pi, radians
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import bounded, chosen_motor, json_option, motor_options
from drivegate.drives.kinds import DEFAULT_MOTOR
from drivegate_cases.documents.wording import counted
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from drivegate_models.half_bridge.plant.drive import Drive
    from drivegate_models.half_bridge.steady.oracle import TorquePoint
    from drivegate_models.half_bridge.steady.steady_state import SteadyState

SCHEMA = 1
LONGEST_TIME = 3600.0
"""Longest simulated time of all cycles together (s), so that an answer comes within seconds to minutes."""

_NO_TORQUE = 1e-9

_ROWS = (
    ("speed_rpm", "speed", "rpm"),
    ("advance_deg", "advance angle", "°"),
    ("current_reference_a", "current reference", "A"),
    ("torque_mean_nm", "torque, mean", "N·m"),
    ("torque_ripple_percent", "torque ripple, peak to peak over mean", "%"),
    ("torque_ripple_one_sided_percent", "torque ripple, greatest deviation over mean", "%"),
    ("current_sum_a", "Σ|i|, mean", "A"),
    ("exchanged_power_w", "power exchanged with the supply", "W"),
    ("input_power_w", "input power, net", "W"),
    ("copper_loss_w", "copper loss", "W"),
    ("core_loss_w", "core loss", "W"),
    ("current_peak_a", "phase current, peak", "A"),
)


@click.command("point")
@click.option("--speed-rpm", type=bounded(0.0, 1e5, above=True), required=True, help="Speed of the shaft.")
@click.option(
    "--advance-deg", type=bounded(0.0, 90.0), required=True, help="Advance angle, electrical degrees."
)
@click.option("--torque-nm", type=bounded(0.0, 1e6), help="Mean electromagnetic torque; finds the current.")
@click.option("--current-a", type=bounded(0.0, 1e5), help="Current reference.")
@click.option(
    "--cycles",
    type=click.IntRange(1, 100_000),
    help="Start with no current, run this many electrical cycles and average over the last.",
)
@motor_options
@json_option
def command(
    speed_rpm: float,
    advance_deg: float,
    torque_nm: float | None,
    current_a: float | None,
    cycles: int | None,
    motor: str | None,
    settings: tuple[str, ...],
) -> Outcome:
    """Compute the steady state at one operating point.

    Give the speed, the advance angle, and either the torque or the current reference.
    """
    if (torque_nm is None) == (current_a is None):
        raise click.UsageError("give exactly one of --torque-nm and --current-a")
    if cycles is not None and current_a is None:
        raise click.UsageError("--cycles goes with --current-a only")
    from drivegate_cases.motor.motor import load_motor

    drive = chosen_motor(motor, settings, lambda: load_motor(DEFAULT_MOTOR)).drive()
    speed, advance = speed_rpm * pi / 30.0, radians(advance_deg)
    _check_length(drive, speed, cycles or 1)
    heading = {"schema": SCHEMA, "speed_rpm": speed_rpm, "advance_deg": advance_deg}
    if torque_nm is not None:
        document = heading | _values_at_torque(drive, speed, advance, torque_nm)
    else:
        assert current_a is not None, "one of torque and current is given"
        document = heading | _values_at_current(drive, speed, advance, current_a, cycles)
    return Outcome(document, lambda console: _show(console, document, drive, torque_nm))


def _check_length(drive: Drive, speed: float, cycles: int) -> None:
    """Refuse what would take hours to compute."""
    cycle = 2.0 * pi / (drive.pole_pairs * speed)
    if cycles * cycle > LONGEST_TIME:
        lowest = 60.0 * cycles / (drive.pole_pairs * LONGEST_TIME)
        raise InputError(
            f"at this speed {counted(cycles, 'electrical cycle')} would take {cycles * cycle:.4g} s, "
            f"but at most {LONGEST_TIME:g} s are computed; give fewer cycles, or a speed of {lowest:.3g} rpm or more"
        )


def _values_at_torque(drive: Drive, speed: float, advance: float, torque: float) -> dict[str, Any]:
    from drivegate_models.half_bridge.steady.oracle import point_at_torque

    point = point_at_torque(drive, speed, advance, torque)
    if not point.robust:
        at_limit = _values_at_current(drive, speed, advance, drive.current_limit, None)
        return at_limit | {"feasible": False, "feasible_below_limit": point.static}
    values = _values(point.reference, True, point, point.input_power)
    return values | {"certified": point.certified, "feasible_below_limit": point.static}


def _values_at_current(
    drive: Drive, speed: float, advance: float, reference: float, cycles: int | None
) -> dict[str, Any]:
    from drivegate_models.half_bridge.plant.phases import make_phases
    from drivegate_models.half_bridge.steady import steady_state as solver

    if cycles is None:
        state = solver.steady_state(drive, speed, reference, advance)
        averaged = {} if state.certified else {"averaged_cycles": solver.AVERAGED_CYCLES}
    else:
        work = make_phases(drive, solver.KEPT_TIME)
        voltage = drive.half_supply_voltage
        state = solver.cycles_from_rest(drive, work, speed, voltage, reference, advance, cycles)
        averaged = {"averaged_cycles": 1}
    input_power = state.source_power + state.core_source_power + state.switching_loss
    values = _values(reference, reference <= drive.current_limit, state, input_power)
    return values | {"certified": bool(state.certified)} | averaged


def _values(
    reference: float, feasible: bool, state: SteadyState | TorquePoint, input_power: float
) -> dict[str, Any]:
    mean, lowest, highest = state.torque, state.torque_lowest, state.torque_highest
    return {
        "current_reference_a": reference,
        "feasible": feasible,
        "torque_mean_nm": mean,
        "torque_ripple_percent": _percent(highest - lowest, mean),
        "torque_ripple_one_sided_percent": _percent(max(highest - mean, mean - lowest), mean),
        "current_sum_a": state.current_sum,
        "exchanged_power_w": state.exchanged_power,
        "input_power_w": input_power,
        "copper_loss_w": state.copper_loss,
        "core_loss_w": state.core_loss,
        "current_peak_a": state.current_peak,
    }


def _percent(part: float, whole: float) -> float | None:
    """Return a share of the mean's magnitude; None where the mean is no more than rounding leaves of 0."""
    return 100.0 * part / abs(whole) if abs(whole) > _NO_TORQUE else None


def _show(console: Console, document: dict[str, Any], drive: Drive, torque: float | None) -> None:
    from drivegate.output.console import number, plain, table

    values = table("quantity", "value", "unit", right=("value",))
    for key, name, unit in _ROWS:
        values.add_row(name, number(document[key]), unit)
    console.print(values)
    if not document["feasible"]:
        asked = (
            f"{torque:g} N·m cannot be produced here at the current limit of {drive.current_limit:g} A; "
            "the values are those at the limit"
            if torque is not None
            else f"the current reference exceeds the limit of {drive.current_limit:g} A"
        )
        console.print(plain(f"not feasible: {asked}", "yellow"))
    if document.get("averaged_cycles", 1) > 1:
        console.print(
            plain(
                f"no periodic state exists here; means are over {document['averaged_cycles']} electrical cycles"
            )
        )
    console.print(
        plain("next: another angle shows what Σ|i| costs; drivegate cases lists published points", "dim")
    )
