"""Jobs for the tests of judges; judges' processes import this module by its name."""

import os
import signal
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numba.core import caching

from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.current.timed_steps import given_steps
from drivegate.gate import warm_up
from drivegate_models.compilation import kernels
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.errors import InputError
from drivegate_models.loop.given_steps import senses_of

NAMEPLATE = Nameplate(
    *(5, 11, 48.0, 52.36, 1500.0, 26.0, 0.0005, 0.25, 0.08, 0.00288, 0.339, 0.05),
    *(1, 2.513, 4.0, 0.576, 0.00417, 157.08),
)


def drive(loaded: JudgedCandidate, steps: int) -> float:
    """Step the candidate through a run without a plant, and return the sum of its references."""
    signals = np.broadcast_to([100.0, 99.0, 5.0, 48.0], (steps, 4))
    senses, currents = senses_of(signals, NAMEPLATE.phases, NAMEPLATE.control_period)
    currents[:] = 1.0
    answers = given_steps(loaded.controller(), NAMEPLATE).answers(senses, currents)
    return float(answers["current_reference"].sum())


def wait_for_the_system(_loaded: JudgedCandidate, _payload: None) -> None:
    """Wait as for a file that another process has leased: without any processor time."""
    signal.pause()


def drive_slowly(loaded: JudgedCandidate, steps: int) -> tuple[float, float, float]:
    """Drive, then take longer than a process needs to start; tell when that was."""
    began = time.monotonic()
    total = drive(loaded, steps)
    time.sleep(1.5)
    return total, began, time.monotonic()


def sleep_by_turns(loaded: JudgedCandidate, index: int) -> int:
    """Take longer for earlier jobs, so that they end in another order than they began."""
    time.sleep(0.05 * (3 - index % 4))
    return index


def harness_error(loaded: JudgedCandidate, payload: Any) -> None:
    raise LookupError("a mistake of the harness")


def user_error(loaded: JudgedCandidate, payload: Any) -> None:
    raise InputError("the scenario is wrong")


def unpicklable(loaded: JudgedCandidate, payload: Any) -> Any:
    return lambda: None


def surroundings(loaded: JudgedCandidate, payload: Any) -> dict[str, Any]:
    """Return what a judge's process finds around it."""
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    opened = [each for each in Path("/proc/self/fd").iterdir() if each.is_symlink()]
    return {
        "environment": dict(os.environ),
        "folder": str(Path.cwd()),
        "status": {
            name: status[name] for name in ("Umask", "SigBlk", "SigIgn", "SigCgt", "CapEff", "Cpus_allowed")
        },
        "limits": Path("/proc/self/limits").read_text(),
        "opened": sorted(str(each.readlink()).partition(":")[0] for each in opened),
        "output": [str(Path(f"/proc/self/fd/{number}").readlink()) for number in (1, 2)],
        "leads": os.getsid(0) == os.getpid(),
        "kernels": (kernels._ONLY_READS, kernels._FOLDER, kernels.KEEPS_CACHE),
        "numba": kernels.numba.config.CACHE_DIR,
        "path": sys.path,
        "keeps temporary files apart": tempfile.gettempdir() != os.environ["TMPDIR"],
    }


PREPARED: list[str] = []
"""What this process has prepared, or the template that it is a copy of."""


def prepare(what: str) -> None:
    """Prepare copies of this process."""
    if what == "nothing":
        raise LookupError("there is nothing to prepare")
    PREPARED.append(what)


def prepared(loaded: JudgedCandidate, payload: Any) -> list[str]:
    """Return what this process has prepared."""
    return PREPARED


def kernels_loaded(loaded: JudgedCandidate, kind: str) -> int:
    """Judge a run on a kind of drive, and return how many kernels have been loaded for it."""
    load = caching.Cache.load_overload
    loaded_now = []

    def load_overload(*arguments: Any) -> Any:
        loaded_now.append(arguments)
        return load(*arguments)

    caching.Cache.load_overload = load_overload
    warm_up._judge_a_run(loaded, kind)
    return len(loaded_now)


def kill_this_process(_loaded: JudgedCandidate, _payload: None) -> None:
    os.kill(os.getpid(), signal.SIGKILL)
