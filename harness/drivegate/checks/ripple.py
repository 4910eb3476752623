"""Checks of the torque ripple: at the published worst point, over constant power, and with the band."""

from __future__ import annotations

import math

from drivegate.checks.check import Check
from drivegate.checks.constant_power import HIGHEST_RPM, LOWEST_RPM
from drivegate.checks.convergence import ABOVE_BASE_SPEED, described
from drivegate.checks.declared_speeds import unless_speeds_from
from drivegate.checks.margin import Margin, below, worst_required
from drivegate.runs.record import RunRecord, SteadyWindow, rated_torque
from drivegate_cases.scenario.circumstance import Circumstance
from drivegate_models.half_bridge.steady.oracle import point_at_torque

LARGEST_RIPPLE = 0.13
"""Limit of the peak-to-peak ripple over the mean torque (paper, Fig. 6)."""
LARGEST_CLOSED_LOOP_RIPPLE = 0.20
"""The same with hysteresis band and speed regulator."""
RIPPLE_SPEED_RPM = 1500.0
"""Speed of the published point (rpm)."""
RIPPLE_TORQUE_NM = 9.8
"""Torque of the published point (N m)."""
_ROUNDING = 1e-6


def _is_published_point(window: SteadyWindow) -> bool:
    at_speed = window.dwell.speed_rpm == RIPPLE_SPEED_RPM and window.has_nominal_supply
    return at_speed and math.isclose(window.torque_required, RIPPLE_TORQUE_NM, rel_tol=1e-9)


def _is_constant_power(window: SteadyWindow) -> bool:
    return LOWEST_RPM <= window.dwell.speed_rpm <= HIGHEST_RPM and window.requires_rated_power


def _ideal_ripple(check: str, record: RunRecord, windows: list[SteadyWindow]) -> Margin | None:
    """Return the worst margin of the steady states with the ideal regulator at the angles converged to."""
    ideal = record.drive._replace(hysteresis_band=0.0)
    margins = []
    for window in windows:
        angle = window.values.angle
        torque = window.values.torque
        where = f"at {math.degrees(angle):.2f}°, {window.dwell.speed_rpm:.4g} rpm and {torque:.3g} N·m"
        point = point_at_torque(ideal, window.speed, min(max(angle, 0.0), math.pi / 2.0), torque)
        if not point.static or torque <= 0.0:
            margins.append(Margin(check, -1.0, f"the torque is out of reach {where}"))
            continue
        ripple = (point.torque_highest - point.torque_lowest) / point.torque
        margins.append(Margin(check, below(ripple, LARGEST_RIPPLE), f"{100.0 * ripple:.2f} % {where}"))
    return min(margins, key=lambda margin: margin.value, default=None)


def ripple_at_converged_angle(record: RunRecord) -> Margin | None:
    """Judge the torque ripple at the angle that the candidate converged to at the published point (Fig. 6).

    The ripple is that of the periodic steady state with the ideal regulator (no band) at the candidate's mean
    angle and mean torque; its extremes are exact.
    """
    if record.circumstance is not Circumstance.NOMINAL:
        return None
    return _ideal_ripple("RIP-1", record, [w for w in record.windows() if _is_published_point(w)])


def ripple_at_constant_power(record: RunRecord) -> Margin | None:
    """Judge the torque ripple at the angle that the candidate converged to under rated power (Fig. 6)."""
    if record.circumstance is not Circumstance.NOMINAL:
        return None
    return _ideal_ripple("RIP-2", record, [w for w in record.windows() if _is_constant_power(w)])


def closed_loop_ripple(record: RunRecord) -> Margin | None:
    """Judge the torque ripple of the closed loop, with hysteresis band and speed regulator."""
    if record.circumstance is not Circumstance.NOMINAL:
        return None
    margins = [_closed_loop_margin(window) for window in record.windows() if window.torque_required > 0.0]
    return worst_required(margins)


def _closed_loop_margin(window: SteadyWindow) -> Margin:
    rated = rated_torque(window.scenario, window.speed)
    ripple = window.values.ripple
    one_sided = window.values.ripple_one_sided
    measured = f"{100.0 * ripple:.3g} %, one-sided {100.0 * one_sided:.3g} %{described(window)}"
    light = window.torque_required < rated * (1.0 - _ROUNDING)
    return Margin("RIP-3", below(ripple, LARGEST_CLOSED_LOOP_RIPPLE), measured, advisory=light)


RIP_1 = Check(
    id="RIP-1",
    requirement="Torque ripple at 1500 rpm and 9.8 N·m, ideal regulator, at the angle that the candidate converged to.",
    source="P8",
    subject="candidate",
    level="required",
    limit="13 % peak to peak over mean",
    scenarios="steady stretches of 9 s or more at the published point, 1500 rpm and 9.8 N·m, on the nominal drive",
    formula="1 - ripple / 13 %, ripple = (max - min) / mean torque of one electrical period",
    why="The paper gives less than 13 % there, and calls it the worst case of the whole speed range.",
    evaluate=ripple_at_converged_angle,
    reason_not_applicable=unless_speeds_from(RIPPLE_SPEED_RPM, RIPPLE_SPEED_RPM),
)
RIP_2 = Check(
    id="RIP-2",
    requirement=(
        "Torque ripple at every speed from 550 to 1500 rpm at 1.5 kW, ideal regulator, at the angle that the "
        "candidate converged to."
    ),
    source="P8",
    subject="candidate",
    level="advisory",
    limit="13 % peak to peak over mean",
    scenarios="every steady stretch of 9 s or more that requires 1.5 kW from 550 to 1500 rpm, on the nominal drive",
    formula="as RIP-1",
    why="The paper's bound holds for the whole speed range; the calibrated motor itself comes close to it.",
    evaluate=ripple_at_constant_power,
    reason_not_applicable=unless_speeds_from(LOWEST_RPM, HIGHEST_RPM),
)
RIP_3 = Check(
    id="RIP-3",
    requirement=(
        "Torque ripple of the closed loop, with band and speed regulator, in the worst electrical period of 1 s."
    ),
    source="P8, P9",
    subject="candidate",
    level="advisory",
    limit="20 % peak to peak over mean",
    scenarios=(
        "every loaded steady stretch of 9 s or more above base speed, on the nominal drive; those with less than the "
        "torque of 1.5 kW decide nothing"
    ),
    formula="1 - ripple / 20 %, ripple = (max - min) / mean torque of the worst electrical period",
    why="A band and a regulator that dithers across the feasible edge add to the ripple of the angle.",
    evaluate=closed_loop_ripple,
    reason_not_applicable=ABOVE_BASE_SPEED,
)
