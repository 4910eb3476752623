"""Checking candidates one after another into a folder; what one of them does never stops the others."""

from __future__ import annotations

import re
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.resolution import resolve_candidate
from drivegate.gate.events import Event, Running
from drivegate.gate.options import CheckOptions
from drivegate.output.event_loop import finished
from drivegate.output.progress import progress_on
from drivegate.output.report_folder import ReportFolder
from drivegate.output.report_writers import LoadWriter, Preparation, page_name, write_reports
from drivegate.output.rerun import PLACES, places_of
from drivegate.output.result_file import RESULT_FILE, as_json
from drivegate.output.result_reports import page_formats
from drivegate.output.waiting import CheckPace
from drivegate.studies.check.checked import Checked, summary
from drivegate.studies.check.inspection import NOT_INSPECTED, Inspection, inspected, with_findings
from drivegate.studies.check.part import WHOLE_CHECK, Part, focus_of, own_ids
from drivegate.studies.check.storing import incomplete, store, unwritten
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.results.document import ResultDocument


@dataclass(frozen=True)
class Records:
    """Files of earlier checks, and of people, that a check takes into account."""

    corpus: Path | None = None
    """Folder of counterexamples that are run again."""
    waivers: Path | None = None
    """File of failures that are accepted."""
    baseline: Path | None = None
    """Earlier result that margins are compared with."""
    requirements: Path | None = None
    """File of the user's own requirements; None for those that manifests name."""


def check_all(
    specifications: Sequence[str],
    output: Path,
    options: CheckOptions,
    records: Records = Records(),
    part: Part = WHOLE_CHECK,
    *,
    inspection: Inspection = NOT_INSPECTED,
    quiet: bool = False,
    show: Callable[[list[Checked]], None] = lambda _: None,
) -> list[Checked]:
    """Check candidates and write their reports; nothing is written where there is no result.

    `show` gets the verdicts when the results are stored, before the pages are written.
    """
    all_checked = []
    with progress_on(None if quiet else sys.stderr) as display:
        for specification in specifications:
            display.begin(specification, words="loading")
            checked = Checked(specification)
            all_checked.append(checked)
            try:
                checked.candidate = resolve_candidate(specification)
            except Exception as error:
                checked.error = error
    if all(checked.candidate is None for checked in all_checked):
        show(all_checked)
        return all_checked
    options = _with_records(options, records, all_checked)
    if part != WHOLE_CHECK:
        candidates = [checked.candidate for checked in all_checked]
        focus = focus_of(part, candidates, output, own_ids(candidates, options.requirements))
        options = replace(options, focus=focus)
    taken: set[str] = set()
    writers = page_formats()
    preparation = Preparation(writers)
    with _termination() as ending, ReportFolder(output) as folder:
        for checked in all_checked:
            if ending.is_requested():
                checked.error = checked.error or KeyboardInterrupt()
            elif checked.candidate is not None:
                inside = "" if len(all_checked) == 1 else _folder_name(checked.candidate.name, taken)
                checked.folder = output / inside
                _check(
                    checked, folder.staging / inside, options, inspection, preparation, ending, quiet=quiet
                )
        _commit(all_checked, folder, output)
        named = () if ending.is_requested() else tuple(filter(None, map(page_name, writers.values())))
        for checked in _stored(all_checked):
            checked.pages = tuple(checked.folder / page for page in named if checked.folder is not None)
        show(all_checked)
        ending.end()
        # Who ends a check waits a few seconds at most, and pages can be made of its result.
        if _stored(all_checked) and not ending.is_requested():
            preparation.wait()
            _write_pages(all_checked, folder, output, writers, quiet=quiet)
    return all_checked


def _stored(all_checked: Sequence[Checked]) -> list[Checked]:
    return [checked for checked in all_checked if checked.folder is not None]


def _commit(all_checked: Sequence[Checked], folder: ReportFolder, output: Path) -> None:
    """Store the results; where they cannot be stored, the verdicts are shown all the same."""
    stored = _stored(all_checked)
    if not stored:
        return
    try:
        _write_summary(all_checked, folder.staging)
        folder.commit()
    except (OSError, InputError) as error:
        for checked in stored:
            checked.folder, checked.error = None, unwritten(error, output)


def _write_summary(all_checked: Sequence[Checked], folder: Path) -> None:
    if len(all_checked) > 1:
        (folder / RESULT_FILE).write_text(as_json(summary(all_checked)), encoding="utf-8")


def _write_pages(
    all_checked: Sequence[Checked],
    folder: ReportFolder,
    output: Path,
    writers: Mapping[str, LoadWriter],
    *,
    quiet: bool,
) -> None:
    """Add the pages of installed packages to the stored results."""
    stored = _stored(all_checked)
    try:
        with progress_on(None if quiet else sys.stderr) as display, folder.adding() as staging:
            for checked in stored:
                assert checked.folder is not None
                assert checked.document is not None
                display.begin(_name(checked), words="writing the report")
                place = staging / checked.folder.relative_to(output)
                place.mkdir(exist_ok=True)
                # Whatever reports do to the document that they get, this one is the result's.
                written = write_reports(deepcopy(checked.document), place, writers)
                checked.pages = tuple(checked.folder / page for page in written.pages.values())
                checked.error = checked.error or incomplete(written, checked.folder, output)
            if any(checked.error for checked in stored):
                _write_summary(all_checked, staging)
    except (OSError, InputError) as error:
        for checked in stored:
            kept = f"the result is kept in {shown_path(output)}, the reports are not"
            checked.pages, checked.error = (), unwritten(error, output, kept)


