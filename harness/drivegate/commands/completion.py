"""What a shell completes: names of drives, scenarios, checks and candidates, and files where there is no name."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import click
from click.shell_completion import CompletionItem


def complete_drive(
    _context: click.Context, _option: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    from drivegate_cases.drive.drive_document import drive_names

    return _offered([*drive_names(), *_files(incomplete, (".toml", ".json"))], incomplete)


def complete_case(_context: click.Context, _option: click.Parameter, incomplete: str) -> list[CompletionItem]:
    from drivegate_cases.scenario.scenario import scenario_names

    return _offered([*scenario_names(), *_files(incomplete, (".toml", ".json"))], incomplete)


def complete_checks(
    _context: click.Context, _option: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the last of several checks between commas."""
    from drivegate.contracts.catalogue import all_checks

    before, comma, last = incomplete.rpartition(",")
    names = sorted(all_checks())
    return [CompletionItem(before + comma + name) for name in names if name.startswith(last.upper())]


def complete_candidate(
    _context: click.Context, _option: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES, DUTY_CANDIDATES
    from drivegate.candidates.kinds import MANIFEST_SUFFIX, WHOLE_FILE_SUFFIXES

    files = _files(incomplete, (MANIFEST_SUFFIX, ".py", *WHOLE_FILE_SUFFIXES))
    return _offered([*files, *BUILTIN_CANDIDATES, *DUTY_CANDIDATES], incomplete)


def _offered(names: Iterable[str], incomplete: str) -> list[CompletionItem]:
    """Offer the names that begin so; where none does, the shell's own completion of files."""
    found = [CompletionItem(name) for name in dict.fromkeys(names) if name.startswith(incomplete)]
    return found or [CompletionItem(incomplete, type="file")]


def _files(incomplete: str, suffixes: Iterable[str]) -> list[str]:
    """List the files with one of some endings in the folder that a path leads into so far."""
    start = incomplete.rpartition("/")[0]
    prefix = incomplete[: len(start) + 1] if "/" in incomplete else ""
    try:
        entries = sorted(Path(prefix or ".").iterdir())
    except OSError:
        return []
    return [prefix + path.name for path in entries if path.suffix.lower() in suffixes]
