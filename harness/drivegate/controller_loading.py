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
    from drivegate.python_loading import load_python_controller

    return load_python_controller(candidate)
