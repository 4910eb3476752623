"""Counts that another tool has read, as a trace of gcovr, which writes the files for services."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeAlias

from drivegate.candidates.native.coverage_tools import (
    COBERTURA,
    LCOV,
    TRACE,
    files_of_trace,
    gcovr,
    hand_over,
)
from drivegate.candidates.reached_code import SourceFile
from drivegate_cases.documents.regular_file import made_content

Counts: TypeAlias = Mapping[int, tuple[int, Sequence[int]]]
"""Of the lines of a source: how often each ran, and how often each way out of it was taken."""

_EXCLUDED: Final = re.compile(r"\b(?:GCOVR?|LCOV)_EXCL_(?P<what>LINE|START|STOP)\b")


def trace_of(
    counted: Mapping[Path, Counts], common: Path, work: Path, output: Path
) -> tuple[SourceFile, ...]:
    """Write what was counted in files, the paths from a folder above them all, and return it without what is excluded.

    `work`: folder of the tools. `output`: folder of the files for services.
    """
    files = [
        {"file": str(source.relative_to(common)), "functions": [], "lines": list(_lines(source, counts))}
        for source, counts in counted.items()
    ]
    trace = work / TRACE
    trace.write_text(json.dumps(_empty_trace(work) | {"files": files}), encoding="utf-8")
    outputs = ("--lcov", str(work / LCOV), "--cobertura", str(work / COBERTURA))
    folders = tuple(source.parent for source in counted)
    gcovr(["--root", str(common), "--add-tracefile", str(trace), *outputs], work, folders, work)
    hand_over(work, output)
    return files_of_trace(trace, common)


def _lines(source: Path, counts: Counts) -> Iterator[dict[str, Any]]:
    """List the lines of a source as gcovr does, with a digest of each, by which services compare versions."""
    text = source.read_text(encoding="utf-8", errors="replace").splitlines()
    excluded = set(_excluded_lines(text))
    for number, (count, branches) in sorted(counts.items()):
        if number <= len(text) and number not in excluded:
            yield {
                "line_number": number,
                "count": count,
                "branches": [
                    {"branchno": place, "count": taken, "fallthrough": False, "throw": False}
                    for place, taken in enumerate(branches)
                ],
                "gcovr/md5": hashlib.md5(text[number - 1].encode(), usedforsecurity=False).hexdigest(),
            }


def _excluded_lines(text: Sequence[str]) -> Iterator[int]:
    is_inside = False
    for number, line in enumerate(text, 1):
        found = {match["what"] for match in _EXCLUDED.finditer(line)}
        is_inside = (is_inside or "START" in found) and "STOP" not in found
        if is_inside or found:
            yield number


def _empty_trace(work: Path) -> dict[str, Any]:
    """Have gcovr write a trace of nothing, which has the version of its format."""
    nothing = work / "nothing"
    nothing.mkdir()
    trace = nothing / TRACE
    gcovr(["--root", str(nothing), "--json", str(trace), str(nothing)], nothing, (), work)
    empty: dict[str, Any] = json.loads(made_content(trace))
    return empty
