"""What the kinds of drives have in common that are commanded by a current reference and an advance angle."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from drivegate.drives.drive_kind import Drive, DriveKind, FloatArray, Oracle, SteadyStates

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy

    from drivegate.candidates.declaration import Declaration
    from drivegate.checks.check import Check
    from drivegate.runs.scenario import PrepareLoop
    from drivegate.scenarios.drawn_range import DrawnRange
    from drivegate.scenarios.simplification import Simplification
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.scenario import Scenario


def outer_loop_kind(
    name: str, default_drive: str, prepare_loop: Callable[[], PrepareLoop], compiling_s: int
) -> DriveKind:
    """Make the bundle of such a kind, whose steady states are found by the type of its plant's constants."""
    return DriveKind(
        name=name,
        default_drive=default_drive,
        compiling_s=compiling_s,
        prepare_loop=prepare_loop,
        oracle=_oracle,
        steady_state=_steady_state,
        steady_states=_steady_states,
        checks=_checks,
        fixed_scenarios=_fixed_scenarios,
        drawn_scenarios=_drawn_scenarios,
        joint_scenarios=_joint_scenarios,
        unfair_because=_unfair_because,
        simplifications=_simplifications,
        drawn_range=_drawn_range,
        usual_candidate="reference",
    )


def _oracle() -> Oracle:
    from drivegate_models.steady import oracle

    return oracle


def _steady_state() -> Callable[..., object]:
    from drivegate_models.steady.steady_state import steady_state

    return steady_state


def _steady_states() -> SteadyStates:
    from drivegate_models.steady.grid import POINT_COLUMNS, solve_points
    from drivegate_models.steady.plant import make_phases
    from drivegate_models.steady.steady_state import KEPT_TIME

    def solve(
        drive: Drive, speeds: FloatArray, advances: FloatArray, references: FloatArray, values: FloatArray
    ) -> None:
        work, slices = make_phases(drive, KEPT_TIME), make_phases(drive)
        solve_points(drive, work, slices, drive.half_supply_voltage, speeds, advances, references, values)

    return SteadyStates(columns=POINT_COLUMNS, solve=solve)


def _checks() -> tuple[Check, ...]:
    from drivegate.checks.catalogue import CHECKS

    return CHECKS


def _fixed_scenarios(drive: DriveDocument, declaration: Declaration) -> tuple[Scenario, ...]:
    from drivegate.scenarios.fixed import fixed_scenarios

    return fixed_scenarios(drive, declaration.speed_range_rpm)


def _drawn_scenarios(
    drive: DriveDocument, declaration: Declaration, group: int | None
) -> SearchStrategy[Scenario]:
    from drivegate.scenarios.drawn.families import drawn_scenarios

    return drawn_scenarios(drive, declaration.speed_range_rpm, group)


def _joint_scenarios(
    drive: DriveDocument, declaration: Declaration, seed: int, part: int, parts: int
) -> tuple[Scenario, ...]:
    from drivegate.scenarios.combined import combined_scenarios

    return combined_scenarios(drive, declaration.speed_range_rpm, seed, part, parts)


def _unfair_because(scenario: Scenario) -> str | None:
    from drivegate.scenarios.feasibility import unfair_because

    return unfair_because(scenario)


def _simplifications() -> tuple[Simplification, ...]:
    from drivegate.scenarios.simplification import SIMPLIFICATIONS

    return SIMPLIFICATIONS


def _drawn_range(scenario: Scenario) -> DrawnRange:
    from drivegate.scenarios.drawn_range import drawn_range

    return drawn_range(scenario)
