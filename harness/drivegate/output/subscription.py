"""Handing a check's events to whoever listens."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TypeAlias

from drivegate.gate.events import CheckFinished, Event
from drivegate.results.result import CheckResult
from drivegate_models.errors import HarnessFault

Handler: TypeAlias = Callable[[Event], None]
"""Takes every event, and minds those that it cares for."""


def publish(events: Iterable[Event], handlers: Sequence[Handler]) -> CheckResult:
    """Hand every event to every handler, in their order."""
    result: CheckResult | None = None
    for event in events:
        for handler in handlers:
            handler(event)
        if isinstance(event, CheckFinished):
            result = event.result
    if result is None:
        raise HarnessFault("the check ended without a result")
    return result
