"""The phase-decoupled machine on half-bridge legs, at a split supply."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from drivegate.drives.outer_loop_kind import outer_loop_kind

if TYPE_CHECKING:
    from drivegate.runs.scenario import PrepareLoop


def _prepare_loop() -> PrepareLoop:
    from drivegate_models.half_bridge.closed_loop import prepared_loop

    return prepared_loop


HALF_BRIDGE: Final = outer_loop_kind("half-bridge", "paper-5-phase", _prepare_loop, compiling_s=33)
"""The drive of the paper."""
