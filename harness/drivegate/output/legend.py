"""The legend of a panel, where it hides no trace."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def side_legend(axes: Axes) -> None:
    """Put the legend to the right of a panel; to be used where the layout is constrained."""
    axes.legend(
        loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0, frameon=False, fontsize="small"
    )
