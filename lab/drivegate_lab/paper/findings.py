"""The findings that qualify the paper, each with the numbers that the models give now."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from drivegate.drives.constant_power import last_met
from drivegate_cases.publication import Finding, findings
from drivegate_lab.paper.drives import banded_drive, ideal_drive, power_torque, reference_drive
from drivegate_lab.paper.figures.search_trajectory import search_trajectory
from drivegate_lab.paper.statements import out_of_reach_rpm
from drivegate_models.steady.oracle import current_sum_curve, feasible_edge, point_at_torque
from drivegate_models.steady.steady_state import steady_state
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import signed

EDGE_SPEEDS_RPM: Final = (550.0, 700.0, 1000.0, 1200.0, 1400.0, 1500.0, 2000.0)
"""Speeds at which the feasible edge of 1.5 kW is reported."""
# From 200 rpm down to a tenth.
_HALVINGS: Final = 11


@dataclass(frozen=True)
class RecomputedFinding:
    """A finding, with numbers from the models as they are."""

    finding: Finding
    """Title, statement, and the facts and checks that it bears on."""
    numbers: tuple[tuple[str, str], ...]
    """What is computed, and its value with its unit."""


@cache
def recomputed_findings() -> tuple[RecomputedFinding, ...]:
    """Compute the numbers of every finding again."""
    return tuple(RecomputedFinding(finding, tuple(_NUMBERS[finding.id]())) for finding in findings())


_Numbers = list[tuple[str, str]]


def _rated_power_at_base() -> _Numbers:
    drive = reference_drive()
    base, limit = drive.rating.base_speed_rpm, drive.rating.current_limit_a
    unadvanced = steady_state(ideal_drive(), base * RADIANS_PER_RPM, limit, 0.0).torque
    edge = feasible_edge(
        ideal_drive(), base * RADIANS_PER_RPM, power_torque(base, drive.rating.rated_power_w)
    )
    required = power_torque(550.0, drive.rating.rated_power_w)

    def is_enough(speed_rpm: float) -> bool:
        torque = steady_state(ideal_drive(), speed_rpm * RADIANS_PER_RPM, limit, 0.0).torque
        return bool(torque >= required)

    enough = last_met(is_enough, 300.0, base, _HALVINGS)
    return [
        (f"torque at 0°, {limit:g} A and {base:g} rpm", f"{unadvanced:.1f} N·m"),
        (f"rated torque at {base:g} rpm", f"{power_torque(base, drive.rating.rated_power_w):.2f} N·m"),
        ("smallest angle for rated power there", f"{math.degrees(edge):.1f}°"),
        ("torque of 1.5 kW at 550 rpm", f"{required:.1f} N·m"),
        ("0° gives that much up to", f"{enough:.0f} rpm"),
    ]


def _published_line() -> _Numbers:
    start, end = out_of_reach_rpm()
    edges = [
        math.degrees(
            feasible_edge(
                ideal_drive(),
                speed * RADIANS_PER_RPM,
                power_torque(speed, reference_drive().rating.rated_power_w),
            )
        )
        for speed in EDGE_SPEEDS_RPM
    ]
    listed = ", ".join(
        f"{edge:.1f}° at {speed:.0f} rpm" for speed, edge in zip(EDGE_SPEEDS_RPM, edges, strict=True)
    )
    return [
        ("1.5 kW out of reach along the published line", f"from {start:.0f} to {end:.0f} rpm"),
        ("feasible edge of 1.5 kW", listed),
    ]


def _exchanged_power() -> _Numbers:
    drive = ideal_drive()
    near, far = (
        point_at_torque(drive, 1500.0 * RADIANS_PER_RPM, math.radians(angle), 9.8) for angle in (52.5, 58.0)
    )
    return [
        ("exchanged power at 1500 rpm, 9.8 N·m, 52.5°", f"{near.exchanged_power:.0f} W"),
        ("net input power there", f"{near.input_power:.0f} W"),
        ("Σ|i| from 58° to 52.5°", f"{signed(100.0 * (near.current_sum / far.current_sum - 1.0), 1)} %"),
        (
            "net input power from 58° to 52.5°",
            f"{signed(100.0 * (near.input_power / far.input_power - 1.0), 1)} %",
        ),
    ]


def _lock_up() -> _Numbers:
    data = search_trajectory()
    lost = data.published
    return [
        (
            f"speed error of `published` after {lost.time_s[-1]:.0f} s",
            f"{signed(lost.speed_error_rpm[-1], 0)} rpm",
        ),
        ("its current reference", f"{lost.current_reference_a[-1]:.1f} A of {data.current_limit_a:g} A"),
        ("its angle", f"{lost.advance_deg[-1]:.1f}°, the feasible edge is {data.optimum_deg:.1f}°"),
        ("speed error of `reference`", f"{signed(data.reference.speed_error_rpm[-1], 1)} rpm"),
    ]


def _torque_jumps() -> _Numbers:
    references = np.arange(9.0, 13.0, 0.01)
    speed, advance = 1500.0 * RADIANS_PER_RPM, math.radians(52.7)
    torques = np.array([steady_state(banded_drive(), speed, float(i), advance).torque for i in references])
    jump = int(np.argmax(np.diff(torques)))
    return [
        (
            f"greatest jump of torque at 1500 rpm, 52.7°, near {references[jump]:.2f} A",
            f"from {torques[jump]:.2f} to {torques[jump + 1]:.2f} N·m",
        )
    ]


def local_minima(share: float) -> int:
    """Count the minima of the current sum over the angle at 1500 rpm."""
    speed_rpm = 1500.0
    torque = share * power_torque(speed_rpm, reference_drive().rating.rated_power_w)
    angles = np.radians(np.arange(0.0, 90.01, 0.5))
    curve = current_sum_curve(banded_drive(), speed_rpm * RADIANS_PER_RPM, torque, angles).current_sum
    walled = np.concatenate([[np.inf], np.where(np.isfinite(curve), curve, np.inf), [np.inf]])
    inner = walled[1:-1]
    return int(np.count_nonzero((inner < walled[:-2]) & (inner <= walled[2:])))


def _light_load() -> _Numbers:
    return [
        (f"minima of Σ|i| over the angle at {share:.0%} of 1.5 kW, 1500 rpm", str(local_minima(share)))
        for share in (0.1, 0.3, 1.0)
    ]


def _emf_meets_supply() -> _Numbers:
    drive = ideal_drive()
    speed = drive.half_supply_voltage / drive.emf_constant / RADIANS_PER_RPM
    return [(f"peak EMF reaches {drive.half_supply_voltage:g} V at", f"{speed:.0f} rpm")]


_NUMBERS: Final[Mapping[str, Callable[[], _Numbers]]] = {
    "F1": _rated_power_at_base,
    "F2": _published_line,
    "F3": _exchanged_power,
    "F4": _lock_up,
    "F5": _torque_jumps,
    "F6": _light_load,
    "F7": _emf_meets_supply,
}
