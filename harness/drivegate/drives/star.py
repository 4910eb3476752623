"""The star-connected machine with an isolated neutral on half-bridge legs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from drivegate.drives.outer_loop_kind import outer_loop_kind

if TYPE_CHECKING:
    from drivegate.runs.scenario import PrepareLoop


def _prepare_loop() -> PrepareLoop:
    from drivegate_models.star.closed_loop import prepared_loop

    return prepared_loop


STAR: Final = outer_loop_kind("star", "star-3-phase", _prepare_loop, compiling_s=60)
"""Conventional brushless DC drives, which the paper sets its own against."""
