"""How long drivegate takes from its start: to answer, to import, and to a verdict."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from drivegate.contracts.catalogue import CONTRACTS
from drivegate.drives.kinds import DriveKind
from drivegate.studies.bench.workbench import Correctness, NotMeasured, Value, Workbench, duration

LONGEST: Final = 1800.0
"""Time after which a process is given up (s)."""
CACHE_VARIABLES: Final = ("DRIVEGATE_CACHE", "NUMBA_CACHE_DIR")
"""Environment variables that name folders of compiled code."""

_COMMAND_LINE = "from drivegate.commands.command_line import main; main()"


def start_time(bench: Workbench, words: tuple[str, ...], expected: str) -> Value:
    """Measure how long a fresh interpreter takes."""
    times, out = [], ""
    code: int | None = 0
    for _ in range(bench.rounds + 1):
        began = time.perf_counter()
        code, out = _ended(words, bench.scratch, os.environ)
        times.append(time.perf_counter() - began)
    right = code == 0 and expected in out
    measured = f"answers with '{expected}'" if right else f"ends with code {code} and without '{expected}'"
    return duration(times[1:], Correctness(right, measured))


def help_words() -> tuple[str, ...]:
    """Return the arguments of ``drivegate --help``."""
    return ("-c", _COMMAND_LINE, "--help")


def gate_time(bench: Workbench, effort: str, *, kind: DriveKind, cold: bool) -> Value:
    """Measure ``drivegate check`` of the usual candidate on the default drive of a kind, with the report's pages."""
    output = bench.scratch / f"gate-{kind.name}-{'cold' if cold else 'warm'}"
    check = ("check", CONTRACTS[kind.contract].usual_candidate, "--drive", kind.default_drive)
    environment = dict(os.environ)
    if cold:
        # Whatever names a folder of compiled code here must not lead there.
        for name in CACHE_VARIABLES:
            environment.pop(name, None)
        environment["DRIVEGATE_CACHE"] = str(bench.scratch / f"nothing-compiled-{kind.name}")
    words = ("-c", _COMMAND_LINE, *check, "--effort", effort, "--output", str(output), "--json")
    began = time.perf_counter()
    code, out = _ended(words, bench.scratch, environment)
    seconds = time.perf_counter() - began
    verdict, runs = "none", 0
    if out.startswith("{"):
        document = json.loads(out)
        verdict, runs = document.get("verdict", "none"), document.get("runs", 0)
    right = code == 0 and verdict == "pass"
    return duration([seconds], Correctness(right, f"verdict {verdict}, {runs} runs, exit code {code}"))


def _ended(words: tuple[str, ...], folder: Path, environment: Mapping[str, str]) -> tuple[int | None, str]:
    try:
        ended = subprocess.run(
            [sys.executable, *words],
            cwd=folder,
            env=dict(environment),
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=LONGEST,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise NotMeasured(f"it took longer than {LONGEST:.0f} s") from error
    return ended.returncode, ended.stdout
