"""Measure what the gate reaches of the templates and examples: ``python benchmarks/code_coverage.py ROW...``.

Without rows it measures all of them; ``--list`` prints their names. Each measured row replaces the one of that name in
``code_coverage.json``, from which ``docs/insertions.py`` makes the table of docs/code_coverage.md. Templates are
written into a temporary folder. With ``--candidate FILE``, the one named row is that of any other manifest, such as a
firmware with its adapter; of the files next to its entry, only the functions that ran are counted. ``--turns N``
measures instead how much longer a gate of the template `c` computes with counters and with sanitizers.
"""

from __future__ import annotations

import argparse
import json
import re
import resource
import subprocess
import sys
import tempfile
import tomllib
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from drivegate_cases.documents.atomic_write import write_atomically

RESULTS: Final = Path(__file__).with_suffix(".json")
EXAMPLES: Final = Path(__file__).parents[1] / "examples"
CURRENT: Final = ("--drive", "paper-5-phase")
TEMPLATES: Final[Mapping[str, Sequence[str]]] = MappingProxyType(
    {
        "c": ("c",),
        "c++": ("c++",),
        "rust": ("rust",),
        "python": ("python",),
        "cortex-m": ("cortex-m",),
        "embedded-coder": ("embedded-coder",),
        "c --sensorless": ("c", "--sensorless"),
        "c --drive paper-5-phase": ("c", *CURRENT),
        "c++ --drive paper-5-phase": ("c++", *CURRENT),
        "rust --drive paper-5-phase": ("rust", *CURRENT),
        "python --drive paper-5-phase": ("python", *CURRENT),
        "cortex-m --drive paper-5-phase": ("cortex-m", *CURRENT),
    }
)
COUNTED_EXAMPLES: Final = (
    "c",
    "python",
    "rust",
    "foc",
    "firmware/interrupt",
    "firmware/objects",
    "firmware/crate",
)


def rows() -> Iterator[str]:
    """List the names of the rows that need nothing else than the repository."""
    yield from (f"template {name}" for name in TEMPLATES)
    yield from (f"examples/{name}" for name in COUNTED_EXAMPLES)


def manifest_of(row: str, scratch: Path) -> Path:
    """Return the manifest of a row, a template's in a folder where it is written anew."""
    if row.startswith("examples/"):
        return EXAMPLES / row.removeprefix("examples/") / "candidate.toml"
    kind, *options = TEMPLATES[row.removeprefix("template ")]
    folder = scratch / "controller"
    words = ["new", kind, "controller", "--output", str(folder), "--ci", "none", *options]
    subprocess.run([sys.executable, "-m", "drivegate", *words], check=True, stdout=subprocess.DEVNULL)
    return folder / "candidate.toml"


def run_gate(manifest: Path, effort: str, further: Sequence[str], folder: Path) -> None:
    """Run a whole gate, whose report is written into a folder."""
    words = [*f"--effort {effort} --seed 0 --quiet --output {folder}".split(), *further]
    command = [sys.executable, "-m", "drivegate", "check", str(manifest), *words]
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL)


def measured(manifest: Path, effort: str, further: Sequence[str], folder: Path) -> dict[str, Any]:
    """Run the gate with coverage, and return what it reached."""
    run_gate(manifest, effort, ("--coverage", *further), folder)
    result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    section = result["code_coverage"]
    return {
        "effort": effort,
        "verdict": result["verdict"],
        "runs": result["runs"],
        **{noun: {key: section[noun][key] for key in ("reached", "total")} for noun in ("lines", "branches")},
        "open": [
            {"file": file["name"], "line": line, "text": _text(manifest.parent / file["name"], line)}
            for file in section["files"]
            for line in _open(file)
        ],
    }


def _entry(manifest: Path) -> str:
    entry: str = tomllib.loads(manifest.read_text(encoding="utf-8"))["entry"]
    return entry


def _open(file: Mapping[str, Any]) -> list[int]:
    """Return the numbers of the lines that are not reached, or not in all ways."""
    return sorted({*file["unreached_lines"], *(line for line, _ in file["unreached_branches"])})


def _text(source: Path, line: int) -> str:
    return source.read_text(encoding="utf-8", errors="replace").splitlines()[line - 1].strip()


