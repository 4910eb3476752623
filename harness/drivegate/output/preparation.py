"""Preparing reports while a check's runs go on: what they need whatever the candidate does."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from threading import Thread

from drivegate.gate.events import CheckStarted, Event, RunDone
from drivegate.output.report_writers import LoadWriter, preparation
from drivegate_cases.drive.drive_document import DriveDocument


class Preparation:
    """Prepares reports on drives in threads, which leave the result and the pages unchanged."""

    def __init__(self, writers: Mapping[str, LoadWriter]) -> None:
        self._writers = writers
        self._threads: dict[DriveDocument, Thread] = {}

    def following(self, events: Iterable[Event]) -> Iterator[Event]:
        """Pass the events of a check on, and begin at its first run, when all kernels are compiled."""
        drive: DriveDocument | None = None
        for event in events:
            if isinstance(event, CheckStarted):
                drive = None if event.plan is None else event.plan.drive
            elif isinstance(event, RunDone) and drive is not None and drive not in self._threads:
                self._threads[drive] = Thread(target=self._prepare, args=(drive,), daemon=True)
                self._threads[drive].start()
            yield event

    def wait(self) -> None:
        """Wait until everything is prepared."""
        for thread in self._threads.values():
            thread.join()

    def _prepare(self, drive: DriveDocument) -> None:
        for load in self._writers.values():
            prepare = preparation(load)
            # Whatever is wrong is reported when the page is written.
            with suppress(Exception):
                if prepare is not None:
                    prepare(drive)
