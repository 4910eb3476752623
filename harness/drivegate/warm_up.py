"""Compiling the kernels once, before worker processes start, so that none of them compiles beside another."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from drivegate.builtin_candidates import BUILTIN_CANDIDATES
from drivegate.candidate_resolution import resolve_candidate
from drivegate.containment.messages import Job, LoadedCandidate
from drivegate.containment.stall_watch import WorkerLimits
from drivegate.containment.worker import CandidateWorker
from drivegate.controller_loading import load_controller
from drivegate.fault import Fault
from drivegate.feasibility import is_feasible
from drivegate.fixed_scenarios import fixed_scenarios
from drivegate.run_record import recorded
from drivegate.search_shard import judged
from drivegate_models.compilation import choose_cache_folder
from drivegate_models.errors import HarnessFault

MARKER = "all-kernels"
"""Name of the file in the cache folder that tells that every kernel has been compiled."""

_LIMITS = WorkerLimits(start_processor_seconds=3600.0, idle_seconds=600.0)


def missing_marker() -> Path | None:
    """Tell whether the kernels are still to be compiled.

    Returns
    -------
    Path or None
        The file that `compile_kernels` writes; None when it is there, or where nothing can be kept anyway.
    """
    folder = choose_cache_folder()
    if folder is None:
        return None
    marker = folder / MARKER
    return None if marker.exists() else marker


def compile_kernels(marker: Path) -> None:
    """Compile every kernel in a process of its own, and note that it is done.

    Parameters
    ----------
    marker : Path
        The file to write.

    Raises
    ------
    HarnessFault
        When a kernel fails.
    """
    candidate = resolve_candidate(next(iter(BUILTIN_CANDIDATES)))
    with CandidateWorker(candidate, load_controller, limits=_LIMITS) as worker:
        outcome = worker.run(Job(_use_every_kernel, None))
    if isinstance(outcome, Fault):
        raise HarnessFault(f"the kernels cannot be compiled: {outcome.message}")
    marker.touch()


def _use_every_kernel(loaded: LoadedCandidate, _payload: Any) -> None:
    published_point = fixed_scenarios()[1]
    is_feasible(published_point)
    judged(recorded(loaded, published_point, loaded.controller()))
