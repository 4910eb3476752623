"""Compare the gate of each drive on a dc link with a capacitor with that of the same drive on an ideal link.

    python benchmarks/link_cost.py                        # foc, quick effort, two turns
    python benchmarks/link_cost.py load-observer --turns 4 --drive pm-ac-hub

The ideal drive is the same document without `[link]`. The first check of each drive is not measured, because it may
compile kernels. In each turn both are then checked, in alternating order. Columns: processor time of the whole check
(s), number of runs, processor time of a run (s), each with that of the ideal drive after it; the ratios of whole checks
and of runs are medians over the turns.
"""

from __future__ import annotations

import argparse
import json
import re
import resource
import subprocess
import sys
import tempfile
from importlib.resources import files
from pathlib import Path
from statistics import median
from typing import NamedTuple

LINKED = ("pm-ac-servo-48v", "pm-ac-hub", "pm-ac-chopper")


class Cost(NamedTuple):
    """What one check took."""

    seconds: float
    """Processor time (s)."""
    runs: int
    """Number of runs."""


def written(drive: str, folder: Path) -> tuple[Path, Path]:
    """Write the document of a linked drive, and the same without `[link]` and its provenance; return both files."""
    document = (files("drivegate_cases") / "drives" / f"{drive}.toml").read_text(encoding="utf-8")
    ideal = re.sub(r"(?ms)^\[link\]\n.*?(?=^\[)", "", document)
    ideal = re.sub(r"(?m)^link\..*\n", "", ideal)
    if "link." in ideal or "[link]" in ideal or ideal == document:
        raise SystemExit(f"{drive} has no [link], so that there is nothing to compare")
    both = folder / f"{drive}.toml", folder / f"{drive}-ideal.toml"
    for file, text in zip(both, (document, ideal), strict=True):
        file.write_text(text, encoding="utf-8")
    return both


def cost(candidate: str, drive: Path, effort: str) -> Cost:
    """Check a candidate on a drive with one worker, and return what it took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    program = str(Path(sys.executable).with_name("drivegate"))
    words = [candidate, "--drive", str(drive), "--effort", effort, "--workers", "1", "--seed", "0", "--json"]
    done = subprocess.run(
        [program, "check", *words, "--output", str(drive.with_suffix(""))],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        check=False,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 1):
        raise SystemExit(f"drivegate check {' '.join(words)} ended with {done.returncode}")
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Cost(seconds, json.loads(done.stdout)["runs"])


def compared(candidate: str, drives: tuple[Path, Path], effort: str, turns: int) -> str:
    """Return a line of the costs of a drive and of the same on an ideal link."""
    for drive in drives:
        cost(candidate, drive, effort)
    costs: list[tuple[Cost, Cost]] = []
    for turn in range(turns):
        order = (0, 1) if turn % 2 == 0 else (1, 0)
        found = {place: cost(candidate, drives[place], effort) for place in order}
        costs.append((found[0], found[1]))
    whole = median(linked.seconds / ideal.seconds for linked, ideal in costs)
    linked, ideal = (
        Cost(median(each[place].seconds for each in costs), costs[0][place].runs) for place in (0, 1)
    )
    each = whole * ideal.runs / linked.runs
    return (
        f"{drives[0].stem:18} {linked.seconds:7.1f} {ideal.seconds:7.1f} {linked.runs:6} {ideal.runs:6} "
        f"{linked.seconds / linked.runs:7.3f} {ideal.seconds / ideal.runs:7.3f} {whole:6.2f} {each:6.2f}"
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("candidate", nargs="?", default="foc")
    parser.add_argument("--drive", action="append", help="a drive with a [link]; all three if left out")
    parser.add_argument("--effort", default="quick")
    parser.add_argument("--turns", type=int, default=2, help="how often both are measured")
    options = parser.parse_args()
    sys.stdout.write(
        f"{'drive':18} {'linked':>7} {'ideal':>7} {'runs':>6} {'ideal':>6} {'s/run':>7} {'ideal':>7} "
        f"{'whole':>6} {'run':>6}\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        for drive in options.drive or LINKED:
            drives = written(drive, Path(folder))
            sys.stdout.write(compared(options.candidate, drives, options.effort, options.turns) + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
