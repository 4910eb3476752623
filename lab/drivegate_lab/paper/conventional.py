"""What the paper states of conventional drives, beside stars of ours."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import Final

from drivegate_lab.paper.drives import (
    HIGHEST_PUBLISHED_RPM,
    WIDE_DEG,
    at_three_times_base_speed,
    compared_drives,
    constant_power_range,
    power_torque,
    reference_drive,
    ripple_percent,
    star,
)
from drivegate_lab.paper.figures.conventional_ripple_map import (
    PUBLISHED_PERCENT,
    ripple_map,
    widths_in_words,
)
from drivegate_lab.paper.kinds_of_drives import numbers_of_kinds
from drivegate_lab.paper.verdicts import ComparedStatement, Number, Verdict
from drivegate_models.steady.oracle import TorquePoint, point_at_torque
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import signed

SIGN_ANGLE_DEG: Final = 60.0
"""Angle at which a star of small inductance is looked at (electrical deg)."""
SIGN_SHARE: Final = 0.25
"""Its inductance, as a share of the packaged star's (1)."""

_SURFACE: Final = ("ripple of a surface-magnet drive", "their data are not in the paper")
_INSET: Final = (
    "ripple of an inset-magnet drive",
    "their data are not in the paper, and saliency is not modelled: these are of surface magnets",
)


def _ripple(percent: float, quantity: str, reason: str) -> ComparedStatement:
    _, *stars, _ = at_three_times_base_speed()
    low, high = sorted(one.ripple_percent for one in stars)
    data = ripple_map()
    within, further = (widths_in_words(data, one.as_published) for one in (data.necessary, data.further))
    reached = data.necessary.as_published.any() or data.further.as_published.any()
    return ComparedStatement(
        fact="P9",
        quantity=quantity,
        published=f"{percent:g} %",
        ours=f"{low:.0f} to {high:.0f} %",
        verdict=_in_kind(bool(reached)),
        note=f"a conventional star of the same iron and copper, its EMF flat over 120 to {WIDE_DEG:g}°, at 1.5 kW, "
        f"{data.speed_rpm:g} rpm and the least Σ|i|; {_published_range()} lies {within} at the smallest angle that "
        f"gives the power, {data.further.further_deg:g}° further on {further}. The size depends on EMF width, "
        f"inductance and angle of the cited machines; {reason}",
        numbers=(
            Number("published", percent, "%"),
            Number("ripple with the narrower EMF", low, "%"),
            Number("ripple with the wider EMF", high, "%"),
        ),
    )


def _published_range() -> str:
    return f"{PUBLISHED_PERCENT[0]:g} to {PUBLISHED_PERCENT[1]:g} %"


def _in_kind(holds: bool) -> Verdict:
    return "reproduced in kind" if holds else "not reproduced"


@cache
def _advanced_star() -> TorquePoint:
    """Compute a star of small inductance and wide EMF, well above the smallest angle that gives rated power."""
    plain = star()
    drive = star(emf_flat_deg=WIDE_DEG, inductance_h=SIGN_SHARE * plain.machine.inductance_h).plant()
    torque = power_torque(HIGHEST_PUBLISHED_RPM, plain.rating.rated_power_w)
    return point_at_torque(
        drive, HIGHEST_PUBLISHED_RPM * RADIANS_PER_RPM, math.radians(SIGN_ANGLE_DEG), torque
    )


def _changes_sign() -> ComparedStatement:
    point, data = _advanced_star(), ripple_map()
    changes = data.necessary.changes_sign.any() or data.further.changes_sign.any()
    necessary, further = (widths_in_words(data, one.changes_sign) for one in (data.necessary, data.further))
    narrow, wide = (one.point.torque_lowest for one in at_three_times_base_speed()[1:3])
    return ComparedStatement(
        fact="P9",
        quantity="torque of these drives under phase advance",
        published="changes its sign",
        ours=f"{_extremes(point)} at {SIGN_ANGLE_DEG:g}°, with an EMF flat over {WIDE_DEG:g}° and {SIGN_SHARE:g} of "
        "the inductance",
        verdict=_in_kind(bool(changes)),
        note=f"it changes its sign {necessary} at the smallest angle that gives the power, "
        f"{data.further.further_deg:g}° further on {further}; at their least Σ|i| the stars above stay at "
        f"{narrow:.1f} and {wide:.1f} N·m or more",
        numbers=(
            Number("least torque", point.torque_lowest, "N·m"),
            Number("greatest torque", point.torque_highest, "N·m"),
            Number("ripple", ripple_percent(point), "%"),
        ),
    )


def _less_ripple() -> ComparedStatement:
    five, *stars, _ = at_three_times_base_speed()
    low, high = sorted(one.ripple_percent for one in stars)
    return ComparedStatement(
        fact="P9",
        quantity="ripple of the 5-phase drive against theirs",
        published="considerably less",
        ours=f"{five.ripple_percent:.0f} % against {low:.0f} to {high:.0f} %",
        verdict="reproduced" if five.ripple_percent < 0.5 * low else "not reproduced",
        note="both at 1.5 kW, 1500 rpm and the least Σ|i|; a star with windows of 150° has as little (finding F8)",
        numbers=(
            Number("ripple of the 5-phase drive", five.ripple_percent, "%"),
            Number("least ripple of the stars", low, "%"),
        ),
    )


def _extremes(point: TorquePoint) -> str:
    return f"{signed(point.torque_lowest, 1).removeprefix('+')} to {point.torque_highest:.1f} N·m"


def _star_with_wide_windows() -> list[tuple[str, str]]:
    five, plain, _, wide = zip(compared_drives(), at_three_times_base_speed(), strict=True)
    speed, power = HIGHEST_PUBLISHED_RPM, reference_drive().rating.rated_power_w / 1000.0
    rows = [
        (
            f"{drive.name}, {power:g} kW at {speed:.0f} rpm",
            f"{one.advance_deg:.1f}°, Σ|i| {one.point.current_sum:.1f} A, ripple {one.ripple_percent:.1f} %, "
            f"copper {one.point.copper_loss:.1f} W",
        )
        for drive, one in (five, plain, wide)
    ]
    reached = [
        f"{drive.name}: {constant_power_range(drive.document)[1]:.0f} rpm" for drive, _ in (five, plain, wide)
    ]
    return [*rows, (f"{power:g} kW up to, of 6000 rpm at most", "; ".join(reached))]


CONVENTIONAL: Final[Mapping[str, tuple[Callable[[], ComparedStatement], ...]]] = {
    "P9": (
        lambda: _ripple(PUBLISHED_PERCENT[1], *_SURFACE),
        lambda: _ripple(PUBLISHED_PERCENT[0], *_INSET),
        _changes_sign,
        _less_ripple,
    ),
}
"""What is compared on conventional drives, by fact; apart, since it takes the plant of another kind of drive."""

CONVENTIONAL_NUMBERS: Final[Mapping[str, Callable[[], list[tuple[str, str]]]]] = {
    "F8": _star_with_wide_windows,
    "F9": numbers_of_kinds,
}
"""Numbers of the findings on other kinds of drives."""
