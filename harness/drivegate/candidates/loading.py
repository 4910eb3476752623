"""Loading a candidate of any kind; this runs its code, so it belongs into a worker process."""

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import Controller


def load_controller(candidate: Candidate) -> Controller:
    """Make a new instance of a candidate."""
    # Each kind brings libraries of its own, and a process needs those of one kind only.
    if candidate.kind == "builtin":
        from drivegate.candidates.builtin.loading import load_builtin_controller

        return load_builtin_controller(candidate)
    if candidate.kind in ("c", "so"):
        from drivegate.candidates.native.loading import load_native_controller

        return load_native_controller(candidate)
    if candidate.kind == "fmu":
        from drivegate.candidates.fmu.loading import load_fmu_controller

        return load_fmu_controller(candidate)
    if candidate.kind == "exec":
        from drivegate.candidates.program.loading import load_exec_controller

        return load_exec_controller(candidate)
    if candidate.kind == "compose":
        from drivegate.candidates.composed.loading import load_composed_controller

        return load_composed_controller(candidate)
    from drivegate.candidates.python.loading import load_python_controller

    return load_python_controller(candidate)
