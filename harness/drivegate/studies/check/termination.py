"""SIGTERM during a check: like Ctrl-C, except that a check whose runs have begun ends with what it knows."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from types import FrameType

from drivegate.gate.events import Event, Running


class Termination:
    """Whether SIGTERM came, and what it does now."""

    def __init__(self) -> None:
        self._is_requested = False
        self._is_deferred = False

    def is_requested(self) -> bool:
        """Return True if SIGTERM came while a check could end by itself."""
        return self._is_requested

    def following(self, events: Iterable[Event]) -> Iterator[Event]:
        """Pass the events of a check on, and defer SIGTERM from its first run on."""
        for event in events:
            self._is_deferred |= isinstance(event, Running)
            yield event

    def end(self) -> None:
        """Answer SIGTERM as Ctrl-C again."""
        self._is_deferred = False

    def _answer(self, number: int, frame: FrameType | None) -> None:
        if not self._is_deferred:
            signal.default_int_handler(number, frame)
        self._is_requested = True


@contextmanager
def termination() -> Iterator[Termination]:
    """Answer SIGTERM as long as the context lasts, unless it is ignored; only the main thread can."""
    made = Termination()
    is_main = threading.current_thread() is threading.main_thread()
    former = signal.getsignal(signal.SIGTERM)
    if not is_main or former in (signal.SIG_IGN, None):
        yield made
        return
    signal.signal(signal.SIGTERM, made._answer)
    try:
        yield made
    finally:
        signal.signal(signal.SIGTERM, former)
