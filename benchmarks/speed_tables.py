"""Measure everything and write the tables of docs/speed.md again, between the two marks in it.

    python benchmarks/speed_tables.py
    python benchmarks/speed_tables.py --python motulator=VENV/bin/python --python gym_electric_motor=VENV/bin/python

It refuses a machine that does something else besides, unless --busy is given. A peer that is not installed gets a line
that says so; --python names the interpreter of one that lives in an environment of its own.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from measured_text import write_measured
from yardstick import FLAGS

HERE = Path(__file__).resolve().parent
PAGE = HERE.parent / "docs" / "speed.md"
OWN = "loop.reference.1500.ideal"
MOST_LOAD = 0.5


def measured(words: list[str]) -> dict[str, Any]:
    """Run the bench and return its document."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "bench.json"
        command = [sys.executable, str(HERE / "source_bench.py"), *words, "--output", str(file)]
        ended = subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
        if ended.returncode != 0:
            raise SystemExit(f"the bench ended with exit code {ended.returncode}; no table is written")
        document: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        return document


def measured_peers(interpreters: dict[str, str]) -> list[dict[str, Any]]:
    """Run each peer, and return what it printed or why it printed nothing."""
    rows = []
    for peer in sorted((HERE / "peers").glob("*.py")):
        name = peer.stem.removesuffix("_drive")
        command = [interpreters.get(name, sys.executable), str(peer)]
        ended = subprocess.run(command, capture_output=True, encoding="utf-8", check=False)
        reason = (ended.stderr.strip().splitlines() or ["it printed nothing"])[-1]
        rows.append(json.loads(ended.stdout) if ended.stdout else {"peer": name, "reason": reason})
    return rows


def number(value: float | None) -> str:
    """Write a number with three digits."""
    if value is None:
        return "–"
    return f"{value:,.0f}" if abs(value) >= 1000.0 else f"{value:#.3g}".rstrip(".")


def heading(document: dict[str, Any]) -> list[str]:
    """State where and when."""
    machine, packages = document["machine"], document["provenance"]["packages"]
    loads = " before and ".join(
        "unknown" if load is None else f"{load:.2f}" for load in document["load_average"]
    )
    return [
        f"Measured with `{document['command']}` on {document['started_utc'][:16].replace('T', ' ')} UTC:",
        f"{machine['processor']}, {machine['processors']} processors, {machine['system']}, load average {loads} after;",
        f"drivegate {document['provenance']['drivegate']}, Python {document['provenance']['python']}, "
        f"numba {packages['numba']}, numpy {packages['numpy']}.",
        f"The yardstick is compiled with `cc {' '.join(FLAGS)}`.",
        "",
    ]


def loop_table(rows: dict[str, dict[str, Any]]) -> list[str]:
    """Write the closed loop's rates, a line for each candidate and kind of sensors."""
    parts = [name.split(".") for name in rows if name.startswith("loop.")]
    speeds = list(dict.fromkeys(part[2] for part in parts))
    kinds = list(dict.fromkeys((part[1], part[3]) for part in parts))
    lines = [
        "Closed loop, simulated seconds a second on one processor:",
        "",
        f"| candidate | sensors | {' | '.join(f'{speed} rpm' for speed in speeds)} |",
        f"|---|---|{'---:|' * len(speeds)}",
    ]
    for candidate, sensors in kinds:
        cells = (number(rows[f"loop.{candidate}.{speed}.{sensors}"]["value"]) for speed in speeds)
        lines.append(f"| {candidate} | {sensors} | {' | '.join(cells)} |")
    return [*lines, ""]


def other_table(rows: dict[str, dict[str, Any]]) -> list[str]:
    """Write all other rows that have a value; the bench ends with an error where a check of one fails."""
    lines = ["Checks run at default effort.", "", "| what | value | bar |", "|---|---:|---:|"]
    for name, row in rows.items():
        if not name.startswith("loop.") and row["value"] is not None:
            bar = (
                ""
                if row["bar"] is None
                else f"{'≥' if row['better'] == 'more' else '≤'} {number(row['bar'])}"
            )
            value = f"{number(row['value'])} {row['unit']}"
            cells = (row["title"], value, bar)
            lines.append("| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |")
    return [*lines, ""]


def peer_table(peers: list[dict[str, Any]], own: float) -> list[str]:
    """Write the peers beside drivegate's own rate."""
    lines = [
        f"Peers, each on its own job; drivegate's {number(own)} is its native reference at 1500 rpm:",
        "",
        "| peer | job | × real time | drivegate over it |",
        "|---|---|---:|---:|",
    ]
    for peer in peers:
        if "reason" in peer:
            lines.append(f"| {peer['peer']} | {peer['reason']} | – | – |")
            continue
        rate = peer["times_real_time"]
        job = peer["job"] if peer["valid"] else f"WRONG: {peer['check']}"
        rates = f"{number(rate)} | {number(own / rate)}" if peer["valid"] else "– | –"
        lines.append(f"| {peer['peer']} {peer['version']} | {job} | {rates} |")
    return [*lines, ""]


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few and short rounds, nothing cold")
    parser.add_argument("--python", action="append", default=[], metavar="PEER=PYTHON")
    parser.add_argument("--busy", action="store_true", help="measure whatever else runs")
    options = parser.parse_args()
    load = os.getloadavg()[0]
    if load > MOST_LOAD and not options.busy:
        raise SystemExit(
            f"the load average is {load:.2f}, above {MOST_LOAD}: the machine is not quiet; see --busy"
        )
    interpreters = dict(one.split("=", 1) for one in options.python)
    document = measured(["--quick"] if options.quick else ["--cold"])
    rows = {row["name"]: row for row in document["rows"]}
    peers = measured_peers(interpreters)
    lines = [
        *heading(document),
        *loop_table(rows),
        *other_table(rows),
        *peer_table(peers, rows[OWN]["value"]),
    ]
    write_measured(PAGE, "tables", "\n".join(lines).rstrip())


if __name__ == "__main__":
    main()
