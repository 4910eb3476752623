"""Time until the command line answers."""

import subprocess
import sys
from typing import Any

BAR = 0.3


def _help() -> None:
    subprocess.run(
        [sys.executable, "-c", "from drivegate.commands.command_line import main; main(['--help'])"],
        check=True,
        capture_output=True,
    )


def test_help(benchmark: Any) -> None:
    benchmark.pedantic(_help, rounds=7, warmup_rounds=1)
    seconds = float(benchmark.stats.stats.min)
    assert seconds < BAR, f"--help answers after {seconds:.2f} s, the bar is {BAR} s"
