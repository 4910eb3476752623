"""What a drive can do as a figure: torque, power, angle and ripple over speed."""

from __future__ import annotations

import io
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from drivegate.output.legend import legend_beside
from drivegate.studies.drive.pm_ac_figure import draw_plane_and_map
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Panels: TypeAlias = tuple[tuple[str, tuple[tuple[str, str, str, str], ...]], ...]
"""Labels, each with curves: key, name, style and colour."""

_PANELS: Final[Panels] = (
    (
        "torque (N·m)",
        (
            ("greatest_torque_nm", "at the current limit", "-", "tab:blue"),
            ("torque_without_advance_nm", "without advance", ":", "tab:blue"),
            ("rated_torque_nm", "of rated power", "--", "tab:gray"),
        ),
    ),
    (
        "power (W)",
        (
            ("greatest_power_w", "at the current limit", "-", "tab:blue"),
            ("input_power_w", "input at rated power", "-", "tab:orange"),
            ("rated_power_w", "rated", "--", "tab:gray"),
        ),
    ),
    (
        "angle (el. deg)",
        (
            ("line_deg", "recommended line", "-", "tab:green"),
            ("advance_deg", "least Σ|i|", "-", "tab:orange"),
            ("edge_deg", "feasible edge", "--", "tab:red"),
            ("greatest_torque_deg", "greatest torque", ":", "tab:blue"),
        ),
    ),
    ("torque ripple (%)", (("ripple_percent", "at least Σ|i|,\nideal regulator", "-", "tab:orange"),)),
)


_DUTY_PANELS: Final[Panels] = (
    (
        "torque (N·m)",
        (
            ("greatest_torque_nm", "within both limits", "-", "tab:blue"),
            ("rated_torque_nm", "of rated power", "--", "tab:gray"),
        ),
    ),
    (
        "power (W)",
        (
            ("greatest_power_w", "within both limits", "-", "tab:blue"),
            ("rated_power_w", "rated", "--", "tab:gray"),
        ),
    ),
    (
        "current (A)",
        (
            ("direct_a", "d, least current", "-", "tab:red"),
            ("quadrature_a", "q, least current", "-", "tab:orange"),
            ("least_loss_direct_a", "d, least loss", ":", "tab:red"),
            ("greatest_direct_a", "d, greatest torque", "--", "tab:blue"),
        ),
    ),
    (
        "loss (W)",
        (("loss_w", "at least current", "-", "tab:orange"), ("least_loss_w", "least", "--", "tab:green")),
    ),
)


def write_figure(document: dict[str, Any], plot: Path) -> None:
    """Draw what a drive can do; base and highest speed are marked."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    buffer = io.BytesIO()
    with rc_context({"text.parse_math": False, "svg.hashsalt": "drivegate", "svg.fonttype": "none"}):
        takes_duty = "undistorted_voltage_v" in document
        figure = Figure(figsize=(14.0 if takes_duty else 9.0, 9.0), layout="constrained")
        FigureCanvasAgg(figure)
        panels, part = _PANELS, figure
        if takes_duty:
            parts: Any = figure.subfigures(1, 2, width_ratios=(9.0, 5.0))
            panels, part = _DUTY_PANELS, parts[0]
            draw_plane_and_map(parts[1], document)
        all_axes = part.subplots(len(panels), 1, sharex=True)
        for axes, (label, curves) in zip(all_axes, panels, strict=True):
            _draw(axes, document, label, curves)
        all_axes[-1].set_xlabel("speed (rpm)")
        figure.suptitle(one_line(f"What {document['drive']} can do"))
        kind = plot.suffix.lower().removeprefix(".")
        figure.savefig(buffer, format=kind, dpi=120, metadata={"Date": None} if kind == "svg" else None)
    write_atomically(plot, buffer.getvalue())


def _draw(
    axes: Axes, document: dict[str, Any], label: str, curves: tuple[tuple[str, str, str, str], ...]
) -> None:
    for key, name, style, colour in curves:
        axes.plot(*_curve(document, key), style, label=name, color=colour, linewidth=1.3)
    for key in ("base_speed_rpm", "highest_speed_rpm"):
        axes.axvline(document["rating"][key], color="black", linewidth=0.6, alpha=0.4)
    axes.set_ylabel(label)
    axes.set_xlim(left=0.0)
    axes.grid(visible=True, alpha=0.3)
    legend_beside(axes)


def _curve(document: dict[str, Any], key: str) -> tuple[list[float], list[float]]:
    rating, points = document["rating"], document["points"]
    base = rating["base_speed_rpm"]
    speeds = [point["speed_rpm"] for point in points]
    if key == "rated_power_w":
        return speeds, [rating[key] * min(speed / base, 1.0) for speed in speeds]
    values = [nan if point[key] is None else point[key] for point in points]
    if key == "line_deg":
        # It jumps at base speed, which two speeds of the grid would draw as a slope.
        place = speeds.index(base)
        return [*speeds[:place], base, *speeds[place:]], [*values[:place], 0.0, *values[place:]]
    return speeds, values