def _name(checked: Checked) -> str:
    """Name a candidate as waivers do, also one that is refused."""
    return checked.specification if checked.candidate is None else checked.candidate.name


def _with_records(options: CheckOptions, records: Records, all_checked: Sequence[Checked]) -> CheckOptions:
    names = [_name(checked) for checked in all_checked]
    if records.corpus is not None:
        from drivegate.results.counterexample import read_corpus

        options = replace(options, corpus=read_corpus(records.corpus))
    if records.requirements is not None:
        from drivegate_cases.requirements.file import read_requirements

        options = replace(options, requirements=read_requirements(records.requirements))
    if records.waivers is not None:
        from drivegate.results.waivers import read_waivers

        own = own_ids([checked.candidate for checked in all_checked], options.requirements)
        options = replace(options, waivers=read_waivers(records.waivers, names, own))
    if records.baseline is not None:
        from drivegate.results.baseline import read_baseline

        options = replace(options, baseline=read_baseline(records.baseline))
    return options


def _check(
    checked: Checked,
    staging: Path,
    options: CheckOptions,
    inspection: Inspection,
    preparation: Preparation,
    ending: Termination,
    *,
    quiet: bool,
) -> None:
    """Check one candidate, and write its result and the harness's own reports into a folder."""
    candidate = checked.candidate
    assert candidate is not None, "only a candidate that was found is checked"

    def keep(result: ResultDocument) -> None:
        checked.document = result.written()
        if checked.folder is not None:
            checked.document["timing"] |= {PLACES: places_of(checked.folder.resolve())}

    def keep_all(result: ResultDocument, seen: Candidate) -> None:
        # Kept first without the findings, which may fail to be read.
        keep(result)
        keep(with_findings(result, seen, inspection, staging))

    try:
        with (
            progress_on(None if quiet else sys.stderr) as display,
            inspected(candidate, inspection) as seen,
        ):
            display.begin(candidate.name)
            # The engine brings the compiled plant, which a candidate that is refused does not need.
            from drivegate.gate.engine import check_candidate

            pace = CheckPace(is_quick=options.effort == "quick", is_part=bool(options.focus.only))
            followed_options = replace(
                options,
                on_slow=lambda run: display.announce(pace.slow_run_in_words(run)),
                is_ended=ending.is_requested,
            )
            events = check_candidate(seen, followed_options)
            followed = ending.following(preparation.following(events))
            finished(followed, display, pace, lambda result: keep_all(result, seen))
            # Announced here, so that the verdict is the last line of a log.
            display.phase("writing the report")
    except Exception as error:
        checked.error = error
    store(checked, staging)
    if ending.is_requested():
        checked.error = checked.error or KeyboardInterrupt()


def _folder_name(name: str, taken: set[str]) -> str:
    """Make a name that any file system takes, and that no other candidate has."""
    plain = re.sub(r"[^A-Za-z0-9_.-]+", "-", name).strip(".-")[:80] or "candidate"
    unique, count = plain, 1
    while unique.lower() in taken:
        count += 1
        unique = f"{plain}-{count}"
    taken.add(unique.lower())
    return unique


class Termination:
    """Whether SIGTERM or Ctrl-C came, and what they do now.

    Some systems end a job with SIGINT and send SIGTERM soon after. Therefore only a second SIGINT ends a check at once.
    """

    def __init__(self) -> None:
        self._is_requested = False
        self._is_deferred = False

    def is_requested(self) -> bool:
        """Return True if a signal came while a check could end by itself."""
        return self._is_requested

    def following(self, events: Iterable[Event]) -> Iterator[Event]:
        """Pass the events of a check on, and defer both signals from its first run on."""
        for event in events:
            self._is_deferred |= isinstance(event, Running)
            yield event

    def end(self) -> None:
        """Interrupt at once again."""
        self._is_deferred = False

    def _answer(self, number: int, frame: FrameType | None) -> None:
        is_repeated = number == signal.SIGINT and self._is_requested
        if is_repeated or not self._is_deferred:
            signal.default_int_handler(number, frame)
        self._is_requested = True


@contextmanager
def _termination() -> Iterator[Termination]:
    """Answer signals as long as the context lasts, unless they are ignored; only the main thread can."""
    made = Termination()
    former = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    is_main = threading.current_thread() is threading.main_thread()
    answered = [number for number in former if is_main and former[number] not in (signal.SIG_IGN, None)]
    for number in answered:
        signal.signal(number, made._answer)
    try:
        yield made
    finally:
        for number in answered:
            signal.signal(number, former[number])
