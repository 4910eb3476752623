"""Loading a candidate of any kind; this runs its code, so it belongs into a worker process."""

from drivegate.candidate import Candidate
from drivegate.controller import Controller


def load_controller(candidate: Candidate) -> Controller:
    """Make a new instance of a candidate.

    Parameters
    ----------
    candidate : Candidate
        The candidate.

    Returns
    -------
    Controller
        The instance, not yet reset.

    Raises
    ------
    InputError
        When the candidate cannot be used as it is.
    CandidateFault
        When the candidate's own code fails.
    """
    # Each kind brings libraries of its own, and a process needs those of one kind only.
    if candidate.kind == "builtin":
        from drivegate.builtin_loading import load_builtin_controller

        return load_builtin_controller(candidate)
    if candidate.kind in ("c", "so"):
        from drivegate.native.loading import load_native_controller

        return load_native_controller(candidate)
    if candidate.kind == "fmu":
        from drivegate.fmu.loading import load_fmu_controller

        return load_fmu_controller(candidate)
    if candidate.kind == "exec":
        from drivegate.program.loading import load_exec_controller

        return load_exec_controller(candidate)
    if candidate.kind == "compose":
        from drivegate.composed.loading import load_composed_controller

        return load_composed_controller(candidate)
    from drivegate.python_loading import load_python_controller

    return load_python_controller(candidate)
