"""Compare ways to search for counterexamples by the runs that they need, and write the result and its figure.

    python -m pip install -e '.[search]'
    python benchmarks/search_comparison.py

What is finished is kept in the result file, so that starting again makes what is missing; --again forgets it.
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
from search_trials import SLOW_CHECKS, Cell, done, seeds
from weakened_faults import FAULTS

HERE: Final = Path(__file__).resolve().parent
RESULT: Final = HERE / "search_comparison.json"
FIGURE: Final = HERE.parent / "docs" / "images" / "search-comparison.svg"


def cells(known: dict[str, Any]) -> Iterator[Cell]:
    """List the trials, those of faults with a size at the severities that are known by now."""
    for number, fault in enumerate(FAULTS):
        for method in METHODS:
            for seed in seeds(fault, method):
                if fault.shape == "sudden":
                    yield Cell(number, method, seed)
                elif fault.name in known:
                    for level, severity in enumerate(known[fault.name]["severities"]):
                        yield Cell(number, method, seed, level, severity)


def _slowness(cell: Cell) -> int:
    check = FAULTS[cell.fault].check
    return 1 + SLOW_CHECKS.index(check) if check in SLOW_CHECKS else 0


def work(wanted: Iterable[Cell], document: dict[str, Any], workers: int, result: Path) -> None:
    """Do what is missing, and keep every finished piece."""
    # What is quick comes first, and of what is slow every fault's first seed.
    missing = sorted(
        (cell for cell in wanted if cell.key not in document["cells"]),
        key=lambda cell: (_slowness(cell), bool(cell.method), cell.seed),
    )
    with ProcessPoolExecutor(workers) as pool:
        running = [pool.submit(done, cell) for cell in missing]
        for count, ended in enumerate(as_completed(running), start=1):
            key, outcome, seconds = ended.result()
            document["cells"][key] = outcome
            document["processor_seconds"] += seconds
            if count % 5 == 0 or count == len(missing):
                write_atomically(result, json.dumps(document, indent=1, sort_keys=True) + "\n")


def main() -> None:
    """Run what is missing, and write result and figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--again", action="store_true", help="forget the trials that the result file holds")
    parser.add_argument("--result", type=Path, default=RESULT)
    parser.add_argument("--figure", type=Path, default=FIGURE)
    parser.add_argument("--page", type=Path, default=SEARCHING, help="page whose tables are written again")
    options = parser.parse_args()
    document: dict[str, Any] = {"cells": {}, "processor_seconds": 0.0}
    if options.result.exists() and not options.again:
        document = json.loads(options.result.read_text(encoding="utf-8"))
    rarenesses = [Cell(number) for number, fault in enumerate(FAULTS) if fault.shape != "sudden"]
    quick = [cell for cell in rarenesses if FAULTS[cell.fault].check not in SLOW_CHECKS]
    # What takes longest to find out goes beside the trials that need not wait for it.
    work(quick, document, options.workers, options.result)
    work([*rarenesses, *cells(document["cells"])], document, options.workers, options.result)
    work(cells(document["cells"]), document, options.workers, options.result)
    write_figure(document, options.figure)
    write_measured(options.page, "search tables", tables(document))


if __name__ == "__main__":
    main()
