"""What a candidate declares of itself, which decides the checks that apply to it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from drivegate_cases.requirements.file import OwnRequirements
    from drivegate_cases.scenario.failure_kind import FailureKind
    from drivegate_cases.scenario.reference import FollowedReference
    from drivegate_models.pm_ac.modulation_kind import ModulationKind


@dataclass(frozen=True)
class FlowchartProfile:
    """The constants of a search that follows the paper's flowchart (Fig. 4) to the letter."""

    speed_tolerance: float
    """k1: greatest speed error at which the search is active (rad/s)."""
    power_tolerance: float
    """k2 as a power (W): the search stops when the input power changed by no more; 0 when it is a fraction."""
    power_tolerance_fraction: float
    """k2 as a fraction of the new input power, W_new; 0 when it is a power."""
    step: float
    """Magnitude of one change of the advance angle (electrical rad)."""
    period: float
    """Time from one decision of the search to the next (s)."""


@dataclass(frozen=True)
class Declaration:
    """What a candidate declares of itself."""

    flowchart: FlowchartProfile | None = None
    """The constants of the profile `flowchart`; None for the profile `outcome`."""
    estimates_power: bool = False
    """Whether the candidate's commands carry an estimate of the input power."""
    speed_range_rpm: tuple[float, float] | None = None
    """Lowest and highest speed that the candidate is made for (rpm); None for all."""
    power_window_s: float = 0.0
    """Time over which the estimate is a mean (s); 0 when it is that of the last control period alone."""
    references: tuple[FollowedReference, ...] = ("speed", "torque")
    """References that the candidate follows, where its drive can give either; those of currents follow a
    speed."""
    detects: tuple[FailureKind, ...] = ()
    """Failures that the candidate brings its drive into a safe state for, or keeps its torque behind if they
    are `SURVIVABLE`."""
    reverses: bool = True
    """Whether the candidate also turns its shaft backward, where its drive allows that."""
    reads_enable: bool = False
    """Whether its runs begin with the bridge off and `enable` 0 while the shaft turns."""
    calibration_time_s: float = 0.0
    """Time at standstill with the bridge off before that (s)."""

    current_bandwidth: float | None = None
    """Bandwidth of the current regulators (rad/s), by which their steps are judged; None for the drive's limit."""
    control_every: int | None = None
    """Carrier periods in a control period, where the candidate is made for one number; None for its drive's."""
    update_delay: int | None = None
    """Control periods between a step and its effect, where the candidate is made for one number; None for its
    drive's."""
    modulation: ModulationKind = "continuous"
    """Kind of modulation by whose ideal its torque ripple is judged."""
    requirements: OwnRequirements | None = None
    """What the user requires besides the checks; None for nothing. They travel with the candidate to all that judges
    it."""

    @property
    def follows_current(self) -> bool:
        """Whether the candidate gets a q current in place of a torque reference."""
        return "current" in self.references

    def with_bridge_on(self) -> Declaration:
        """Return what a candidate declares that does not read `enable`, but is the same otherwise."""
        return replace(self, reads_enable=False, calibration_time_s=0.0)


NOTHING_DECLARED: Final = Declaration()
