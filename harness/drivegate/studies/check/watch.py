"""Checking again whenever a candidate's sources change: first what failed, then the rest."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from drivegate.candidates.resolution import resolve_candidate
from drivegate_models.errors import InputError


def watch(check: Callable[[bool], int], changes: Iterator[object], version: Callable[[], str]) -> int:
    """Check once, then after every change of the version; return the last exit code when there are no more changes.

    `check` is called with True to begin with what failed in the last report. Where that passes, the whole check
    follows.
    """
    known, code = None, 0
    while True:
        now = version()
        if now != known:
            # Where nothing failed, or there is no result, there is nothing to begin with.
            begun = check(True) if code == 1 else 0
            code = begun or check(False)
            # What has changed during the check is found at once.
            known = now
        elif next(changes, None) is None:
            return code


def version_of(specification: str) -> str:
    """Return what changes with a candidate's sources; while it cannot be resolved, the reason."""
    try:
        return resolve_candidate(specification).content_hash
    except InputError as error:
        return str(error)


def changes_around(specification: str, output: Path) -> Iterator[object]:
    """Yield whenever a file changes in the folders of a candidate's sources, but not in that of the report."""
    try:
        from watchfiles import DefaultFilter, watch
    except ImportError:
        raise InputError(
            "--watch needs a package that is not installed; python -m pip install 'drivegate[watch]'"
        ) from None
    candidate = resolve_candidate(specification)
    folders = {candidate.folder, *(file.parent for file in candidate.sources)}
    report = output.resolve()
    kept = DefaultFilter(ignore_paths=[report, *report.parent.glob(f".{report.name}*")])
    # Where the package is missing, its types are too.
    changes: Iterator[object] = watch(*folders, watch_filter=kept, raise_interrupt=True)
    return changes
