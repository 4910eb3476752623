"""The steady state at one operating point, at a torque or at a current reference, as a document."""

from __future__ import annotations

from math import pi, radians
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from rich.console import Console

from drivegate.contracts.current.numbers import given_below_limit
from drivegate.output.console import number, print_line, table
from drivegate_cases.documents.wording import counted
from drivegate_models.errors import InputError
from drivegate_models.machine import ledger
from drivegate_models.machine.period import APERIODIC
from drivegate_models.steady.plant import AnyDrive, advance_phases, make_phases, periodic_start
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate_models.steady.oracle import TorquePoint
    from drivegate_models.steady.steady_state import SteadyState

_ROWS: Final = (
    ("speed_rpm", "speed", "rpm"),
    ("advance_deg", "advance angle", "°"),
    ("current_reference_a", "current reference", "A"),
    ("torque_mean_nm", "torque, mean", "N·m"),
    ("torque_lowest_nm", "torque, least", "N·m"),
    ("torque_highest_nm", "torque, greatest", "N·m"),
    ("torque_ripple_percent", "torque ripple, peak to peak over mean", "%"),
    ("torque_ripple_one_sided_percent", "torque ripple, greatest deviation over mean", "%"),
    ("current_sum_a", "Σ|i|, mean", "A"),
    ("exchanged_power_w", "power exchanged with the supply", "W"),
    ("input_power_w", "input power, net", "W"),
    ("copper_loss_w", "copper loss", "W"),
    ("core_loss_w", "core loss", "W"),
    ("current_peak_a", "phase current, peak", "A"),
)
_OFFSET: Final = 1e-3
"""Offset that is added to a current, over the current reference and 1 A (1)."""
_DECAY: Final = 1e-6
"""Least share of an offset that a cycle takes off, where the state is the only one (1)."""
SCHEMA: Final = 1
LONGEST_TIME: Final = 3600.0
"""Longest simulated time of all cycles together (s), so that an answer comes within seconds to minutes."""

_NO_TORQUE: Final = 1e-9


def point_document(
    drive: AnyDrive,
    speed_rpm: float,
    advance_deg: float,
    *,
    torque_nm: float | None,
    current_a: float | None,
    cycles: int | None,
) -> dict[str, Any]:
    """Compute the steady state at a speed, an angle, and either a torque or a current reference."""
    speed, advance = speed_rpm * RADIANS_PER_RPM, radians(advance_deg)
    count = cycles or 1
    cycle = 2.0 * pi / (drive.pole_pairs * speed)
    if count * cycle > LONGEST_TIME:
        lowest = 60.0 * count / (drive.pole_pairs * LONGEST_TIME)
        raise InputError(
            f"at this speed {counted(count, 'electrical cycle')} would take {count * cycle:.4g} s, "
            f"but at most {LONGEST_TIME:g} s are computed; give fewer cycles, or a speed of {lowest:.3g} rpm or more"
        )
    heading = {"schema": SCHEMA, "speed_rpm": speed_rpm, "advance_deg": advance_deg}
    if torque_nm is not None:
        return heading | _values_at_torque(drive, speed, advance, torque_nm)
    assert current_a is not None, "one of torque and current is given"
    return heading | _values_at_current(drive, speed, advance, current_a, cycles)


def _values_at_torque(drive: AnyDrive, speed: float, advance: float, torque: float) -> dict[str, Any]:
    from drivegate_models.steady.oracle import point_at_torque

    point = point_at_torque(drive, speed, advance, torque)
    if not point.robust:
        at_limit = _values_at_current(drive, speed, advance, drive.current_limit, None)
        below = {"reference_below_limit_a": point.reference} if point.static else {}
        return at_limit | {"feasible": False, "feasible_below_limit": point.static} | below
    values = _values(point.reference, True, point, point.input_power)
    unique = _is_unique(drive, speed, advance, point.reference)
    return values | {"certified": point.certified, "unique": unique, "feasible_below_limit": point.static}


