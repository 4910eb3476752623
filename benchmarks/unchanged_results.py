"""List what drivegate's commands answer, so that two lists show whether a change of the code has changed any result.

    python benchmarks/unchanged_results.py before.txt --keep before     # on the old code
    python benchmarks/unchanged_results.py after.txt --keep after       # on the new code
    diff before.txt after.txt && diff -r before after                   # nothing, or what to explain

Each line has the exit code of one command and a hash of its JSON document without provenance, times and wording: a text
with a space is wording. With --keep the stripped documents are stored, one file a command, to see what differs.
--only takes a part of a line's name. The whole list takes about half an hour on two processors.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from joblib import Parallel, delayed

_ROOT: Final = Path(__file__).resolve().parent.parent
_CURRENT_DRIVES: Final = (
    "paper-5-phase",
    "fan-3-phase",
    "traction-7-phase",
    "star-3-phase",
    "star-24v-3-phase",
)
_DUTY_DRIVES: Final = ("pm-ac-surface", "pm-ac-interior", "pm-ac-2kw", "pm-ac-msl")
_SEEDS: Final = (0, 1, 2)
_DRAWN: Final = 20
_FAULTS: Final = {
    "paper-5-phase": ("power-one-percent-high", "blind-spot", "no-anti-windup"),
    "pm-ac-interior": ("swapped-axes", "late-samples", "patient-stall-watch"),
}
_CHANGING: Final = frozenset({"provenance", "timing", "signature", "traceback", "output", "report", "folder"})
_AT_ONCE: Final = 2
_COMMANDS: Final = (
    *(
        "bench",
        "campaign",
        "cases",
        "check",
        "checks",
        "compare",
        "diff",
        "drive",
        "include-dir",
        "map",
    ),
    *("new", "point", "replay", "report", "reproduce", "selftest", "simulate", "verify"),
)


@dataclass(frozen=True)
class Row:
    """One command of the list: its name there, its words, and the words of what has to run before it."""

    name: str
    words: tuple[str, ...]
    first: tuple[str, ...] = ()


def rows(scratch: Path) -> Iterator[Row]:
    """List the commands; what they write goes to folders below `scratch`."""
    yield from _checks(scratch)
    yield from _studies(scratch)
    for name in _COMMANDS:
        yield Row(f"help {name}", (name, "--help"))


def _checks(scratch: Path) -> Iterator[Row]:
    examples = _ROOT / "examples"
    for candidate in ("reference", "published", "initial"):
        for seed in _SEEDS:
            yield _check(scratch, candidate, "paper-5-phase", seed)
        for drive in _CURRENT_DRIVES[1:]:
            yield _check(scratch, candidate, drive, 0)
    for candidate in ("foc", "direct-torque"):
        for seed in _SEEDS:
            yield _check(scratch, candidate, "pm-ac-interior", seed)
    for candidate in ("foc", "inner:pi:reference"):
        for drive in _DUTY_DRIVES:
            if (candidate, drive) != ("foc", "pm-ac-interior"):
                yield _check(scratch, candidate, drive, 0)
    for kind in ("c", "python", "compose", "numba"):
        yield _check(scratch, str(examples / kind / "candidate.toml"), "paper-5-phase", 0, f"example {kind}")
    firmware = scratch / "firmware"
    made = ("new", "embedded-coder", str(firmware))
    row = _check(scratch, str(firmware / "candidate.toml"), "pm-ac-interior", 0, "template embedded-coder")
    yield Row(row.name, row.words, made)


def _check(scratch: Path, candidate: str, drive: str, seed: int, name: str | None = None) -> Row:
    label = f"check {name or candidate} {drive} {seed}"
    words = ("check", candidate, "--drive", drive, "--effort", "quick", "--seed", str(seed), "--workers", "1")
    return Row(label, (*words, "--output", str(scratch / re.sub(r"\W+", "-", label)), "--json"))


def _studies(scratch: Path) -> Iterator[Row]:
    step = str(_ROOT / "examples" / "campaign" / "pm-ac-step-up.toml")
    duty = ("--case", step)
    for case in ("fig5-search", "lock-up"):
        yield Row(f"simulate {case}", ("simulate", "reference", "--case", case, "--json"))
        yield Row(f"diff {case}", ("diff", "initial", "published", "--case", case, "--json"))
    yield Row("simulate duty", ("simulate", "foc", *duty, "--json"))
    yield Row("diff duty", ("diff", "foc", "foc-mtpa", *duty, "--json"))
    for name, candidates, drives in (
        ("current", ("reference", "initial"), ("paper-5-phase",)),
        ("current drives", ("reference", "initial"), ("paper-5-phase", "star-3-phase")),
        ("duty", ("foc", "direct-torque"), ("pm-ac-interior",)),
        ("duty drives", ("foc", "direct-torque"), ("pm-ac-interior", "pm-ac-surface")),
    ):
        taken = tuple(word for drive in drives for word in ("--drive", drive))
        words = ("compare", *candidates, *taken, "--effort", "quick", "--no-checks", "--workers", "1")
        yield Row(f"compare {name}", (*words, "--output", str(scratch / f"compare-{name}"), "--json"))
    for campaign in ("spread", "pm-ac"):
        file = str(_ROOT / "examples" / "campaign" / f"{campaign}.toml")
        output = str(scratch / f"campaign-{campaign}")
        yield Row(f"campaign {campaign}", ("campaign", file, "--output", output, "--workers", "1", "--json"))
    for drive in (*_CURRENT_DRIVES, *_DUTY_DRIVES):
        yield Row(f"drive {drive}", ("drive", drive, "--json"))
    axes = ("--speed-rpm", "700,1000", "--torque-nm", "5,9")
    yield Row("map best", ("map", *axes, "--json"))
    yield Row("map reference", ("map", "reference", *axes, "--json"))
    point = ("--speed-rpm", "1500", "--advance-deg", "52", "--torque-nm", "9")
    yield Row("point", ("point", *point, "--json"))
    for candidate, drive in (("published", "paper-5-phase"), ("faulty:swapped-axes", "pm-ac-interior")):
        report = scratch / f"replayed-{drive}"
        words = ("check", candidate, "--drive", drive, "--effort", "quick", "--output", str(report), "--json")
        yield Row(f"replay {drive}", ("replay", str(report), "--json"), words)
    for drive, faults in _FAULTS.items():
        named = tuple(word for fault in faults for word in ("--fault", fault))
        yield Row(f"selftest {drive}", ("selftest", "--drive", drive, "--effort", "quick", *named, "--json"))
    for kind in ("half-bridge", "pm-ac"):
        words = (
            "selftest",
            "--drives",
            str(_DRAWN),
            "--kind",
            kind,
            "--output",
            str(scratch / f"drawn-{kind}"),
        )
        yield Row(f"drawn {kind}", (*words, "--json"))
    yield Row("cases", ("cases", "--json"))
    yield Row("checks", ("checks", "--json"))


def _answer(words: tuple[str, ...], where: Path) -> tuple[int, str]:
    command = [str(Path(sys.executable).with_name("drivegate")), *words]
    done = subprocess.run(command, cwd=where, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout


def _stripped(value: Any, key: str = "") -> Any:
    """Leave out what may differ between two codes of the same behaviour: wording, times, and hashes of sources."""
    if isinstance(value, dict):
        kept = {
            name: _stripped(part, name)
            for name, part in value.items()
            if name not in _CHANGING and (name != "hash" or key == "drive")
        }
        return dict(sorted(kept.items()))
    if isinstance(value, list):
        return [_stripped(part, key) for part in value]
    if isinstance(value, str) and (" " in value or "/" in value):
        return ""
    return value


def listed(row: Row, where: Path, keep: Path | None) -> str:
    """Run one command and return its line."""
    if row.first:
        _answer(row.first, where)
    code, text = _answer(row.words, where)
    if row.name.startswith("help "):
        shown: Any = sorted(set(re.findall(r"--[a-z-]+", text)))
    else:
        try:
            shown = _stripped(json.loads(text))
        except ValueError:
            shown = f"no JSON document: {text[:200]!r}"
    lines = json.dumps(shown, indent=1)
    if keep is not None:
        (keep / f"{re.sub(r'[^a-z0-9-]+', '-', row.name.lower())}.json").write_text(
            lines + "\n", encoding="utf-8"
        )
    return f"{hashlib.sha256(lines.encode()).hexdigest()[:16]} {code} {row.name}"


def main() -> None:
    """Run the commands, and write their lines in a fixed order."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("list", type=Path, help="file that receives the list")
    parser.add_argument("--keep", type=Path, help="folder that receives the stripped documents")
    parser.add_argument(
        "--only", action="append", default=[], help="a part of the names of lines; may be repeated"
    )
    options = parser.parse_args()
    if options.keep is not None:
        options.keep.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        chosen = [
            row for row in rows(scratch) if not options.only or any(part in row.name for part in options.only)
        ]
        jobs = (delayed(listed)(row, scratch, options.keep) for row in chosen)
        lines = []
        for line in Parallel(_AT_ONCE, prefer="threads", return_as="generator")(jobs):
            sys.stderr.write(f"{line}\n")
            lines.append(line)
    options.list.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
