"""Compare the speed of two installations of drivegate, turn by turn.

    python benchmarks/in_turns.py BEFORE/bin/drivegate AFTER/bin/drivegate --turns 6 --only loop.reference

In each turn both run ``drivegate bench`` with the options given here, in alternating order, and the one that comes last
sets its numbers beside those of the other. What else the machine does slows both of a turn, so the median over the
turns says more than the best of each; the range says how far to trust it. Above 1, AFTER is better.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median


def turn(programs: list[str], words: list[str], folder: Path) -> dict[str, float]:
    """Measure with both programs; return for each row how many times as good the last one is."""
    first, last = str(folder / "first.json"), str(folder / "last.json")
    kept = (["--output", first], ["--output", last, "--compare", first])
    for program, files in zip(programs, kept, strict=True):
        command = [program, "bench", *words, *files]
        if subprocess.run(command, stdout=subprocess.DEVNULL, check=False).returncode != 0:
            raise SystemExit(f"{program} bench failed, so that nothing is compared")
    rows = json.loads(Path(last).read_text(encoding="utf-8"))["rows"]
    return {row["name"]: row["times_as_good"] for row in rows if row["times_as_good"] is not None}


def table(turns: list[dict[str, float]]) -> str:
    """Write a line for each row that every turn measured."""
    lines = [f"{'name':30} median  least   most"]
    for name in turns[0]:
        if all(name in one for one in turns):
            ratios = [one[name] for one in turns]
            lines.append(f"{name:30} {median(ratios):6.3f} {min(ratios):6.3f} {max(ratios):6.3f}")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", help="the earlier installation's drivegate")
    parser.add_argument("after", help="the later installation's drivegate")
    parser.add_argument("--turns", type=int, default=6, help="how often both are measured")
    options, words = parser.parse_known_args()
    turns = []
    for number in range(options.turns):
        programs, is_reversed = [options.before, options.after], number % 2 == 1
        with tempfile.TemporaryDirectory() as folder:
            ratios = turn(programs[::-1] if is_reversed else programs, words, Path(folder))
        turns.append({name: 1.0 / ratio if is_reversed else ratio for name, ratio in ratios.items()})
    sys.stdout.write(table(turns))


if __name__ == "__main__":
    main()
