"""The panel with the deciding moment of a run."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle
from textwrap import fill
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.margin import Moment
from drivegate.contracts.contract import Columns
from drivegate.contracts.drawings import TIME, Panel
from drivegate_cases.documents.wording import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe and Ito, "Color Universal Design": distinguishable with any colour vision.
_SIGNALS: Final = ("#0072B2", "#009E73", "#56B4E9", "#CC79A7")
_LIMIT: Final = "#D55E00"
_LIMIT_INK: Final = "#A34700"
_DASHED: Final = (0, (4, 3))
_MOST_TREADS: Final = 150
_SECONDS_FROM: Final = 5.0
_WITH_LABELS: Final = 1.32
_LABELS_AT: Final = 1.012
_WIDEST_LABEL: Final = 26
"""Longest line of a label (characters)."""


class MomentTime:
    """The axis of time of a moment: from its origin on, in milliseconds where it is short."""

    def __init__(self, moment: Moment) -> None:
        self.start, self.end = moment.start_s, moment.end_s
        self.origin = moment.start_s if moment.origin_s is None else moment.origin_s
        is_long = self.end - self.start > _SECONDS_FROM
        self.factor, self.unit = (1.0, "s") if is_long else (1e3, "ms")

    @property
    def label(self) -> str:
        return f"time after {self.origin:.6g} s ({self.unit})"

    def of(self, time: float) -> float:
        """Convert a time of the run (s) to the axis."""
        return float(self.factor * (time - self.origin))

    def apply(self, axes: Axes) -> None:
        """Limit an axis to the moment, with room for labels at its end."""
        begin, end = self.of(self.start), self.of(self.end)
        axes.set_xlim(begin, begin + _WITH_LABELS * (end - begin))
        axes.set_xticks([tick for tick in axes.get_xticks() if begin <= tick <= end + 1e-3 * (end - begin)])

    @property
    def labels_at(self) -> float:
        """Where labels of lines begin."""
        begin, end = self.of(self.start), self.of(self.end)
        return begin + _LABELS_AT * (end - begin)


def draw_moment(axes: Axes, moment: Moment, columns: Columns, panels: tuple[Panel, ...]) -> None:
    """Draw the column that decides, with everything that its check marks."""
    axis = MomentTime(moment)
    for words, time, values, colour in _lines(moment, columns):
        # A control period is drawn as what it is: one value for its whole length.
        style = "steps-post" if len(values) <= _MOST_TREADS else "default"
        shown = axis.factor * (time - axis.origin)
        axes.plot(shown, values, color=colour, linewidth=1.5, drawstyle=style, label=words)
    begin, end = axis.of(moment.start_s), axis.of(moment.end_s)
    for level in moment.levels:
        axes.plot([begin, end], [level.value] * 2, color=_LIMIT, linewidth=1.0, linestyle=_DASHED)
    for instant in moment.instants:
        axes.axvline(axis.of(instant.value), color=_LIMIT, linewidth=1.0, linestyle=_DASHED)
    axes.margins(y=0.12)
    axis.apply(axes)
    _label(axes, axis, moment)
    if len(moment.courses) > 1:
        axes.legend(loc="upper left", fontsize=8.0, frameon=False, ncols=2)
    axes.set_xlabel(axis.label)
    axes.set_ylabel(moment.quantity or quantity_of(moment.column, panels))
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.grid(visible=True, alpha=0.4)


def _lines(
    moment: Moment, columns: Columns
) -> Iterator[tuple[str, NDArray[np.float64], NDArray[np.float64], str]]:
    """List what is drawn: words, times (s), values and colour of each line."""
    for course, colour in zip(moment.courses, cycle(_SIGNALS)):
        yield one_line(course.words), np.array(course.time_s), np.array(course.values), colour
    if not moment.courses:
        rows = (columns[TIME] >= moment.start_s) & (columns[TIME] <= moment.end_s)
        yield "", columns[TIME][rows], columns[moment.column][rows], _SIGNALS[0]


def _label(axes: Axes, axis: MomentTime, moment: Moment) -> None:
    lines = {level.value: one_line(level.words) for level in moment.levels}
    point = moment.point
    if point is not None:
        place = axis.of(point.time_s), point.value
        axes.plot(
            *place, marker="o", markersize=7, markerfacecolor="none", markeredgecolor=_LIMIT_INK, zorder=5
        )
        leader = [place[0], axis.of(axis.end)]
        axes.plot(leader, [point.value] * 2, color=_LIMIT_INK, linewidth=0.8, linestyle=":")
        words = f"measured {one_line(point.words)}"
        lines[point.value] = f"{lines[point.value]}: {words}" if point.value in lines else words
    low, high = axes.get_ylim()
    gap, last = 0.1 * (high - low), -np.inf
    for value, words in sorted(lines.items()):
        shown = fill(words, _WIDEST_LABEL)
        last = max(value, last + gap)
        axes.text(axis.labels_at, last, shown, color=_LIMIT_INK, fontsize=8.5, va="center")
        last += gap * shown.count("\n")
    for instant in moment.instants:
        axes.text(
            axis.of(instant.value),
            1.01,
            one_line(instant.words),
            color=_LIMIT_INK,
            fontsize=8.5,
            ha="center",
            transform=axes.get_xaxis_transform(),
        )


def quantity_of(column: str, panels: tuple[Panel, ...]) -> str:
    """Name a column and its unit, as the panel that has it does."""
    for label, lines in panels:
        for line in lines:
            if line.column == column:
                return label if line.name in label else f"{line.name} {label}"
    return column
