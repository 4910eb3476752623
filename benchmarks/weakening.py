"""Faults of the self-test with a severity, on scenarios that are points of a unit cube: what searches are compared on.

A *gradual* fault is weakened by its own constant, such as degrees a second, and so breaks its check in a smaller and
smaller part of the cube. A *sudden* one has its full size inside a pocket of the cube and is no fault elsewhere, so
that no margin shows the way there; it is weakened by shrinking the pocket. A *flat* one is weakened by its constant
too, but margins hardly differ outside of where it shows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal, TypeAlias

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import Check
from drivegate.containment.judge import own_candidate
from drivegate.containment.messages import AnyController
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.kinds import kind_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

Point: TypeAlias = tuple[float, ...]
"""A scenario, each coordinate from 0 to 1."""

GRID: Final = 1000
"""Steps of each coordinate, the same for every method."""


@dataclass(frozen=True)
class Cube:
    """A family of scenarios over continuous coordinates."""

    drive: DriveDocument
    coordinates: tuple[tuple[str, float, float], ...]
    """Name, value at 0 and value at 1 of each."""
    build: Callable[[dict[str, float]], Scenario]
    """Makes the scenario from the values by name."""

    def scenario(self, point: Point) -> Scenario:
        """Make the scenario of a point."""
        values = {
            name: round(low + (high - low) * place, 6)
            for (name, low, high), place in zip(self.coordinates, point, strict=True)
        }
        return self.build(values)

    def place(self, **values: float) -> dict[int, float]:
        """Find the places of values among the coordinates."""
        return {
            number: (values[name] - low) / (high - low)
            for number, (name, low, high) in enumerate(self.coordinates)
            if name in values
        }


def on_grid(point: Point) -> Point:
    """Bring a point into the cube and onto the grid."""
    return tuple(round(min(max(place, 0.0), 1.0) * GRID) / GRID for place in point)


Shape: TypeAlias = Literal["gradual", "flat", "sudden"]


@dataclass(frozen=True)
class WeakenedFault:
    """A fault of the self-test that can be made weaker."""

    name: str
    """What is shown."""
    check: str
    """The check that has to fail."""
    cube: Cube
    controller: Callable[[float], AnyController]
    """Makes the faulty controller from the value of the fault's constant; a sudden fault has but one."""
    weakest: float = 1.0
    strongest: float = 1.0
    """Not sudden: what the constant goes between, as the logarithm of the severity goes from 0 to 1."""
    pocket: dict[int, float] | None = None
    """Sudden: the middle of the pocket, by number of coordinate."""
    is_flat: bool = False
    """Whether margins lead nowhere although the fault is weakened by its constant."""

    @property
    def shape(self) -> Shape:
        """Whether margins show the way."""
        if self.pocket is not None:
            return "sudden"
        return "flat" if self.is_flat else "gradual"

    def at(self, severity: float) -> AnyController:
        """Make the faulty controller of a severity from 0 to 1."""
        return self.controller(self.weakest * (self.strongest / self.weakest) ** severity)

    def half_width(self, share: float) -> float:
        """Find half the width of a pocket that takes up a share of the cube."""
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._volume(middle) < share else (low, middle)
        return high

    def _volume(self, half_width: float) -> float:
        volume = 1.0
        for centre in (self.pocket or {}).values():
            volume *= min(1.0, centre + half_width) - max(0.0, centre - half_width)
        return volume

    def distance(self, point: Point) -> float:
        """Return the half width of the least pocket that holds a point."""
        return max(abs(point[number] - centre) for number, centre in (self.pocket or {}).items())


@dataclass(frozen=True)
class Judge:
    """Runs one controller through the scenarios of a cube, and gives one check's margin."""

    controller: AnyController
    check: str
    cube: Cube

    @cached_property
    def _declaration(self) -> Declaration:
        return resolve_candidate(contract_of(self.cube.drive).usual_candidate).declaration

    @cached_property
    def _check(self) -> Check:
        return next(check for check in contract_of(self.cube.drive).checks if check.id == self.check)

    def margin(self, point: Point) -> float:
        """Run a scenario; 1 where the check does not apply, and below 0 only where the scenario is fair."""
        scenario, contract = self.cube.scenario(point), contract_of(self.cube.drive)
        prepare = kind_of(self.cube.drive).prepare_loop()
        record = contract.record(prepare, self._declaration, scenario, self.controller)
        margin = self._check.evaluate(record)
        if margin is None or margin.advisory or (margin.value < 0.0 and not contract.is_fair(scenario)):
            return 1.0
        return max(margin.value, -1e6)


def correct(check: str, cube: Cube) -> Judge:
    """Judge the controller without a fault."""
    usual = contract_of(cube.drive).usual_candidate
    return Judge(own_candidate(resolve_candidate(usual)).controller(), check, cube)
