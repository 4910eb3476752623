"""Measure what the gate reaches of the templates and examples: ``python benchmarks/code_coverage.py``.

It prints the table of docs/code_coverage.md. Templates are written into a temporary folder. With ``--effort default``,
each gate draws nine times as many scenarios.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

EXAMPLES: Final = Path(__file__).parents[1] / "examples"
TEMPLATES: Final = ("c", "c++", "embedded-coder", "rust", "python", "cortex-m")
COUNTED_EXAMPLES: Final = ("c", "python", "firmware/interrupt", "firmware/objects", "firmware/crate")
_NOT_COUNTED: Final = "not counted"


def checked(candidate: Path, effort: str, folder: Path) -> dict[str, Any]:
    """Run the gate with coverage, and return its result."""
    words = [
        "check",
        str(candidate),
        "--coverage",
        "--effort",
        effort,
        "--seed",
        "0",
        "-q",
        "--output",
        str(folder),
    ]
    subprocess.run([sys.executable, "-m", "drivegate", *words], check=False, stdout=subprocess.DEVNULL)
    result: dict[str, Any] = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    return result


def row(name: str, result: dict[str, Any]) -> str:
    section = result["code_coverage"]
    counts = [f"{section[noun]['reached']} of {section[noun]['total']}" for noun in ("lines", "branches")]
    if not section["branches"]["total"]:
        counts[1] = _NOT_COUNTED
    places = [
        f"`{file['name']}` {', '.join(map(str, _open(file)))}" for file in section["files"] if _open(file)
    ]
    return f"| {name} | {' | '.join(counts)} | {'; '.join(places) or 'none'} |"


def _open(file: dict[str, Any]) -> list[int]:
    """Return the numbers of the lines that are not reached, or not in all ways."""
    return sorted({*file["unreached_lines"], *(line for line, _ in file["unreached_branches"])})


def _candidates(scratch: Path) -> Iterator[tuple[str, Path]]:
    for kind in TEMPLATES:
        name = kind.replace("+", "p")
        words = [sys.executable, "-m", "drivegate", "new", kind, name, "--ci", "none"]
        subprocess.run(words, check=True, cwd=scratch, stdout=subprocess.DEVNULL)
        yield f"template `{kind}`", scratch / name / "candidate.toml"
    for name in COUNTED_EXAMPLES:
        yield f"`examples/{name}`", EXAMPLES / name / "candidate.toml"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--effort", default="quick")
    effort = parser.parse_args().effort
    sys.stdout.write("| code | lines | branches | lines not reached in all ways |\n|---|---|---|---|\n")
    with tempfile.TemporaryDirectory() as scratch:
        for number, (name, candidate) in enumerate(_candidates(Path(scratch))):
            result = checked(candidate, effort, Path(scratch) / f"report-{number}")
            sys.stdout.write(f"{row(name, result)}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
