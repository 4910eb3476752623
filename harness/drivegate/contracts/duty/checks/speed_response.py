"""Check of a regulated speed: how it follows a step, whether it stays calm, and whether another plant is held."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most
from drivegate.contracts.duty.checks.accuracy import ERROR_FACTOR, reference_error
from drivegate.contracts.duty.checks.judged import at, unless_sensed, worst
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.right_trips import claimed_safe
from drivegate.contracts.duty.scenarios.reaching import greatest_torque, load_on_shaft, reaction_s
from drivegate.contracts.duty.scenarios.released import is_stalled
from drivegate.contracts.duty.scenarios.windows import duty_dwells
from drivegate.scenarios.rotation import sense_of
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.profile import Dwell
from drivegate_models.units import RADIANS_PER_RPM

SHOWN_PERIODS = 100
"""Control periods before and after a step that figures show at least."""
SAG_FACTOR = 1.5
"""Change of the speed by a load that comes or goes, over that within the reaction time of the slowest regulator (1)."""
RELEASE_RISES = 4.0
"""Time in which a regulator takes back the torque that it made against a stall, over the rise time of a torque (1): the
time constant of the integral of a symmetrical optimum with a = 2 is four times that of the torque."""


def speed_response(record: DutyRecord) -> Margin | None:
    """Judge overshoot and swing of a regulated speed, on a plant other than the nominal one also its mean."""
    is_other = not record.has_nominal_plant
    is_hot = record.scenario.winding_temperature_c is not None
    if record.fails or is_hot or not (is_other or record.is_nominal) or _trips_at_a_stall(record):
        return None
    return worst(margin for margin, _ in _judged(record, is_other))


def speed_moment(record: DutyRecord) -> Moment | None:
    """Show the speed where it decides: the step, the load step or the stretch, with what is allowed there."""
    if speed_response(record) is None:
        return None
    judged = _judged(record, not record.has_nominal_plant)
    _, shown = min(judged, key=lambda pair: pair[0].value)
    period = record.scenario.control_period_s
    speed = record.run.column("speed") / RADIANS_PER_RPM
    place = shown.place
    return Moment(
        start_s=max(shown.rows.start - shown.before, 0) * period,
        end_s=shown.rows.stop * period,
        column="speed_rpm",
        origin_s=shown.rows.start * period,
        levels=tuple(Mark(words=words, value=value) for words, value in shown.levels),
        point=Point(words=shown.words, time_s=(place + 0.5) * period, value=float(speed[place])),
    )


def _trips_at_a_stall(record: DutyRecord) -> bool:
    """Return True if a controller takes a shaft that is stalled at first for a locked one, which it may."""
    if not is_stalled(record.scenario):
        return False
    first, *_ = duty_dwells(record.scenario)
    return bool(claimed_safe(record.run.commands)[record.periods(first.start, first.end)].any())


@dataclass(frozen=True)
class _Shown:
    """What a figure shows of a margin."""

    rows: slice
    """The control periods."""
    place: int
    """The one that is marked."""
    words: str
    levels: tuple[tuple[str, float], ...] = ()
    """References and limits, with words (rpm)."""
    before: int = 0
    """Control periods before them that are shown as well."""


_Judged: TypeAlias = "tuple[Margin, _Shown]"


def _judged(record: DutyRecord, is_other: bool) -> Iterator[_Judged]:
    for window in record.steady:
        if window.torque_reference is not None:
            continue
        if is_other:
            yield from _mean_error(record, window)
        yield _swing(record, window)
        if not is_other:
            yield from _sag(record, window.dwell)
        step = judged_step_rpm(record, window.dwell)
        if step != 0.0:
            beyond, released = _beyond(record, window.dwell), _released_rpm(record, window.dwell, step)
            allowed = max(allowed_overshoot_rpm(beyond, step, record.document), released)
            margin = overshoot_of_speed(beyond, step, window.dwell.start, record.document, released)
            yield margin, _overshoot_shown(record, window.dwell, beyond, step, allowed)
            if window.dwell.start > 0.0 and not is_other and _steps_alone(record, window.dwell):
                yield _detour(beyond, step, window.dwell, record)


def _beyond(record: DutyRecord, dwell: Dwell) -> NDArray[np.float64]:
    """Return the speed of a dwell without its reference, shape (n,) (rpm)."""
    speed = record.run.column("speed")[record.periods(dwell.start, dwell.end)]
    return (speed - dwell.speed_rpm * RADIANS_PER_RPM) / RADIANS_PER_RPM


def _mean_error(record: DutyRecord, window: DutyWindow) -> Iterator[_Judged]:
    margin = reference_error("ROB-4", record, window, ERROR_FACTOR)
    if margin is not None:
        rows, wanted = record.periods(window.start_s, window.end_s), window.dwell.speed_rpm
        mean = window.speed / RADIANS_PER_RPM
        speed = record.run.column("speed")[rows] / RADIANS_PER_RPM
        levels = ("reference", wanted), (f"mean {mean:.5g} rpm", mean)
        place = rows.start + int(np.argmin(np.abs(speed - mean)))
        yield margin, _Shown(rows, place, f"off by {abs(mean - wanted):.4g} rpm", levels)


def _around(record: DutyRecord, dwell: Dwell, place: int) -> slice:
    """Return the control periods from the start of a dwell to twice as far as one of its places, or further."""
    rows = record.periods(dwell.start, dwell.end)
    return slice(rows.start, min(rows.start + max(2 * place, SHOWN_PERIODS), rows.stop))


def _overshoot_shown(
    record: DutyRecord, dwell: Dwell, beyond: NDArray[np.float64], step: float, allowed_rpm: float
) -> _Shown:
    sense = 1.0 if step > 0.0 else -1.0
    place = int(np.argmax(sense * beyond))
    wanted, rows = dwell.speed_rpm, _around(record, dwell, place)
    allowed = sense * allowed_rpm
    levels = ("reference", wanted), (f"limit {wanted + allowed:.5g} rpm", wanted + allowed)
    words = f"{max(sense * float(beyond[place]), 0.0):.4g} rpm beyond"
    return _Shown(rows, rows.start + place, words, levels, SHOWN_PERIODS)


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
        load = load_on_shaft(scenario, dwell, speed * RADIANS_PER_RPM)
        # A controller that begins on a turning shaft takes its magnets for nominal: others move it until it notices.
        pushes: tuple[float, ...] = (load, (1.0 - dwell.scales.emf_constant) * speed)
    else:
        before = _settled_before(record, dwell)
        if before is None:
            return 0.0
        speed = before.speed_rpm
        loads = (load_on_shaft(scenario, each, speed * RADIANS_PER_RPM) for each in (before, dwell))
        pushes = (-next(loads) + next(loads),)
    step = dwell.speed_rpm - speed
    return 0.0 if any(push * step > 0.0 for push in pushes) else step


def _released_rpm(record: DutyRecord, dwell: Dwell, step: float) -> float:
    """Return how far a shaft that comes free from a stall may run away (rpm), 0 for any other one.

    An integral has grown against the stall, up to the greatest torque, and the shaft runs away until it is taken back.
    """
    scenario, document = record.scenario, record.document
    if not is_stalled(scenario) or dwell.start != duty_dwells(scenario)[1].start:
        return 0.0
    before = record.run.column("torque")[record.periods(dwell.start, dwell.end).start - 1]
    load = load_on_shaft(scenario, dwell, dwell.speed_rpm * RADIANS_PER_RPM)
    pushed = max(sense_of(step) * (float(before) + load), 0.0)
    time = RELEASE_RISES * document.requirements.rise_periods * document.control_period_s
    return SAG_FACTOR * pushed * time / document.machine.inertia_kg_m2 / RADIANS_PER_RPM


def _steps_alone(record: DutyRecord, dwell: Dwell) -> bool:
    """Return True if the load is the same before and after a step of the speed from a settled state."""
    scenario = record.scenario
    before = _settled_before(record, dwell)
    if before is None:
        return False
    speed = before.speed_rpm * RADIANS_PER_RPM
    return load_on_shaft(scenario, before, speed) == load_on_shaft(scenario, dwell, speed)


def _detour(beyond: NDArray[np.float64], step: float, dwell: Dwell, record: DutyRecord) -> _Judged:
    """Judge how far a speed leaves its old reference away from the new one; arguments as in `overshoot_of_speed`.

    A regulator that bears the load when its reference changes bears it also afterwards.
    """
    away = -beyond - step if step > 0.0 else beyond + step
    farthest = max(float(np.max(away)), 0.0)
    measured = f"{farthest:.4g} rpm away from a reference {abs(step):.5g} rpm off after {dwell.start:.4g} s"
    allowed = ERROR_FACTOR * record.limits.speed_tolerance_rpm
    place = int(np.argmax(away))
    before, rows = dwell.speed_rpm - step, _around(record, dwell, place)
    limit = before - (allowed if step > 0.0 else -allowed)
    levels = ("reference before", before), (f"limit {limit:.5g} rpm", limit)
    shown = _Shown(rows, rows.start + place, f"{farthest:.4g} rpm away", levels, SHOWN_PERIODS)
    return Margin("ROB-4", at_most(farthest, allowed), measured), shown


def _sag(record: DutyRecord, dwell: Dwell) -> Iterator[_Judged]:
    """Judge how far a load that comes or goes alone takes a settled speed; None where none does.

    The slowest regulator that settles bears the load after its reaction time; until then the load moves the shaft. How
    stiff a drive is beyond that is its designer's choice.
    """
    scenario, document = record.scenario, record.document
    before = _settled_before(record, dwell)
    if before is None:
        return
    reference = dwell.speed_rpm * RADIANS_PER_RPM
    loads = [load_on_shaft(scenario, each, reference) for each in (before, dwell)]
    if before.speed_rpm != dwell.speed_rpm or loads[0] == loads[1]:
        return
    beyond = _beyond(record, dwell)
    place = int(np.argmax(np.abs(beyond)))
    sag = float(abs(beyond[place]))
    moved = abs(loads[1] - loads[0]) * reaction_s(document) / document.machine.inertia_kg_m2 / RADIANS_PER_RPM
    allowed = max(SAG_FACTOR * moved, ERROR_FACTOR * record.limits.speed_tolerance_rpm)
    measured = f"{sag:.4g} rpm off after a load step at {dwell.start:.4g} s, {allowed:.4g} rpm are allowed"
    limit = dwell.speed_rpm + (allowed if beyond[place] > 0.0 else -allowed)
    levels = ("reference", dwell.speed_rpm), (f"limit {limit:.5g} rpm", limit)
    rows = _around(record, dwell, place)
    shown = _Shown(rows, rows.start + place, f"{sag:.4g} rpm off", levels, SHOWN_PERIODS)
    yield Margin("ROB-4", at_most(sag, allowed), measured), shown


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
    beyond: NDArray[np.float64], step: float, start_s: float, drive: PmAcDocument, released_rpm: float = 0.0
) -> Margin:
    """Judge how far a speed goes beyond its reference, over the step that its regulator has to make.

    `beyond` is the speed without the reference (rpm), `step` the signed step of the reference (rpm). The regulator has
    to make more of it where a load takes the speed farther away first, and only the last part of one that it begins at
    the torque limit. What a steady speed may be off by is no overshoot, nor what a shaft that comes free runs away by
    (`released_rpm`, rpm).
    """
    ahead = beyond if step > 0.0 else -beyond
    made = _made_rpm(ahead, step, drive)
    over = max(float(np.max(ahead)), 0.0)
    allowed = max(allowed_overshoot_rpm(beyond, step, drive), released_rpm)
    share = f"{100.0 * over / made:.3g} % of the {made:.4g} rpm step that the regulator makes"
    measured = f"speed overshoots by {over:.4g} rpm, {share}, after the step at {start_s:.4g} s"
    return Margin("ROB-4", at_most(over, allowed), measured)


def _made_rpm(ahead: NDArray[np.float64], step: float, drive: PmAcDocument) -> float:
    """Return the step that a regulator has to make (rpm); `ahead` is the speed beyond its reference by its sign."""
    peak = int(np.argmax(ahead))
    return min(max(abs(step), -float(np.min(ahead[: peak + 1]))), regulated_rpm(drive))


def allowed_overshoot_rpm(beyond: NDArray[np.float64], step: float, drive: PmAcDocument) -> float:
    """Return the greatest overshoot that is allowed (rpm); arguments as in `overshoot_of_speed`."""
    limits = limits_of(drive)
    made = _made_rpm(beyond if step > 0.0 else -beyond, step, drive)
    return max(limits.speed_overshoot * made, ERROR_FACTOR * limits.speed_tolerance_rpm)


def regulated_rpm(drive: PmAcDocument) -> float:
    """Return the greatest step of the speed (rpm) that a regulator makes without the greatest torque of the drive.

    It is that of the slowest one that settles in time: its torque reaches the limit at the error that this torque
    makes up for in its reaction time.
    """
    torque = greatest_torque(drive.plant(), 0.0, drive.inverter.link_voltage_v, drive.weakens)
    return reaction_s(drive) * torque / drive.machine.inertia_kg_m2 / RADIANS_PER_RPM


def _swing(record: DutyRecord, window: DutyWindow) -> _Judged:
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
    begin = max(middle - 3 * half, 0)
    ends = [float(end) / RADIANS_PER_RPM for end in (np.min(parts[1]), np.max(parts[1]))]
    levels = tuple(
        (f"{words} of the last half", end) for words, end in zip(("least", "greatest"), ends, strict=True)
    )
    place, words = middle + int(np.argmax(parts[1])), f"swing {ends[1] - ends[0]:.4g} rpm"
    shown = _Shown(slice(begin, rows.stop), place, words, levels)
    return Margin("ROB-4", at_most(growth, record.limits.speed_swing_ratio), measured), shown


ROB_4 = Check(
    id="ROB-4",
    families=("parameter", "speed step", "reversal", "load step", "start"),
    requirement=(
        "The speed overshoots a step by at most {speed_overshoot} and leaves its old reference by at most 2 "
        "k1, a load moves it by at most 1.5 times what it does within the slowest reaction, and its swing "
        "grows by at most × {speed_swing_ratio}; on a plant that differs from the nameplate its mean is "
        "within 2 k1 of the reference."
    ),
    limit="overshoot {speed_overshoot}, swing × {speed_swing_ratio}, detour and on another plant speed error 2 k1, sag "
    "by a load 1.5 times that within the slowest reaction",
    scenarios="runs of a speed reference on the nominal drive, and with R × 0.5 to 2, L × 0.7 to 1.3, ψ × 0.8 to 1.05 "
    "and J × 0.3 to 2, also within a run, as of a wheel that is lifted and set down",
    formula="the least of 1 - overshoot / {speed_overshoot}, 1 - growth of the swing / {speed_swing_ratio}, 1 - detour "
    "/ 2 k1, 1 - sag / limit, and on another plant 1 - speed error / 2 k1",
    why="Loops above the speed rely on its response. Windings warm up, iron saturates, magnets age, loads have inertia "
    "of their own; the nameplate stays.",
    evaluate=speed_response,
    moment=speed_moment,
    # Without a sensor, SLS-4 and SLS-8 have limits of their own.
    reason_not_applicable=unless_sensed,
)
