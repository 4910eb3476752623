"""Where in a run of a controller of duty ratios the verdict of a check comes from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin
from drivegate.contracts.duty.record import DutyRecord, DutyWindow


@dataclass(frozen=True)
class _PartialRecord(DutyRecord):
    """A run of which only some of the steady stretches are shown."""

    shown: tuple[DutyWindow, ...] = ()
    """These stretches."""

    @cached_property
    def steady(self) -> tuple[DutyWindow, ...]:
        return self.shown


def judged_window(check: Check, record: DutyRecord, margin: Margin | None) -> tuple[float, float]:
    """Find the steady stretch that alone gives the same margin; the whole run where none decides."""
    whole = (0.0, record.scenario.duration_s)
    if margin is None or check.evaluate(_part(record)) is not None:
        return whole
    for window in record.steady:
        alone = check.evaluate(_part(record, window))
        if alone is not None and alone.value == margin.value:
            return window.start_s, window.end_s
    return whole


def _part(record: DutyRecord, *shown: DutyWindow) -> DutyRecord:
    return _PartialRecord(
        record.scenario, record.run, record.declaration, record.repeated_digests, shown=shown
    )
