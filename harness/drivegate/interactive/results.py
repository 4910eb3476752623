"""What the functions return: the documents of the commands, with tables and traces as data frames of pandas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drivegate_cases.documents.wording import nearest
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    import pandas

    from drivegate.results.counterexample import Counterexample


@dataclass(frozen=True)
class CheckResult:
    """The verdict on one candidate."""

    document: Mapping[str, Any]
    """The content of ``result.json``."""
    folder: Path | None
    """Folder of the report; None if it was not kept."""

    @property
    def verdict(self) -> str:
        """``pass`` or ``fail``, or ``incomplete`` if the check ended before all of its runs."""
        return str(self.document["verdict"])

    @property
    def passed(self) -> bool:
        """Whether the candidate passes, as the exit code 0 of the command."""
        return int(self.document["exit_code"]) == 0

    @property
    def checks(self) -> pandas.DataFrame:
        """A row for each check, with its identifier as the index."""
        import pandas

        columns = ["id", "level", "verdict", "margin", "message", "requirement", "limit"]
        rows = [{name: row.get(name) for name in columns} for row in self.document["checks"]]
        return pandas.DataFrame(rows, columns=columns).set_index("id")

    @property
    def failed(self) -> tuple[str, ...]:
        """Identifiers of the checks with a counterexample."""
        return tuple(row["id"] for row in self.document["checks"] if row["counterexample"] is not None)

    def counterexample(self, check: str) -> Counterexample:
        """Return the simplest scenario that was found in which a check fails, for `drivegate.replay`."""
        from drivegate.output.result_file import counterexamples
        from drivegate.results.counterexample import Counterexample
        from drivegate_cases.documents.document import parse_document

        found = {stored["check"]: stored for stored in counterexamples(dict(self.document))}
        if check not in found:
            raise InputError(
                f"there is no counterexample of '{check}'; there are "
                f"{', '.join(found) or 'none, since no check failed'}"
            )
        return parse_document(found[check], Counterexample, check)

    def trace(self, check: str) -> pandas.DataFrame:
        """Return the run that the report shows for a check: its counterexample, or its worst run.

        The result has at most 300 rows of it, each the mean of a stretch; `drivegate.simulate` records every period.
        """
        import pandas

        from drivegate.contracts.recorded_trace import recorded_trace

        rows = {row["id"]: row for row in self.document["checks"]}
        if check not in rows:
            raise InputError(
                f"there is no check '{check}', the nearest is '{nearest(str(check), list(rows))}'"
            )
        found = recorded_trace(self.document, rows[check])
        if found is None:
            raise InputError(f"the result has no trace of '{check}', which was judged on no run of its own")
        return pandas.DataFrame(found.columns)


@dataclass(frozen=True)
class Simulation:
    """One run of a candidate through a scenario."""

    document: Mapping[str, Any]
    """What ``drivegate simulate --json`` prints."""
    trace: pandas.DataFrame
    """A row for each control period; empty after a fault."""

    @property
    def fault(self) -> Mapping[str, Any] | None:
        """What ended the run early: kind, message, step and time of a candidate's fault; None for nothing."""
        fault: Mapping[str, Any] | None = self.document["fault"]
        return fault

    @property
    def summary(self) -> Mapping[str, Any]:
        """Energies, losses and peaks of the whole run; empty after a fault."""
        summary: Mapping[str, Any] = self.document.get("summary", {})
        return summary

    @property
    def windows(self) -> pandas.DataFrame:
        """A row for each steady stretch."""
        import pandas

        return pandas.DataFrame(self.document.get("windows", []))


@dataclass(frozen=True)
class Comparison:
    """Several candidates compared on one or more drives."""

    document: Mapping[str, Any]
    """The content of ``comparison.json``."""
    pages: tuple[Path, ...]
    """The reports; none if they were not kept."""

    @property
    def tables(self) -> dict[str, pandas.DataFrame]:
        """The tables of the report by their name."""
        import pandas

        return {name: pandas.DataFrame(rows) for name, rows in self.document["tables"].items()}


@dataclass(frozen=True)
class Replayed:
    """A counterexample that was run again."""

    document: Mapping[str, Any]
    """What ``drivegate replay --json`` prints."""
    trace: pandas.DataFrame
    """A row for each control period; empty where no plant was run, or after a fault."""

    @property
    def verdict(self) -> str:
        """``still fails``, ``fixed``, ``not reproduced`` or ``not applicable``."""
        return str(self.document["verdict"])

    @property
    def margin(self) -> float | None:
        """The margin now; None where there is nothing to judge."""
        now = self.document["now"]
        return None if now is None else float(now["margin"])
