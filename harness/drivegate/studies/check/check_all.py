"""Checking candidates one after another into a folder; what one of them does never stops the others."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.resolution import resolve_candidate
from drivegate.output.event_loop import finished
from drivegate.output.pace import slow_in_words
from drivegate.output.progress import progress_on
from drivegate.output.report_folder import ReportFolder
from drivegate.output.report_writers import WrittenReports
from drivegate.output.result_file import RESULT_FILE, as_json
from drivegate.output.result_reports import OWN_FORMATS, all_formats, write_result
from drivegate.results.result import CheckResult
from drivegate.studies.check.checked import Checked, summary
from drivegate.studies.check.part import WHOLE_CHECK, Part, focus_of
from drivegate_cases.documents.system_failure import is_of_the_disk
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import HarnessFault, InputError

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument

_Result = TypeVar("_Result")


@dataclass(frozen=True)
class Effort:
    """How much is searched, and with what."""

    name: str = "default"
    """``quick``, ``default`` or ``nightly``."""
    seed: int = 0
    """Seed of the search."""
    workers: int | None = None
    """Number of processes; None for as many as there are processors."""
    max_time: float | None = None
    """Time after which no more work is begun (s)."""
    search: bool = True
    """Whether the search climbs toward small margins."""
    fail_on: str = "required"
    """``required``, or ``advisory`` where advisory checks count like required ones."""
    contested: str = "pass"
    """``fail`` where failures count that no known good controller avoids in the same scenario, else ``pass``."""


@dataclass(frozen=True)
class Place:
    """Where the files of a candidate are written."""

    staging: Path
    """Where they are written."""
    shown: Path
    """Where they will be."""


@dataclass(frozen=True)
class Records:
    """Files of earlier checks, and of people, that a check takes into account."""

    corpus: Path | None = None
    """Folder of counterexamples that are run again."""
    waivers: Path | None = None
    """File of failures that are accepted."""
    baseline: Path | None = None
    """Earlier result that margins are compared with."""


def check_all(
    specifications: Sequence[str],
    output: Path,
    effort: Effort,
    records: Records = Records(),
    sign: Path | None = None,
    part: Part = WHOLE_CHECK,
    *,
    drive: DriveDocument | None = None,
    drive_named: str | None = None,
    quiet: bool = False,
) -> list[Checked]:
    """Check candidates and write their reports; nothing is written where there is no result.

    Each is checked on the drive that is given, else on the one that its manifest names, else on the default.
    """
    finish = _finish(sign)
    all_checked = [_resolved(specification) for specification in specifications]
    if all(checked.candidate is None for checked in all_checked):
        return all_checked
    options = _options(effort, records, [_name(checked) for checked in all_checked])
    options |= {"drive": drive, "drive_named": drive_named}
    if part != WHOLE_CHECK:
        options["focus"] = focus_of(part, [checked.candidate for checked in all_checked], output)
    taken: set[str] = set()
    with ReportFolder(output) as folder:
        for checked in all_checked:
            if checked.candidate is not None:
                inside = "" if len(all_checked) == 1 else _folder_name(checked.candidate.name, taken)
                place = Place(folder.staging / inside, output / inside)
                _check(checked, checked.candidate, place, options, finish, quiet=quiet)
        written = [checked for checked in all_checked if checked.folder is not None]
        if written:
            try:
                if len(all_checked) > 1:
                    (folder.staging / RESULT_FILE).write_text(as_json(summary(all_checked)), encoding="utf-8")
                folder.commit()
            except (OSError, InputError) as error:
                # What the candidates came to is told all the same.
                for checked in written:
                    checked.folder, checked.pages, checked.error = None, (), _unwritten(error, output)
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
    """Read the records, and give what the engine takes."""
    options: dict[str, Any] = {
        "effort": effort.name,
        "seed": effort.seed,
        "workers": effort.workers,
        "max_time": effort.max_time,
        "search": effort.search,
        "fail_on": effort.fail_on,
        "contested": effort.contested,
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


def _finish(sign: Path | None) -> Callable[[CheckResult], dict[str, Any]]:
    """Give what makes a document of a result, signed if there is a key; it is read before any candidate is."""
    if sign is None:
        return CheckResult.document
    from drivegate.results.signature import signed
    from drivegate.results.signing_keys import read_private_key

    key = read_private_key(sign)
    return lambda result: signed(result.document(), key)


def _check(
    checked: Checked,
    candidate: Candidate,
    place: Place,
    options: dict[str, Any],
    finish: Callable[[CheckResult], dict[str, Any]],
    *,
    quiet: bool,
) -> None:
    # The engine brings the compiled plant, which a candidate that is refused does not need.
    from drivegate.gate.engine import check_candidate

    def work() -> WrittenReports:
        with progress_on(None if quiet else sys.stderr) as display:
            events = check_candidate(
                candidate, on_slow=lambda run: display.announce(slow_in_words(run)), **options
            )
            result = finished(events, display)
            # Whatever reports do to the document that they get, this one is the result's.
            checked.document = finish(result)
            place.staging.mkdir(exist_ok=True)
            written = write_result(finish(result), place.staging, all_formats())
        for name, error in written.errors.items():
            if name in OWN_FORMATS or is_of_the_disk(error):
                raise error
        return written

    written = _attempted(checked, work)
    if written is None:
        if checked.document is not None and checked.error is not None:
            checked.error = _unwritten(checked.error, place.shown)
        return
    checked.folder = place.shown
    checked.pages = tuple(
        place.shown / page for name, page in written.pages.items() if name not in OWN_FORMATS
    )
    if written.errors:
        checked.error = HarnessFault(
            f"{'; '.join(written.problems())}, but the result is in {place.shown / RESULT_FILE}"
        )
        checked.error.__cause__ = next(iter(written.errors.values()))


def _unwritten(error: Exception, place: Path) -> Exception:
    """Say of an error of the disk what a user can do about it."""
    if not is_of_the_disk(error):
        return error
    refusal = InputError(
        f"--output {shown_path(place)} cannot be written: {error.strerror}; no report was kept, so make room "
        "or name a folder on another disk"
    )
    refusal.__cause__ = error
    return refusal


def _folder_name(name: str, taken: set[str]) -> str:
    """Make a name that any file system takes, and that no other candidate has."""
    plain = re.sub(r"[^A-Za-z0-9_.-]+", "-", name).strip(".-")[:80] or "candidate"
    unique, count = plain, 1
    while unique.lower() in taken:
        count += 1
        unique = f"{plain}-{count}"
    taken.add(unique.lower())
    return unique
