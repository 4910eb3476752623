"""Loading a candidate of any kind; this runs its code, so it belongs into a worker process."""

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import Controller
from drivegate.candidates.kinds import KINDS


def load_controller(candidate: Candidate) -> Controller:
    """Make a new instance of a candidate."""
    return KINDS[candidate.kind].load_controller(candidate)