def _values_at_current(
    drive: AnyDrive, speed: float, advance: float, reference: float, cycles: int | None
) -> dict[str, Any]:
    from drivegate_models.steady import steady_state as solver

    if cycles is None:
        state = solver.steady_state(drive, speed, reference, advance)
        averaged = {} if state.certified else {"averaged_cycles": solver.AVERAGED_CYCLES}
        unique = _is_unique(drive, speed, advance, reference)
    else:
        work = make_phases(drive, solver.KEPT_TIME)
        voltage = drive.half_supply_voltage
        state = solver.cycles_from_rest(drive, work, speed, voltage, reference, advance, cycles)
        averaged = {"averaged_cycles": 1}
        # These cycles begin without a current, and so does the one state that they lead to.
        unique = True
    input_power = state.source_power + state.core_source_power + state.switching_loss
    values = _values(reference, reference <= drive.current_limit, state, input_power)
    return values | {"certified": bool(state.certified), "unique": unique} | averaged


def _values(
    reference: float, feasible: bool, state: SteadyState | TorquePoint, input_power: float
) -> dict[str, Any]:
    mean, lowest, highest = state.torque, state.torque_lowest, state.torque_highest
    return {
        "current_reference_a": reference,
        "feasible": feasible,
        "torque_mean_nm": mean,
        "torque_lowest_nm": lowest,
        "torque_highest_nm": highest,
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


def _is_unique(drive: AnyDrive, speed: float, advance: float, reference: float) -> bool:
    """Return True if a dc offset of a current does not persist in the periodic state, or if there is no such state.

    Without resistance a current that reaches neither zero nor its limit has nothing that returns it to one state. Speed
    in rad/s, advance in rad electrical, reference in A.
    """
    if drive.resistance > 0.0:
        return True
    state, voltage = make_phases(drive), drive.half_supply_voltage
    periods = periodic_start(drive, state, make_phases(drive), speed, voltage, reference, advance)
    if periods == APERIODIC:
        return True
    cycle = 2.0 * pi / (drive.pole_pairs * speed)
    angle = 0.5 * (pi - drive.window) - advance
    offset = _OFFSET * (1.0 + reference)
    for added in (offset, -offset):
        moved = make_phases(drive)
        for its, found in zip(moved, state, strict=True):
            its[:] = found
        moved.currents[0] += added
        if drive.phases > 1:
            # In a star the sum of the currents stays zero.
            moved.currents[-1] -= added
        start = moved.currents.copy()
        totals = np.zeros(ledger.ENTRIES)
        advance_phases(drive, moved, angle, speed, voltage, voltage, reference, advance, cycle, totals)
        if np.abs(moved.currents - start).max() < _DECAY * offset:
            return False
    return True


def show_point(console: Console, document: dict[str, Any], drive: AnyDrive, torque: float | None) -> None:
    """Print the values, and what they do not hold for."""
    values = table("quantity", "value", "unit", right=("value",))
    for key, name, unit in _ROWS:
        values.add_row(name, number(document[key]), unit)
    console.print(values)
    if not document["feasible"]:
        below = document.get("reference_below_limit_a")
        lost = "" if below is None else f"; {given_below_limit(below)}"
        reason = (
            f"{torque:g} N·m cannot be produced here at the current limit of {drive.current_limit:g} A; "
            f"the values are those at the limit{lost}"
            if torque is not None
            else f"the current reference exceeds the limit of {drive.current_limit:g} A"
        )
        print_line(console, f"not feasible: {reason}", "yellow")
    if document.get("averaged_cycles", 1) > 1:
        print_line(
            console,
            f"no periodic state exists here; means are over {document['averaged_cycles']} electrical cycles",
        )
    if not document["unique"]:
        print_line(
            console,
            "the periodic state is not unique: without resistance, a current that reaches neither zero nor its "
            "limit retains any dc offset; the values are those of one such state",
            "yellow",
        )
    print_line(
        console, "next: another angle shows what Σ|i| costs; drivegate map computes many at once", "dim"
    )