def count_of_functions_that_ran(listed: str, entry: str) -> dict[str, dict[str, int]]:
    """Count lines and branches of the functions that ran, in a file of LCOV without the adapter."""
    lines, branches = [], []
    for record in listed.split("end_of_record"):
        if re.search(rf"^SF:(?:.*/)?{re.escape(entry)}$", record, re.MULTILINE):
            continue
        starts = {name: int(line) for line, name in re.findall(r"^FN:(\d+),(.+)$", record, re.MULTILINE)}
        ran = {
            starts[name]
            for count, name in re.findall(r"^FNDA:(\d+),(.+)$", record, re.MULTILINE)
            if int(count)
        }
        order = sorted(set(starts.values()))

        def is_inside(line: str, order: list[int] = order, ran: set[int] = ran) -> bool:
            place = bisect_right(order, int(line))
            return place > 0 and order[place - 1] in ran

        found = re.findall(r"^DA:(\d+),(\d+)", record, re.MULTILINE)
        lines += [int(count) > 0 for line, count in found if is_inside(line)]
        found = re.findall(r"^BRDA:(\d+),[^,]*,[^,]*,(\S+)", record, re.MULTILINE)
        branches += [taken not in ("-", "0") for line, taken in found if is_inside(line)]
    return {
        "lines": {"reached": sum(lines), "total": len(lines)},
        "branches": {"reached": sum(branches), "total": len(branches)},
    }


WAYS: Final[Mapping[str, Sequence[str]]] = MappingProxyType(
    {"plain": (), "coverage": ("--coverage",), "sanitizers": ("--sanitize", "address,undefined")}
)


def processor_times(turns: int, effort: str, scratch: Path) -> dict[str, list[float]]:
    """Return the processor time of gates of one candidate (s), which take turns in each way."""
    manifest = manifest_of("template c", scratch)
    seconds: dict[str, list[float]] = {way: [] for way in WAYS}
    for turn in range(turns):
        for way, options in WAYS.items():
            before = _seconds_of_children()
            run_gate(manifest, effort, (*options, "--workers", "1"), scratch / f"{way}-{turn}")
            seconds[way].append(round(_seconds_of_children() - before, 1))
    return seconds


def _seconds_of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def write_results(file: Path, table: str, added: Mapping[str, Any]) -> None:
    # Read each time, since another process may have measured something else meanwhile.
    results = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {"rows": {}, "times": {}}
    results[table] |= added
    write_atomically(file, f"{json.dumps(results, indent=1, ensure_ascii=False)}\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rows", nargs="*", metavar="ROW", help="the rows to measure; by default all")
    parser.add_argument("--list", action="store_true", help="print the names of the rows")
    parser.add_argument("--effort", default="default")
    parser.add_argument("--workers", default="", help="number of processes of the gate")
    parser.add_argument("--candidate", type=Path, metavar="FILE", help="the manifest of the one named row")
    parser.add_argument("--turns", type=int, default=0, help="measure the times of gates, so many times each")
    parser.add_argument("--results", type=Path, default=RESULTS)
    options = parser.parse_args()
    known = list(rows())
    if options.list:
        sys.stdout.write("".join(f"{row}\n" for row in known))
        return
    if options.turns:
        with tempfile.TemporaryDirectory() as scratch:
            times = processor_times(options.turns, options.effort, Path(scratch))
        write_results(options.results, "times", times)
        return
    if options.candidate is not None and len(options.rows) != 1:
        parser.error("--candidate needs the name of one row")
    unknown = [] if options.candidate is not None else [row for row in options.rows if row not in known]
    if unknown:
        parser.error(f"there is no row '{unknown[0]}'; known are {', '.join(known)}")
    for row in options.rows or known:
        with tempfile.TemporaryDirectory() as scratch:
            manifest = options.candidate or manifest_of(row, Path(scratch))
            further = ("--workers", options.workers) if options.workers else ()
            result = measured(manifest, options.effort, further, Path(scratch) / "report")
            if options.candidate is not None:
                listed = Path(scratch, "report", "coverage", "coverage.info").read_text(encoding="utf-8")
                result |= {"open": []} | count_of_functions_that_ran(listed, _entry(manifest))
        write_results(options.results, "rows", {row: result})


if __name__ == "__main__":
    main()
