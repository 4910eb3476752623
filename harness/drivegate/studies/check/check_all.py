"""Checking candidates one after another into a folder; what one of them does never stops the others."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.resolution import resolve_candidate
from drivegate.output.junit import JUnitFile
from drivegate.output.markdown import MarkdownFile
from drivegate.output.progress import progress_on
from drivegate.output.report_folder import ReportFolder
from drivegate.output.report_pages import ReportPages
from drivegate.output.result_file import RESULT_FILE, CounterexampleFiles, ResultFile, as_json
from drivegate.output.subscription import publish
from drivegate_models.errors import HarnessFault

_Result = TypeVar("_Result")


@dataclass(frozen=True)
class Effort:
    """How much is searched, and with what.

    Attributes
    ----------
    name : str
        ``quick``, ``default`` or ``nightly``.
    seed : int
        Seed of the search.
    workers : int or None
        Number of processes; None for as many as there are processors.
    max_time : float or None
        Time after which no more work is begun (s).
    search : bool
        Whether the search climbs toward small margins.
    fail_on : str
        ``required``, or ``advisory`` where advisory checks count like required ones.
    """

    name: str = "default"
    seed: int = 0
    workers: int | None = None
    max_time: float | None = None
    search: bool = True
    fail_on: str = "required"


@dataclass(frozen=True)
class Records:
    """Files of earlier checks, and of people, that a check takes into account.

    Attributes
    ----------
    corpus : Path or None
        Folder of counterexamples that are run again.
    waivers : Path or None
        File of failures that are accepted.
    baseline : Path or None
        Earlier result that margins are compared with.
    """

    corpus: Path | None = None
    waivers: Path | None = None
    baseline: Path | None = None


@dataclass
class Checked:
    """What has become of one candidate.

    Attributes
    ----------
    specification : str
        The string that named it.
    candidate : Candidate or None
        The candidate, if there is one.
    document : dict or None
        The result document, if there is one.
    folder : Path or None
        Where its files are.
    pages : tuple of Path
        The written reports.
    error : Exception or None
        Why there is no result, or no report.
    """

    specification: str
    candidate: Candidate | None = None
    document: dict[str, Any] | None = None
    folder: Path | None = None
    pages: tuple[Path, ...] = ()
    error: Exception | None = None


def check_all(
    specifications: Sequence[str],
    output: Path,
    effort: Effort,
    summary: Callable[[Sequence[Checked]], dict[str, Any]],
    records: Records = Records(),
) -> list[Checked]:
    """Check candidates and write their reports; nothing is written where there is no result."""
    all_checked = [_resolved(specification) for specification in specifications]
    if all(checked.candidate is None for checked in all_checked):
        return all_checked
    options = _options(effort, records, [_name(checked) for checked in all_checked])
    taken: set[str] = set()
    with ReportFolder(output) as folder:
        for checked in all_checked:
            if checked.candidate is not None:
                inside = "" if len(all_checked) == 1 else _folder_name(checked.candidate.name, taken)
                _check(checked, checked.candidate, folder.staging / inside, output / inside, options)
        if any(checked.document is not None for checked in all_checked):
            if len(all_checked) > 1:
                (folder.staging / RESULT_FILE).write_text(as_json(summary(all_checked)), encoding="utf-8")
            folder.commit()
    return all_checked


def _resolved(specification: str) -> Checked:
    checked = Checked(specification)
    checked.candidate = _attempted(checked, lambda: resolve_candidate(specification))
    return checked


def _attempted(checked: Checked, work: Callable[[], _Result]) -> _Result | None:
    try:
        return work()
    except Exception as error:
        checked.error = error
        return None


def _name(checked: Checked) -> str:
    """Name a candidate as waivers do, also one that is refused."""
    return checked.specification if checked.candidate is None else checked.candidate.name


def _options(effort: Effort, records: Records, names: Sequence[str]) -> dict[str, Any]:
    """Read the records, and give what the engine is told."""
    options: dict[str, Any] = {
        "effort": effort.name,
        "seed": effort.seed,
        "workers": effort.workers,
        "max_time": effort.max_time,
        "search": effort.search,
        "fail_on": effort.fail_on,
    }
    if records.corpus is not None:
        from drivegate.results.corpus import read_corpus

        options["corpus"] = read_corpus(records.corpus)
    if records.waivers is not None:
        from drivegate.results.waivers import read_waivers

        options["waivers"] = read_waivers(records.waivers, names)
    if records.baseline is not None:
        from drivegate.results.baseline import read_baseline

        options["baseline"] = read_baseline(records.baseline)
    return options


def _check(
    checked: Checked, candidate: Candidate, staging: Path, place: Path, options: dict[str, Any]
) -> None:
    # The engine brings the compiled plant, which a candidate that is refused does not need.
    from drivegate.gate.engine import check_candidate

    pages = ReportPages(staging)

    def work() -> dict[str, Any]:
        events = check_candidate(candidate, **options)
        with progress_on(sys.stderr) as progress:
            staging.mkdir(exist_ok=True)
            files = (
                ResultFile(staging),
                CounterexampleFiles(staging),
                JUnitFile(staging),
                MarkdownFile(staging),
            )
            return publish(events, (progress, *files, pages)).document()

    checked.document = _attempted(checked, work)
    if checked.document is None:
        return
    checked.folder = place
    checked.pages = tuple(place / page for page in pages.pages)
    if pages.problems:
        checked.error = HarnessFault(
            f"{'; '.join(pages.problems)}, but the result is in {place / RESULT_FILE}"
        )
        checked.error.__cause__ = pages.error


def _folder_name(name: str, taken: set[str]) -> str:
    """Make a name that any file system takes, and that no other candidate has."""
    plain = re.sub(r"[^A-Za-z0-9_.-]+", "-", name).strip(".-")[:80] or "candidate"
    unique, count = plain, 1
    while unique.lower() in taken:
        count += 1
        unique = f"{plain}-{count}"
    taken.add(unique.lower())
    return unique
