"""Where in a run the verdict of a check comes from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin
from drivegate.contracts.current.record import CurrentRecord, SteadyWindow
from drivegate.contracts.current.run import observed_windows


@dataclass(frozen=True)
class _PartialRecord(CurrentRecord):
    """A run of which only some of the steady stretches are shown."""

    shown: tuple[int, ...] = ()
    """Their places among all of them."""

    def windows(self) -> Iterator[SteadyWindow]:
        for place, window in enumerate(super().windows()):
            if place in self.shown:
                yield window


def judged_window(check: Check, record: CurrentRecord, margin: Margin | None) -> tuple[float, float]:
    """Find the steady stretch that alone gives the same margin; the whole run where none decides."""
    whole = (0.0, record.scenario.duration_s)
    if margin is None or check.evaluate(_part(record, ())) is not None:
        return whole
    begin = {end: start for start, end in observed_windows(record.scenario)}
    for place, window in enumerate(record.windows()):
        alone = check.evaluate(_part(record, (place,)))
        if alone is not None and alone.value == margin.value:
            return begin[window.dwell.end], window.dwell.end
    return whole


def _part(record: CurrentRecord, shown: tuple[int, ...]) -> CurrentRecord:
    return _PartialRecord(
        record.scenario, record.run, record.declaration, record.repeated_digests, shown=shown
    )
