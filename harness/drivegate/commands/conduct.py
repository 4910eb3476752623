"""How every command ends: what it prints, as text or as JSON, and the exit code, whatever happens in it."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from drivegate.output.failure import ExitCode, complain, failure_of
from drivegate.output.streams import guard_output, leave_unread, write_to

if TYPE_CHECKING:
    from rich.console import Console


@dataclass(frozen=True)
class Outcome:
    """The outcome of a command."""

    document: Mapping[str, Any]
    """What ``--json`` prints; a number that is not finite becomes null."""
    show: Callable[[Console], object]
    """Prints the same for people."""
    exit_code: int = ExitCode.PASSED


def wants_json(words: Sequence[str]) -> bool:
    """Return True if the arguments ask for JSON, even if they are wrong otherwise."""
    options = words[: words.index("--")] if "--" in words else words
    return "--json" in options


def conducted(work: Callable[[], object], *, as_json: bool) -> int:
    guard_output()
    try:
        outcome = work()
        if not isinstance(outcome, Outcome):
            return outcome if isinstance(outcome, int) else ExitCode.PASSED
        _print(outcome, as_json)
    except (Exception, KeyboardInterrupt) as error:
        failure = failure_of(error)
        complain(failure, error)
        if as_json:
            with suppress(OSError):
                _write_json(failure.document())
        return failure.exit_code
    return outcome.exit_code


def _print(outcome: Outcome, as_json: bool) -> None:
    try:
        if as_json:
            _write_json(outcome.document)
        elif sys.stdout is not None:
            from drivegate.output.console import console_for

            outcome.show(console_for(sys.stdout))
            sys.stdout.flush()
    except BrokenPipeError:
        # The reader has seen enough; the outcome of the command does not change.
        leave_unread(sys.stdout)


def _write_json(document: Mapping[str, Any]) -> None:
    from drivegate.results.result import finite

    # A CI server that reads the log must not obey what is in a text.
    text = json.dumps(finite(document), indent=2, allow_nan=False).replace("##", "#\\u0023")
    write_to(sys.stdout, f"{text}\n")
