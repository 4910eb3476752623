"""A kind of drive: its plant, and the name of the contract that its controllers follow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from drivegate_models.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from drivegate_models.steady.oracle import AdvanceLine as AdvanceLine
    from drivegate_models.steady.oracle import GreatestTorque, Optimum, TorquePoint

FloatArray: TypeAlias = "NDArray[np.float64]"
Drive: TypeAlias = Any
"""Constants of a plant, as its own kind of drive has them."""


class Oracle(Protocol):
    """What a drive can do at best, whatever the controller: functions of its constants, in SI units."""

    def feasible_edge(
        self, drive: Drive, speed: float, torque: float, voltage: float | None = None, static: bool = False
    ) -> float:
        """Find the smallest advance angle that gives a torque; NaN where none does."""

    def least_current_sum(
        self, drive: Drive, speed: float, torque: float, voltage: float | None = None
    ) -> Optimum:
        """Find the advance angle that gives a torque with the least current sum."""

    def least_input_power(self, drive: Drive, speed: float, torque: float) -> Optimum:
        """Find the advance angle that gives a torque with the least input power."""

    def point_at_torque(
        self, drive: Drive, speed: float, advance: float, torque: float, voltage: float | None = None
    ) -> TorquePoint:
        """Find the steady state that gives a torque at an advance angle."""

    def greatest_torque_at_limit(self, drive: Drive, speed: float) -> GreatestTorque:
        """Find the advance angle of the greatest torque at the current limit."""

    def torques_at_limit(self, drive: Drive, speed: float, advances: ArrayLike) -> FloatArray:
        """Find the torques at the current limit along the advance angle."""

    def demanded_torque(self, drive: Drive, speed: float, base_speed: float, rated_power: float) -> float:
        """Find the torque of rated power at a speed, constant below base speed."""

    def recommended_line(
        self, drive: Drive, base_speed: float, highest_speed: float, rated_power: float
    ) -> AdvanceLine:
        """Find the line of initial angles that keeps rated power at the least advance."""


@dataclass(frozen=True, kw_only=True)
class SteadyStates:
    """The solver of many steady states."""

    columns: tuple[str, ...]
    """Names of what is computed of each."""
    solve: Callable[[Drive, FloatArray, FloatArray, FloatArray, FloatArray], None]
    """From a drive's constants and arrays of speed (rad/s), advance angle (rad) and current reference (A) to
    rows of those columns, which it writes into its last argument."""


@dataclass(frozen=True, kw_only=True)
class AngleStudies:
    """What is computed of drives whose controllers answer with an advance angle; each function imports its kernels."""

    oracle: Callable[[], Oracle]
    """Return what such a drive can do at best."""
    steady_state: Callable[[], Callable[..., object]]
    """Return the solver of one steady state."""
    steady_states: Callable[[], SteadyStates]
    """Return the solver of many steady states."""


@dataclass(frozen=True, kw_only=True)
class DriveKind:
    """A kind of drive; a bundle imports no compiled code until it is called."""

    name: str
    """The kind, as documents of drives have it."""
    contract: str
    """Name of the contract of its controllers."""
    default_drive: str
    """Name of the packaged drive that stands for this kind."""
    compiling_s: int
    """Time to compile its kernels on 2 processors, as measured (s)."""
    prepare_loop: Callable[[], Callable[..., Any]]
    """Return the function that prepares a run of a controller against the plant."""
    angles: AngleStudies | None = None
    """Studies over the advance angle; None where controllers answer with none."""

    def oracle(self) -> Oracle:
        """Return what a drive of this kind can do at best over the advance angle."""
        return self.require_angles().oracle()

    def steady_state(self) -> Callable[..., object]:
        """Return the solver of one steady state at an advance angle."""
        return self.require_angles().steady_state()

    def steady_states(self) -> SteadyStates:
        """Return the solver of many steady states at advance angles."""
        return self.require_angles().steady_states()

    def require_angles(self) -> AngleStudies:
        """Return the studies over the advance angle, or refuse a kind without them."""
        if self.angles is None:
            raise InputError(
                f"a drive of the kind '{self.name}' has no steady states of an advance angle: drivegate drive shows "
                "what it can do over speed and torque, and drivegate compare and simulate what controllers make of it; "
                "or name another drive"
            )
        return self.angles
