"""What has become of candidates, and the one document about all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.output.failure import ExitCode, failure_of

SCHEMA: Final = 1
"""Version of the document about several candidates."""


@dataclass
class Checked:
    """What has become of one candidate."""

    specification: str
    candidate: Candidate | None = None
    document: dict[str, Any] | None = None
    folder: Path | None = None
    pages: tuple[Path, ...] = ()
    error: BaseException | None = None
    """Why there is no result, no report, or only a part of it."""

    @property
    def exit_code(self) -> int:
        judged = ExitCode.PASSED if self.document is None else self.document["exit_code"]
        return int(max(judged, ExitCode.PASSED if self.error is None else failure_of(self.error).exit_code))

    def entry(self) -> dict[str, Any]:
        """Make the document about this candidate alone: its result, and what kept it from one."""
        if self.error is None and self.document is not None:
            return self.document
        named = {"candidate": {"specification": self.specification}}
        # The schema of a result is that of the result.
        return ({} if self.error is None else failure_of(self.error).document()) | (self.document or named)


def summary(all_checked: Sequence[Checked]) -> dict[str, Any]:
    """Make the document about all candidates: of a single one, its result."""
    results = [checked.entry() for checked in all_checked]
    if len(results) == 1:
        return results[0]
    # A fault of drivegate (3) wins over a refusal (2), and that over a failure (1).
    worst = max(checked.exit_code for checked in all_checked)
    return {"schema": SCHEMA, "kind": "checks", "exit_code": worst, "results": results}
