"""A kind of drive as those see it who judge controllers of any kind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    from hypothesis.strategies import SearchStrategy
    from numpy.typing import ArrayLike, NDArray

    from drivegate.candidates.declaration import Declaration
    from drivegate.checks.check import Check
    from drivegate.containment.messages import AnyController
    from drivegate.runs.record import RunRecord
    from drivegate.runs.scenario import PrepareLoop
    from drivegate.scenarios.drawn_range import DrawnRange
    from drivegate.scenarios.simplification import Simplification
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.scenario import Scenario
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

    def least_input_power(
        self, drive: Drive, speed: float, torque: float, voltage: float | None = None
    ) -> Optimum:
        """Find the advance angle that gives a torque with the least input power."""

    def point_at_torque(
        self, drive: Drive, speed: float, advance: float, torque: float, voltage: float | None = None
    ) -> TorquePoint:
        """Find the steady state that gives a torque at an advance angle."""

    def greatest_torque_at_limit(
        self, drive: Drive, speed: float, voltage: float | None = None
    ) -> GreatestTorque:
        """Find the advance angle of the greatest torque at the current limit."""

    def torques_at_limit(
        self, drive: Drive, speed: float, advances: ArrayLike, voltage: float | None = None
    ) -> FloatArray:
        """Find the torques at the current limit along the advance angle."""

    def demanded_torque(self, drive: Drive, speed: float, base_speed: float, rated_power: float) -> float:
        """Find the torque of rated power at a speed, constant below base speed."""

    def recommended_line(
        self, drive: Drive, base_speed: float, highest_speed: float, rated_power: float
    ) -> AdvanceLine:
        """Find the line of initial angles that keeps rated power at the least advance."""


@dataclass(frozen=True, kw_only=True)
class SteadyStates:
    """The solver of many steady states.

    Attributes
    ----------
    columns : tuple of str
        Names of what is computed of each.
    solve : callable
        From a drive's constants and arrays of speed (rad/s), advance angle (rad) and current reference (A) to rows of
        those columns, which it writes into its last argument.
    """

    columns: tuple[str, ...]
    solve: Callable[[Drive, FloatArray, FloatArray, FloatArray, FloatArray], None]


@dataclass(frozen=True, kw_only=True)
class DriveKind:
    """All that is required of one kind of drive.

    What is compiled, or takes long to import, is behind a function: a bundle costs nothing until it is called.

    Attributes
    ----------
    name : str
        The kind, as documents of drives have it.
    default_drive : str
        Name of the packaged drive that candidates are judged on where nobody names another.
    compiling_s : int
        Time that its kernels take to compile on 2 processors, as measured (s).
    prepare_loop : callable
        Gives the function that makes a run of a controller against the plant ready.
    oracle : callable
        Gives what such a drive can do at best.
    steady_state : callable
        Gives the solver of one steady state.
    steady_states : callable
        Gives the solver of many.
    checks : callable
        Gives the checks that judge a run of such a drive.
    fixed_scenarios : callable
        From a drive, and what a candidate declares of itself, to the scenarios that every check runs first.
    drawn_scenarios : callable
        From the same, and the number of a group of families or None for all of them, to what is searched.
    joint_scenarios : callable
        From the same, a seed, and the number of a part and of all parts, to fair scenarios of joint changes.
    unfair_because : callable
        From a scenario to the reason why no controller could do what it requires; None where one could.
    simplifications : callable
        Gives the ways in which a scenario can be made simpler.
    drawn_range : callable
        From a scenario to the range that those of its family are drawn from, which no simplification leaves.
    usual_candidate : str
        Name of a controller that comes along and runs on such drives.
    record : callable or None
        Runs a candidate through a scenario for the checks, where that is not the loop of `prepare_loop`; it takes the
        declaration, the scenario, the controller and room for the commands, or None.
    unseen : callable or None
        Makes the record of a run that has not been made, from the declaration and the scenario, where it is not that of
        `prepare_loop`.
    behaviour : callable or None
        From what runs a candidate, the drive, and a scenario that shows steps or None, to what a report tells of the
        candidate beside its checks, where there is such a thing.
    """

    name: str
    default_drive: str
    compiling_s: int
    prepare_loop: Callable[[], PrepareLoop]
    oracle: Callable[[], Oracle]
    steady_state: Callable[[], Callable[..., object]]
    steady_states: Callable[[], SteadyStates]
    checks: Callable[[], tuple[Check, ...]]
    fixed_scenarios: Callable[[DriveDocument, Declaration], tuple[Scenario, ...]]
    drawn_scenarios: Callable[[DriveDocument, Declaration, int | None], SearchStrategy[Scenario]]
    joint_scenarios: Callable[[DriveDocument, Declaration, int, int, int], tuple[Scenario, ...]]
    unfair_because: Callable[[Scenario], str | None]
    simplifications: Callable[[], tuple[Simplification, ...]]
    drawn_range: Callable[[Scenario], DrawnRange]
    usual_candidate: str
    record: Callable[[Declaration, Scenario, AnyController, NDArray[Any] | None], RunRecord] | None = None
    unseen: Callable[[Declaration, Scenario], RunRecord] | None = None
    behaviour: (
        Callable[[Callable[[Scenario], RunRecord], DriveDocument, Scenario | None], dict[str, Any]] | None
    ) = None

    def is_fair(self, scenario: Scenario) -> bool:
        """Tell whether a candidate may be judged on a scenario."""
        return self.unfair_because(scenario) is None

    def is_as_fair(self, simpler: Scenario, start: Scenario) -> bool:
        """Return True if a simplified scenario could have been drawn like the one that simplification started from."""
        return self.drawn_range(start).covers(simpler, start) and self.is_fair(simpler)
