"""Checks of the torque ripple: at the published worst point, over constant power, and with the band."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check, ReasonNotApplicable, StateMoment
from drivegate.checks.course import course_of
from drivegate.checks.margin import Margin, Mark, Moment, Point, below, worst_required
from drivegate.contracts.current.checks.constant_power import is_in
from drivegate.contracts.current.checks.convergence import ABOVE_BASE_SPEED, LOADED, described
from drivegate.contracts.current.checks.declared_speeds import constant_power, required_points, unless_speeds
from drivegate.contracts.current.checks.shown import cycle_moment, decisive
from drivegate.contracts.current.record import CurrentRecord, SteadyWindow, rated_torque
from drivegate_cases.documents.wording import figure
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.requirements import points_of
from drivegate_models.steady.oracle import TorquePoint, point_at_torque
from drivegate_models.steady.waveform import periodic_waveforms

_ROUNDING = 1e-6
# A candidate may rest on the feasible edge itself, where its means hold a torque that is out of reach by rounding.
_EDGE = 1e-3


def _is_required_point(window: SteadyWindow) -> bool:
    return window.has_nominal_supply and any(
        window.dwell.speed_rpm == point.speed_rpm
        and math.isclose(window.torque_required, point.torque_n_m, rel_tol=1e-9)
        for point in points_of(window.scenario.drive)
    )


def _is_constant_power(window: SteadyWindow) -> bool:
    return is_in(constant_power, window) and window.requires_rated_power


def _ideal_ripple(
    check: str, record: CurrentRecord, is_judged: Callable[[SteadyWindow], bool]
) -> Margin | None:
    """Return the worst margin of the steady states with the ideal regulator at the angles converged to."""
    if math.isinf(limits_of(record.scenario.drive).ripple):
        return None
    windows = filter(is_judged, record.nominal_windows())
    margins = [_ideal_margin(check, record, window) for window in windows]
    return min(margins, key=lambda margin: margin.value, default=None)


def _ideal_point(record: CurrentRecord, window: SteadyWindow) -> TorquePoint:
    """Return the steady state with the ideal regulator at the mean angle and the mean torque of a window."""
    ideal, torque = record.drive._replace(hysteresis_band=0.0), window.values.torque
    place = min(max(window.values.angle, 0.0), math.pi / 2.0)
    point = point_at_torque(ideal, window.speed, place, torque)
    if not point.static:
        point = point_at_torque(ideal, window.speed, place, (1.0 - _EDGE) * torque)
    if not point.static:
        # A band may hold a torque that is out of the ideal regulator's reach.
        point = point_at_torque(record.drive, window.speed, place, torque)
    return point


def _ideal_margin(check: str, record: CurrentRecord, window: SteadyWindow) -> Margin:
    angle, torque = window.values.angle, window.values.torque
    where = f"at {math.degrees(angle):.2f}°, {figure(window.dwell.speed_rpm)} rpm and {torque:.3g} N·m"
    point = _ideal_point(record, window)
    if not point.static or torque <= 0.0:
        return Margin(check, -1.0, f"the torque is out of reach {where}")
    ripple = (point.torque_highest - point.torque_lowest) / point.torque
    return Margin(
        check, below(ripple, limits_of(record.scenario.drive).ripple), f"{100.0 * ripple:.2f} % {where}"
    )


def ripple_at_converged_angle(record: CurrentRecord) -> Margin | None:
    """Judge the torque ripple at the angle that the candidate converged to at the required points (Fig. 6).

    The ripple is that of the periodic steady state with the ideal regulator (no band) at the candidate's mean
    angle and mean torque; its extremes are exact.
    """
    return _ideal_ripple("RIP-1", record, _is_required_point)


def ripple_at_constant_power(record: CurrentRecord) -> Margin | None:
    """Judge the torque ripple at the angle that the candidate converged to under rated power (Fig. 6)."""
    return _ideal_ripple("RIP-2", record, _is_constant_power)


def closed_loop_ripple(record: CurrentRecord) -> Margin | None:
    """Judge the torque ripple of the closed loop, with hysteresis band and speed regulator."""
    if math.isinf(limits_of(record.scenario.drive).closed_loop_ripple):
        return None
    loaded = (window for window in record.nominal_windows() if window.torque_required > 0.0)
    return worst_required(list(map(_closed_loop_margin, loaded)))


def closed_loop_moment(record: CurrentRecord) -> Moment | None:
    """Show the torque in the electrical period with the most ripple."""
    limit = limits_of(record.scenario.drive).closed_loop_ripple
    loaded = (window for window in record.nominal_windows() if window.torque_required > 0.0)
    window = decisive((window, _closed_loop_margin(window)) for window in loaded)
    if window is None or math.isinf(limit):
        return None
    return cycle_moment(record, window, f"ripple {100.0 * window.values.ripple:.3g} %", limit)


def _ideal_moment(is_judged: Callable[[SteadyWindow], bool]) -> StateMoment:
    """Show the torque of the ideal regulator over one electrical period, at the angle of the window that decides."""

    def moment(record: CurrentRecord) -> Moment | None:
        windows = filter(is_judged, record.nominal_windows())
        judged = [(window, _ideal_margin("", record, window)) for window in windows]
        window = decisive(judged)
        point = None if window is None else _ideal_point(record, window)
        if window is None or point is None or not point.static or point.torque <= 0.0:
            return None
        place = min(max(window.values.angle, 0.0), math.pi / 2.0)
        ideal = record.drive._replace(hysteresis_band=0.0)
        waves = periodic_waveforms(ideal, window.speed, point.reference, place)
        begin = window.dwell.end - waves.cycle
        least, greatest = float(np.min(waves.torque)), int(np.argmax(waves.torque))
        allowed = limits_of(record.scenario.drive).ripple * point.torque
        ripple = (point.torque_highest - point.torque_lowest) / point.torque
        return Moment(
            start_s=begin,
            end_s=window.dwell.end,
            quantity="torque, ideal regulator (N·m)",
            courses=(course_of("torque", begin + waves.times, waves.torque),),
            levels=(
                Mark(words="least", value=least),
                Mark(words=f"limit {least + allowed:.4g} N·m", value=least + allowed),
            ),
            point=Point(
                words=f"ripple {100.0 * ripple:.2f} %",
                time_s=begin + float(waves.times[greatest]),
                value=float(waves.torque[greatest]),
            ),
        )

    return moment


def _closed_loop_margin(window: SteadyWindow) -> Margin:
    rated = rated_torque(window.scenario, window.speed)
    ripple = window.values.ripple
    one_sided = window.values.ripple_one_sided
    measured = f"{100.0 * ripple:.3g} %, one-sided {100.0 * one_sided:.3g} %{described(window)}"
    light = window.torque_required < rated * (1.0 - _ROUNDING)
    limit = limits_of(window.scenario.drive).closed_loop_ripple
    return Margin("RIP-3", below(ripple, limit), measured, advisory=light)


def _where_limited(name: str, otherwise: ReasonNotApplicable) -> ReasonNotApplicable:
    """Let a check apply unless its drive states no such limit, or for another reason."""

    def reason(declaration: Declaration, drive: DriveDocument) -> str | None:
        if math.isinf(getattr(limits_of(drive), name)):
            return f"this drive states no requirements.{name}_percent; drivegate drive prints what can be met"
        return otherwise(declaration, drive)

    return reason


RIP_1 = Check(
    id="RIP-1",
    families=("required point",),
    requirement="Torque ripple at {points}, ideal regulator, at the angle that the candidate converged to.",
    source="P8",
    limit="{ripple} peak to peak over mean",
    scenarios="steady stretches of {stretch} or more at {points}, on the nominal drive",
    formula="1 - ripple / {ripple}, ripple = (max - min) / mean torque of one electrical period",
    why="The paper gives less than 13 % there, and calls it the worst case of the whole speed range.",
    evaluate=ripple_at_converged_angle,
    moment=_ideal_moment(_is_required_point),
    reason_not_applicable=_where_limited("ripple", unless_speeds(required_points)),
)
RIP_2 = Check(
    id="RIP-2",
    families=("constant power",),
    requirement=(
        "Torque ripple at every speed from {lowest} to {highest} at {power}, ideal regulator, at the angle that the "
        "candidate converged to."
    ),
    source="P8",
    level="advisory",
    limit="{ripple} peak to peak over mean",
    scenarios=(
        "every steady stretch of {stretch} or more that requires {power} from {lowest} to {highest}, on the nominal "
        "drive"
    ),
    formula="as RIP-1",
    why="The paper's bound holds for the whole speed range; the calibrated motor itself comes close to it.",
    evaluate=ripple_at_constant_power,
    moment=_ideal_moment(_is_constant_power),
    reason_not_applicable=_where_limited("ripple", unless_speeds(constant_power)),
)
RIP_3 = Check(
    id="RIP-3",
    families=(*LOADED, "vehicle"),
    requirement=(
        "Torque ripple of the closed loop, with band and speed regulator, in the worst electrical period of 1 s."
    ),
    source="P8, P9",
    level="advisory",
    limit="{closed_loop_ripple} peak to peak over mean",
    scenarios=(
        "every loaded steady stretch of {stretch} or more above base speed, on the nominal drive; those with less than "
        "the torque of {power} decide nothing"
    ),
    formula="1 - ripple / {closed_loop_ripple}, ripple = (max - min) / mean torque of the worst electrical period",
    why="A band and a regulator that dithers across the feasible edge add to the ripple of the angle.",
    evaluate=closed_loop_ripple,
    moment=closed_loop_moment,
    reason_not_applicable=_where_limited("closed_loop_ripple", ABOVE_BASE_SPEED),
)
