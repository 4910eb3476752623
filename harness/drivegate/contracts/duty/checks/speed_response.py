"""Check of a regulated speed: how it follows a step, whether it stays calm, and whether another plant is held."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.contracts.duty.checks.accuracy import ERROR_FACTOR, reference_error
from drivegate.contracts.duty.checks.judged import at, worst
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.right_trips import claimed_safe
from drivegate.contracts.duty.scenarios.reaching import greatest_torque, load_on_shaft, reaction_s
from drivegate.contracts.duty.scenarios.released import is_stalled
from drivegate.contracts.duty.scenarios.windows import duty_dwells
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.profile import Dwell
from drivegate_models.units import RADIANS_PER_RPM

SAG_FACTOR = 1.5
"""Change of the speed by a load that comes or goes, over that within the reaction time of the slowest regulator (1)."""


def speed_response(record: DutyRecord) -> Margin | None:
    """Judge overshoot and swing of a regulated speed, on a plant other than the nominal one also its mean."""
    is_other = not record.has_nominal_plant
    if record.fails or not (is_other or record.is_nominal) or _trips_at_a_stall(record):
        return None
    return worst(_margins(record, is_other))


def _trips_at_a_stall(record: DutyRecord) -> bool:
    """Return True if a controller takes a shaft that is stalled at first for a locked one, which it may."""
    if not is_stalled(record.scenario):
        return False
    first, *_ = duty_dwells(record.scenario)
    return bool(claimed_safe(record.run.commands)[record.periods(first.start, first.end)].any())


def _margins(record: DutyRecord, is_other: bool) -> Iterator[Margin | None]:
    for window in record.steady:
        if window.torque_reference is not None:
            continue
        if is_other:
            yield reference_error("ROB-4", record, window, ERROR_FACTOR)
        yield _swing(record, window)
        if not is_other:
            yield _sag(record, window.dwell)
        step = judged_step_rpm(record, window.dwell)
        if step != 0.0:
            speed = record.run.column("speed")[record.periods(window.dwell.start, window.dwell.end)]
            beyond = (speed - window.speed_reference) / RADIANS_PER_RPM
            yield overshoot_of_speed(beyond, step, window.dwell.start, record.document)
            if window.dwell.start > 0.0 and not is_other and _steps_alone(record, window.dwell):
                yield _detour(beyond, step, window.dwell.start, record)


def judged_step_rpm(record: DutyRecord, dwell: Dwell) -> float:
    """Return the step of the speed (rpm) with which a dwell begins; 0 where no overshoot is judged.

    It is judged from the start of the run, or from a state that the regulator had time to settle in, if the step comes
    alone: nothing else happens in that control period that pushes the shaft beyond the new reference.
    """
    scenario = record.scenario
    if is_stalled(scenario) and dwell.start == duty_dwells(scenario)[1].start:
        return dwell.speed_rpm
    if dwell.start == 0.0:
        speed = scenario.initial_speed_rpm
        pushed = load_on_shaft(scenario, dwell, speed * RADIANS_PER_RPM)
    else:
        before = _settled_before(record, dwell)
        if before is None:
            return 0.0
        speed = before.speed_rpm
        loads = (load_on_shaft(scenario, each, speed * RADIANS_PER_RPM) for each in (before, dwell))
        pushed = -next(loads) + next(loads)
    step = dwell.speed_rpm - speed
    return 0.0 if pushed * step > 0.0 else step


def _steps_alone(record: DutyRecord, dwell: Dwell) -> bool:
    """Return True if the load is the same before and after a step of the speed from a settled state."""
    scenario = record.scenario
    before = _settled_before(record, dwell)
    if before is None:
        return False
    speed = before.speed_rpm * RADIANS_PER_RPM
    return load_on_shaft(scenario, before, speed) == load_on_shaft(scenario, dwell, speed)


def _detour(beyond: NDArray[np.float64], step: float, start_s: float, record: DutyRecord) -> Margin:
    """Judge how far a speed leaves its old reference away from the new one; arguments as in `overshoot_of_speed`.

    A regulator that bears the load when its reference changes bears it also afterwards.
    """
    away = -beyond - step if step > 0.0 else beyond + step
    farthest = max(float(np.max(away)), 0.0)
    measured = f"{farthest:.4g} rpm away from a reference {abs(step):.5g} rpm off after {start_s:.4g} s"
    allowed = ERROR_FACTOR * record.limits.speed_tolerance_rpm
    return Margin("ROB-4", at_most(farthest, allowed), measured)


def _sag(record: DutyRecord, dwell: Dwell) -> Margin | None:
    """Judge how far a load that comes or goes alone takes a settled speed; None where none does.

    The slowest regulator that settles bears the load after its reaction time; until then the load moves the shaft. How
    stiff a drive is beyond that is its designer's choice.
    """
    scenario, document = record.scenario, record.document
    before = _settled_before(record, dwell)
    if before is None:
        return None
    reference = dwell.speed_rpm * RADIANS_PER_RPM
    loads = [load_on_shaft(scenario, each, reference) for each in (before, dwell)]
    if before.speed_rpm != dwell.speed_rpm or loads[0] == loads[1]:
        return None
    speed = record.run.column("speed")[record.periods(dwell.start, dwell.end)]
    sag = float(np.max(np.abs(speed - reference))) / RADIANS_PER_RPM
    moved = abs(loads[1] - loads[0]) * reaction_s(document) / document.machine.inertia_kg_m2 / RADIANS_PER_RPM
    allowed = max(SAG_FACTOR * moved, ERROR_FACTOR * record.limits.speed_tolerance_rpm)
    measured = f"{sag:.4g} rpm off after a load step at {dwell.start:.4g} s, {allowed:.4g} rpm are allowed"
    return Margin("ROB-4", at_most(sag, allowed), measured)


def _settled_before(record: DutyRecord, dwell: Dwell) -> Dwell | None:
    """Return the settled stretch that a dwell follows, if no more than reference, load and friction changes there."""
    before = next((each for each, _, _ in record.windows if each.end == dwell.start), None)
    if before is None or dwell.start in record.scenario.restarts_s or _is_other_plant(before, dwell):
        return None
    return before


def _is_other_plant(before: Dwell, dwell: Dwell) -> bool:
    """Return True if more than reference, load and friction changes from one dwell to the next."""
    first, second = (each.scales.model_copy(update={"friction_added_n_m": 0.0}) for each in (before, dwell))
    return first != second or before.supply_v != dwell.supply_v


def overshoot_of_speed(
    beyond: NDArray[np.float64], step: float, start_s: float, drive: PmAcDocument
) -> Margin:
    """Judge how far a speed goes beyond its reference, over the step that its regulator has to make.

    `beyond` is the speed without the reference (rpm), `step` the signed step of the reference (rpm). The regulator has
    to make more of it where a load takes the speed farther away first, and only the last part of one that it begins at
    the torque limit. What a steady speed may be off by is no overshoot.
    """
    limits = limits_of(drive)
    ahead = beyond if step > 0.0 else -beyond
    peak = int(np.argmax(ahead))
    made = min(max(abs(step), -float(np.min(ahead[: peak + 1]))), regulated_rpm(drive))
    over = max(float(ahead[peak]), 0.0)
    allowed = max(limits.speed_overshoot * made, ERROR_FACTOR * limits.speed_tolerance_rpm)
    share = f"{100.0 * over / made:.3g} % of the {made:.4g} rpm step that the regulator makes"
    measured = f"speed overshoots by {over:.4g} rpm, {share}, after the step at {start_s:.4g} s"
    return Margin("ROB-4", at_most(over, allowed), measured)


def regulated_rpm(drive: PmAcDocument) -> float:
    """Return the greatest step of the speed (rpm) that a regulator makes without the greatest torque of the drive.

    It is that of the slowest one that settles in time: its torque reaches the limit at the error that this torque
    makes up for in its reaction time.
    """
    torque = greatest_torque(drive.plant(), 0.0, drive.inverter.link_voltage_v, drive.weakens)
    return reaction_s(drive) * torque / drive.machine.inertia_kg_m2 / RADIANS_PER_RPM


def _swing(record: DutyRecord, window: DutyWindow) -> Margin:
    """Judge whether what swings about the mean grows; below the allowed error it may do what it likes.

    The second half of the window is compared with three times that time before it: of a slow swing that lasts, a
    shorter one might show only where it turns.
    """
    rows = record.periods(window.start_s, window.end_s)
    half = (rows.stop - rows.start) // 2
    speed = record.run.column("speed")
    middle = rows.stop - half
    parts = speed[max(middle - 3 * half, 0) : middle], speed[middle : rows.stop]
    allowed = record.limits.speed_tolerance_rpm * RADIANS_PER_RPM
    first, last = (max(float(np.ptp(part)), allowed) for part in parts)
    growth = last / first
    measured = f"speed swings by {last / RADIANS_PER_RPM:.4g} rpm, {growth:.3g} times as much as before, {at(window)}"
    return Margin("ROB-4", at_most(growth, record.limits.speed_swing_ratio), measured)


ROB_4 = Check(
    id="ROB-4",
    families=("parameter", "speed step", "reversal", "load step", "start"),
    requirement="After a step, the speed overshoots its reference, moves away from it and sags under a load by no more "
    "than the limits, and its oscillation does not grow. On a plant that differs from the nameplate, the steady speed "
    "stays within 2 k1 of its reference.",
    limit="overshoot {speed_overshoot}, swing × {speed_swing_ratio}, detour and on another plant speed error 2 k1, sag "
    "by a load 1.5 times that within the slowest reaction",
    scenarios="runs of a speed reference on the nominal drive, and with R × 0.5 to 2, L × 0.7 to 1.3, ψ × 0.8 to 1.05 "
    "and J × 0.3 to 2, also within a run, as of a wheel that is lifted and set down",
    formula="the least of 1 - overshoot / {speed_overshoot}, 1 - growth of the swing / {speed_swing_ratio}, 1 - detour "
    "/ 2 k1, 1 - sag / limit, and on another plant 1 - speed error / 2 k1",
    why="Loops above the speed rely on its response. Windings warm up, iron saturates, magnets age, loads have inertia "
    "of their own; the nameplate stays.",
    evaluate=speed_response,
)
