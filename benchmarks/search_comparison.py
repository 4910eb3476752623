"""Compare ways to search for counterexamples by the runs that they need, and write the result and its figure.

    python -m pip install -e '.[search]' psy-taliro
    python benchmarks/search_comparison.py

What is finished is kept in the result file, so that starting again makes what is missing; --again forgets it. Methods
whose package is not installed are left out.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any, Final

from drivegate_cases.documents.atomic_write import write_atomically
from measured_text import SEARCHING, write_measured
from search_figure import tables, write_figure
from search_methods import METHODS
from search_trials import COMPARED, SEEDS, Cell, done
from weakened_faults import FAULTS

HERE: Final = Path(__file__).resolve().parent
RESULT: Final = HERE / "search_comparison.json"
FIGURE: Final = HERE.parent / "docs" / "images" / "search-comparison.svg"


def cells(known: dict[str, Any]) -> Iterator[Cell]:
    """List the trials, those of faults with a size at the severities that are known."""
    for number, fault in enumerate(FAULTS):
        for method in COMPARED:
            for seed in SEEDS:
                if fault.shape == "sudden":
                    yield Cell(number, method, seed)
                else:
                    for level, severity in enumerate(known[fault.name]["severities"]):
                        yield Cell(number, method, seed, level, severity)


def work(wanted: Iterable[Cell], document: dict[str, Any], workers: int, result: Path) -> None:
    """Do what is missing, and keep every finished piece."""
    # The first seeds of all faults say more than all seeds of the first; the shard's can be made again alone.
    missing = sorted(
        (cell for cell in wanted if cell.key not in document["cells"]),
        key=lambda cell: (cell.method == "shard", cell.seed),
    )
    with ProcessPoolExecutor(workers) as pool:
        running = [pool.submit(done, cell) for cell in missing]
        for count, ended in enumerate(as_completed(running), start=1):
            key, outcome = ended.result()
            document["cells"][key] = outcome
            if count % 5 == 0 or count == len(missing):
                write_atomically(result, json.dumps(document, indent=1, sort_keys=True) + "\n")


def known_cells(result: Path, again: str | None) -> dict[str, Any]:
    """Read the finished pieces, without those that are to be made again: of a method, or all."""
    if again == "all" or not result.exists():
        return {}
    known: dict[str, Any] = json.loads(result.read_text(encoding="utf-8"))["cells"]
    return {key: cell for key, cell in known.items() if again is None or f"/{again}/" not in key}


def main() -> None:
    """Run what is missing, and write result and figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument(
        "--again",
        nargs="?",
        const="all",
        choices=["all", *METHODS],
        help="forget the trials that the result file holds, or those of one method",
    )
    parser.add_argument("--result", type=Path, default=RESULT)
    parser.add_argument("--figure", type=Path, default=FIGURE)
    parser.add_argument("--page", type=Path, default=SEARCHING, help="page whose tables are written again")
    options = parser.parse_args()
    document: dict[str, Any] = {"cells": known_cells(options.result, options.again)}
    rarenesses = [Cell(number) for number, fault in enumerate(FAULTS) if fault.shape != "sudden"]
    work(rarenesses, document, options.workers, options.result)
    work(cells(document["cells"]), document, options.workers, options.result)
    write_figure(document["cells"], options.figure)
    write_measured(options.page, "search tables", tables(document["cells"]))


if __name__ == "__main__":
    main()
