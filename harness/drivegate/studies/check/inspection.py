"""Looking into a candidate while it is checked: what its runs reach of the code, and what sanitizers report."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.reached_code import Reached, SourceFile, reached_branches, reached_lines
from drivegate.candidates.sanitizers import read_sanitizers
from drivegate.containment.temporary_folder import temporary_folder
from drivegate.output.code_coverage import write_code_pages
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.results.document import ResultDocument

COVERAGE_FOLDER: Final = "coverage"
"""Folder of what was reached, in the report's."""
BELOW: Final = "coverage"
"""Verdict on a candidate of which too little was reached."""


@dataclass(frozen=True)
class Inspection:
    """How a candidate is looked into; by default, not at all."""

    coverage: bool = False
    at_least: tuple[float, float] | None = None
    """Least shares of lines and branches that have to be reached (%); None for none."""
    sanitizers: tuple[str, ...] = ()


NOT_INSPECTED: Final = Inspection()

_log = logging.getLogger("drivegate")


@contextmanager
def inspected(candidate: Candidate, inspection: Inspection) -> Iterator[Candidate]:
    """Make a candidate that is looked into as long as the context lasts."""
    if inspection == NOT_INSPECTED:
        yield candidate
        return
    if inspection.coverage and inspection.sanitizers:
        raise InputError(
            "--coverage and --sanitize do not go together, since a sanitizer's own branches would count; check twice"
        )
    with temporary_folder() as folder:
        if inspection.coverage:
            counted = KINDS[candidate.kind].counted_candidate(candidate, folder)
            require_branches(counted, inspection)
            yield counted
        else:
            yield KINDS[candidate.kind].sanitized_candidate(candidate, inspection.sanitizers, folder)


def require_branches(candidate: Candidate, inspection: Inspection) -> None:
    """Refuse to require a share of branches where lines alone are counted, which would pass whatever ran."""
    looking = candidate.instrumented
    if looking is None or looking.counts_branches or not (inspection.at_least and inspection.at_least[1]):
        return
    lines, branches = inspection.at_least
    raise InputError(
        f"--coverage-at-least requires {branches:g} % of branches, but only lines are counted of images, and of Rust "
        f"without a nightly toolchain; write --coverage-at-least {lines:g}"
    )


def with_findings(
    result: ResultDocument, candidate: Candidate, inspection: Inspection, staging: Path
) -> ResultDocument:
    """Add what was found to a result, and write its page and files."""
    if inspection == NOT_INSPECTED:
        return result
    if inspection.sanitizers:
        return result.model_copy(update={"sanitizers": inspection.sanitizers})
    output = staging / COVERAGE_FOLDER
    output.mkdir(parents=True, exist_ok=True)
    try:
        files = _measured(candidate, output)
    except InputError as error:
        # A candidate whose processes end early may have counted nothing, and its faults count for more.
        if result.exit_code == 0:
            raise
        _log.warning("%s", error)
        return result
    counts_branches = candidate.instrumented is None or candidate.instrumented.counts_branches
    result = with_coverage(result, files, inspection.at_least, counts_branches=counts_branches)
    write_code_pages(result, files, output)
    return result


def _measured(candidate: Candidate, output: Path) -> tuple[SourceFile, ...]:
    files = KINDS[candidate.kind].measured_files(candidate, output)
    # Of sources that nobody imports, no line was counted either.
    if not reached_lines(files).reached:
        raise InputError(
            f"--coverage: no line of {candidate.name} was counted; name its sources in the manifest, and compile it "
            "with them in place"
        )
    return files


def with_coverage(
    result: ResultDocument,
    files: Sequence[SourceFile],
    at_least: tuple[float, float] | None,
    *,
    counts_branches: bool = True,
) -> ResultDocument:
    from drivegate.results.document import CodeCoverageSection, CodeFileSection, CountSection

    counts = (reached_lines(files), reached_branches(files))
    required = at_least or (None, None)
    lines, branches = (
        CountSection(reached=count.reached, total=count.total, at_least_percent=least)
        for count, least in zip(counts, required, strict=True)
    )
    short = [
        f"{noun} below the {least:g} % of --coverage-at-least"
        for noun, count, least in zip(("lines", "branches"), counts, required, strict=True)
        if least is not None and count.percent < least
    ]
    section = CodeCoverageSection(
        lines=lines,
        branches=branches,
        files=tuple(
            CodeFileSection(
                name=file.name,
                unreached_lines=tuple(line.number for line in file.lines if not line.count),
                unreached_branches=tuple(
                    (line.number, place)
                    for line in file.lines
                    for place, count in enumerate(line.branches, 1)
                    if not count
                ),
            )
            for file in files
        ),
        message="; ".join([_in_words(*counts, counts_branches), *short]),
    )
    changed: dict[str, object] = {"code_coverage": section}
    if short and result.exit_code == 0:
        changed |= {"verdict": BELOW, "exit_code": 1}
    return result.model_copy(update=changed)


def _in_words(lines: Reached, branches: Reached, counts_branches: bool) -> str:
    of_branches = f" and {branches.in_words('branches')}" if counts_branches else "; branches are not counted"
    return f"the runs reached {lines.in_words('lines')}{of_branches}"


def read_inspection(coverage: bool, at_least: str | None, sanitize: str | None) -> Inspection:
    """Read the options of the command line."""
    return Inspection(
        coverage or at_least is not None,
        None if at_least is None else read_shares(at_least),
        () if sanitize is None else read_sanitizers(sanitize),
    )


def read_shares(text: str) -> tuple[float, float]:
    """Read the shares of --coverage-at-least: that of lines, and after a comma that of branches."""
    words = text.split(",")
    try:
        shares = [float(word) for word in words]
    except ValueError:
        shares = []
    if len(words) > 2 or not shares or not all(0.0 <= share <= 100.0 for share in shares):
        raise InputError(
            f"--coverage-at-least is '{text}', but must be a percentage of lines, and after a comma one of branches, "
            "such as 100,95"
        )
    return shares[0], shares[1] if len(shares) > 1 else 0.0
