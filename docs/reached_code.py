"""The table of what the gate reaches of code, from what ``benchmarks/code_coverage.py`` has measured."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from statistics import median
from types import MappingProxyType
from typing import Any, Final

RESULTS: Final = Path(__file__).parents[1] / "benchmarks" / "code_coverage.json"

WHY: Final[Mapping[str, str]] = MappingProxyType(
    {
        "template embedded-coder": "a torque beyond the limits against the error of the speed",
        "template c --sensorless": "restart and size of the included `controller.c`; torque references, an EMF "
        "above the link, a stop, keys of the nameplate that are left out",
        "examples/c": "an offset of the search below 0 where a load rises",
        "examples/firmware/interrupt": "a machine without saliency, a current beyond the limit, an EMF above the link",
        "ODrive, current control and modulation": "voltage control and missing measurements, by settings",
        "VESC, `foc_math` and `utils_math`": "other observers, by settings",
        "SimpleFOC, motor, sensor and regulators": "other modulations and modes, alignment of sensors, by settings",
    }
)
"""Why something is not reached, by the name of the row."""

NOT_COUNTED: Final = "not counted"
ALL_REACHED: Final = "nothing"


def measured_rows() -> dict[str, dict[str, Any]]:
    rows: dict[str, dict[str, Any]] = json.loads(RESULTS.read_text(encoding="utf-8"))["rows"]
    return rows


def is_whole(row: Mapping[str, Any]) -> bool:
    """Return True if everything in a row was reached."""
    return all(row[noun]["reached"] == row[noun]["total"] for noun in ("lines", "branches"))


def reached_rows() -> list[tuple[str, ...]]:
    """Return the cells of each row: code, effort, lines, branches, what is not reached."""
    return [
        (
            _named(name),
            row["effort"],
            _count(row["lines"]),
            _count(row["branches"]),
            ALL_REACHED if is_whole(row) else WHY[name],
        )
        for name, row in measured_rows().items()
    ]


def _named(name: str) -> str:
    kind, _, rest = name.partition("template ")
    return f"template `{rest}`" if not kind else f"`{name}`" if name.startswith("examples/") else name


def _count(count: Mapping[str, int]) -> str:
    return f"{count['reached']} of {count['total']}" if count["total"] else NOT_COUNTED


def time_ratios() -> tuple[int, float, float]:
    """Return the number of turns, and the medians of how many times as long gates compute to count and to sanitize."""
    times = json.loads(RESULTS.read_text(encoding="utf-8"))["times"]
    counting, sanitizing = (
        median(one / plain for one, plain in zip(times[way], times["plain"], strict=True))
        for way in ("coverage", "sanitizers")
    )
    return len(times["plain"]), counting, sanitizing
