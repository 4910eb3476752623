"""Storing the result of one candidate: what cannot be written takes nothing with it that can."""

from __future__ import annotations

from pathlib import Path

from drivegate.output.report_folder import unwritable
from drivegate.output.report_writers import WrittenReports, write_reports
from drivegate.output.result_file import RESULT_FILE, write_result_files
from drivegate.output.result_reports import own_formats
from drivegate.studies.check.checked import Checked
from drivegate_cases.documents.system_failure import disk_failure
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import HarnessFault


def store(checked: Checked, staging: Path) -> None:
    """Write a result, and the harness's own reports; one that cannot be written takes no result with it."""
    place = checked.folder
    assert place is not None, "its folder is known"
    if checked.document is None:
        checked.folder = None
        return
    try:
        staging.mkdir(exist_ok=True)
        write_result_files(checked.document, staging)
    except Exception as error:
        checked.folder, checked.error = None, unwritten(error, place)
        return
    written = write_reports(checked.document, staging, own_formats())
    checked.error = checked.error or incomplete(written, place, place)


def incomplete(written: WrittenReports, place: Path, output: Path) -> Exception | None:
    """Return why a stored result lacks reports; None where it lacks none."""
    if not written.errors:
        return None
    result, cause = place / RESULT_FILE, next(iter(written.errors.values()))
    full = disk_failure(cause)
    if full is None:
        error: Exception = HarnessFault(f"{'; '.join(written.problems())}, but the result is in {result}")
    else:
        error = unwritable(output, full, f"the result is kept in {shown_path(result)}, the reports are not")
    error.__cause__ = cause
    return error


def unwritten(error: BaseException, place: Path, kept: str = "no report was kept") -> BaseException:
    """Return an error of the disk with what a user can do about it."""
    full = disk_failure(error)
    if full is None:
        return error
    refusal = unwritable(place, full, kept)
    refusal.__cause__ = error
    return refusal
