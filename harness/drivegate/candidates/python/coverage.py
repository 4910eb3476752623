"""What runs reach of a candidate in Python: its lines and branches, counted and read by `coverage`."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, Final

from drivegate.candidates.candidate import Candidate, Instrumented
from drivegate.candidates.contract import AnyNameplate
from drivegate.candidates.native.coverage_tools import (
    COBERTURA,
    LCOV,
    hand_over,
    require_package,
    run_tool,
    work_folder,
)
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.reached_code import Line, SourceFile
from drivegate_cases.documents.regular_file import made_content

_DATA: Final = ".coverage"
_JSON: Final = "coverage.json"
_ADD_SOURCES: Final = """import sys
from coverage import CoverageData
data = CoverageData(sys.argv[1])
data.read()
data.add_arcs({})
data.touch_files(sys.argv[2:])
"""
"""Adds the sources that no process has imported, of which nothing ran."""


def counted_candidate(candidate: Candidate, folder: Path) -> Candidate:
    """Return a candidate whose processes write into a folder which of its lines ran."""
    require_package("coverage", "--coverage")
    return replace(candidate, instrumented=Instrumented("coverage", folder))


@cache
def counter_of(folder: Path, sources: tuple[Path, ...]) -> Any:
    """Return what traces the candidate's lines in this process."""
    from coverage import Coverage

    return Coverage(
        data_file=str(folder / _DATA),
        data_suffix=True,
        branch=True,
        config_file=False,
        include=[str(source) for source in sources],
        messages=False,
    )


class CountedController(PythonController):
    """A candidate whose lines are traced; the harness ends the tracing before each order, so each begins it again."""

    def __init__(self, instance: Any, counter: Any, remarks: Callable[[], tuple[str, ...]]) -> None:
        super().__init__(instance, remarks)
        self._counter = counter

    def reset(self, nameplate: AnyNameplate) -> None:
        self.begin_counting()
        try:
            super().reset(nameplate)
        finally:
            self._counter.stop()

    def begin_counting(self) -> None:
        self._counter.stop()
        self._counter.start()

    def write_counters(self) -> None:
        self._counter.stop()
        self._counter.save()


def measured_files(candidate: Candidate, output: Path) -> tuple[SourceFile, ...]:
    """Read what was counted, and write the files for services into a folder."""
    work = work_folder(candidate)
    folder = work.parent
    data, readable = work / _DATA, (folder, *candidate.sources)
    own_sources = [str(source) for source in candidate.sources if source.suffix == ".py"]
    # A file of settings in the candidate's folder is for its own tests.
    options = ("--rcfile=/dev/null", f"--data-file={data}", "-q")
    for words in (
        ("-m", "coverage", "combine", *options, "--keep", str(folder)),
        ("-c", _ADD_SOURCES, str(data), *own_sources),
        ("-m", "coverage", "json", *options, "-o", str(work / _JSON)),
        ("-m", "coverage", "lcov", *options, "-o", str(work / LCOV)),
        ("-m", "coverage", "xml", *options, "-o", str(work / COBERTURA)),
    ):
        # A process that ends itself at once leaves nothing to combine.
        if "combine" not in words or list(folder.glob(f"{_DATA}.*")):
            run_tool([sys.executable, "-P", *words], candidate.folder, readable, work, "coverage")
    hand_over(work, output)
    document = json.loads(made_content(work / _JSON))
    # The candidate's process wrote the names, and could name any file.
    own = {
        name: file
        for name, file in document["files"].items()
        if (candidate.folder / name).resolve() in candidate.sources
    }
    return tuple(_file(name, file, candidate.folder) for name, file in sorted(own.items()))


def _file(name: str, file: Mapping[str, Any], folder: Path) -> SourceFile:
    text = (folder / name).read_text(encoding="utf-8", errors="replace").splitlines()
    branches: dict[int, list[tuple[int, int]]] = {}
    for key, taken in (("executed_branches", 1), ("missing_branches", 0)):
        for begin, end in file[key]:
            branches.setdefault(begin, []).append((end, taken))
    counts = {**dict.fromkeys(file["missing_lines"], 0), **dict.fromkeys(file["executed_lines"], 1)}
    lines = tuple(
        Line(number, counts[number], _in_order(branches.get(number, ()))) for number in sorted(counts)
    )
    return SourceFile(name, tuple(text), lines)


def _in_order(branches: Sequence[tuple[int, int]]) -> tuple[int, ...]:
    return tuple(taken for _, taken in sorted(branches))
