"""Faults of the self-test with a severity, on scenarios that are points of a unit cube: what searches are compared on.

A *gradual* fault is weakened by its own constant, such as degrees a second, and so breaks its check in a smaller and
smaller part of the cube. A *sudden* one has its full size inside a pocket of the cube and is no fault elsewhere, so
that no margin shows the way there; it is weakened by shrinking the pocket. A *flat* one is weakened by its constant
too, but margins hardly differ outside of where it shows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import radians
from typing import Final, Literal, TypeAlias

from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.contracts.current.scenarios.feasibility import unfair_because
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import with_load_shares, with_scales
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.candidates.faults.catalogue import MUTATIONS
from drivegate_lab.candidates.faults.mutation import Mutation
from drivegate_lab.candidates.faulty_controller import FaultyController
from drivegate_lab.kernels.faults.current.state import NO_FAULT
from drivegate_models.units import RADIANS_PER_RPM

Point: TypeAlias = tuple[float, ...]
"""A scenario, each coordinate from 0 to 1."""

GRID: Final = 1000
"""Steps of each coordinate, the same for every method."""
_CHECKS = {check.id: check for check in CHECKS}
CORRECT: Final = Mutation("correct", "Nothing is wrong with it.", "none", fault=NO_FAULT)
"""The controller without a fault."""
_STEADY_S = 9.2
_SHORT_S = 1.0


@cache
def _drive() -> DriveDocument:
    return load_drive("paper-5-phase").replaced(hysteresis_band_a=0.0)


@dataclass(frozen=True)
class Cube:
    """A family of scenarios over continuous coordinates.

    Attributes
    ----------
    coordinates : tuple of (str, float, float)
        Name, value at 0 and value at 1 of each coordinate.
    build : callable
        Makes the scenario from the values by name.
    """

    coordinates: tuple[tuple[str, float, float], ...]
    build: Callable[[dict[str, float]], Scenario]

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


def _at_supply(scenario: Scenario, share: float) -> Scenario:
    return scenario.replaced(supply_v=((0.0, round(share * scenario.drive.inverter.supply_voltage_v, 6)),))


def _load_step(values: dict[str, float]) -> Scenario:
    run = steady_scenario(_drive(), values["speed"], power_share=1.0, constant_power=False)
    run = with_load_shares(run, (0.0, values["before"]), (values["time"], values["after"]))
    run = with_scales(run, resistance=values["resistance"], emf_constant=values["emf"])
    return _at_supply(run, values["supply"]).replaced(duration_s=_SHORT_S)


def _other_plant(values: dict[str, float]) -> Scenario:
    run = steady_scenario(_drive(), values["speed"], power_share=values["share"], constant_power=False)
    run = with_scales(
        run,
        resistance=values["resistance"],
        inductance=values["inductance"],
        emf_constant=values["emf"],
        friction_added_n_m=values["friction"],
    )
    return run.replaced(duration_s=_STEADY_S)


def _nominal_plant(values: dict[str, float]) -> Scenario:
    run = steady_scenario(_drive(), values["speed"], power_share=values["share"], constant_power=False)
    load = run.load.model_copy(update={"factor": ((0.0, 0.0), (values["ramp"], 1.0))})
    # The windows begin when the ramp has ended.
    duration = round(values["ramp"] + 9.1, 1)
    return _at_supply(run, values["supply"]).replaced(load=load, duration_s=duration)


LOAD_STEPS: Final = Cube(
    (
        ("time", 0.3, 0.6),
        ("supply", 0.97, 1.05),
        ("resistance", 0.5, 1.5),
        ("emf", 0.97, 1.05),
        ("before", 0.1, 0.9),
        ("after", 0.1, 0.9),
        ("speed", 700.0, 1500.0),
    ),
    _load_step,
)
"""A step of the load, supply and plant somewhat off nominal, 1 s."""
OTHER_PLANTS: Final = Cube(
    (
        ("friction", 0.0, 0.5),
        ("inductance", 0.8, 1.2),
        ("resistance", 0.5, 1.5),
        ("emf", 0.97, 1.05),
        ("share", 0.2, 0.9),
        ("speed", 600.0, 1500.0),
    ),
    _other_plant,
)
"""Steady runs on plants that are not the nameplate's."""
NOMINAL_PLANT: Final = Cube(
    (("ramp", 0.1, 0.9), ("supply", 0.97, 1.05), ("share", 0.5, 0.95), ("speed", 600.0, 1500.0)),
    _nominal_plant,
)
"""Steady runs on the nominal plant; the load comes on as a ramp, the supply is not quite nominal."""


Shape: TypeAlias = Literal["gradual", "flat", "sudden"]


@dataclass(frozen=True)
class WeakenedFault:
    """A fault of the self-test that can be made weaker.

    Attributes
    ----------
    name : str
        What is shown.
    mutation : str
        The faulty controller that it is made from.
    check : str
        The check that has to fail.
    cube : Cube
        The scenarios.
    weakest, strongest : float
        Not sudden: what the constant goes between, as the logarithm of the severity goes from 0 to 1.
    factor : str, optional
        Not sudden: the controller's constant that is multiplied; where there is none, the fault's own size is set.
    pocket : dict of int to float, optional
        Sudden: the middle of the pocket, by number of coordinate.
    is_flat : bool
        Whether margins lead nowhere although the fault is weakened by its constant.
    """

    name: str
    mutation: str
    check: str
    cube: Cube
    weakest: float = 0.0
    strongest: float = 0.0
    factor: str | None = None
    pocket: dict[int, float] | None = None
    is_flat: bool = False

    @property
    def shape(self) -> Shape:
        """Whether margins show the way."""
        if self.pocket is not None:
            return "sudden"
        return "flat" if self.is_flat else "gradual"

    def at(self, severity: float) -> Mutation:
        """Make the faulty controller of a severity from 0 to 1; a sudden one has but one."""
        mutation = MUTATIONS[self.mutation]
        if self.pocket is not None:
            return mutation
        value = self.weakest * (self.strongest / self.weakest) ** severity
        if self.factor is None:
            return replace(mutation, size=value)
        others = tuple(constant for constant in mutation.constants if constant[0] != self.factor)
        return replace(mutation, factors=((self.factor, value),), constants=others)

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
    """Runs one controller through scenarios, and gives one check's margin.

    Attributes
    ----------
    mutation : Mutation
        The controller.
    check : str
        The check.
    cube : Cube
        The scenarios.
    """

    mutation: Mutation
    check: str
    cube: Cube

    @cached_property
    def _controller(self) -> FaultyController:
        return FaultyController(self.mutation)

    def margin(self, point: Point) -> float:
        """Run a scenario; 1 where the check does not apply, and below 0 only where the scenario is fair."""
        scenario = self.cube.scenario(point)
        run = run_scenario(scenario, self._controller)
        margin = _CHECKS[self.check].evaluate(CurrentRecord(scenario, run, BUILTIN_CANDIDATES["reference"]))
        if margin is None or margin.advisory:
            return 1.0
        if margin.value < 0.0 and unfair_because(scenario) is not None:
            return 1.0
        return max(margin.value, -1e6)


def correct(fault: WeakenedFault) -> Judge:
    """Judge the controller without the fault."""
    return Judge(CORRECT, fault.check, fault.cube)


_DEGREE: Final = radians(1.0)

FAULTS: Final = (
    WeakenedFault(
        "boost behind the limits",
        "angle-unclamped",
        "ADV-2",
        LOAD_STEPS,
        weakest=0.05 * _DEGREE / RADIANS_PER_RPM,
        strongest=20.0 * _DEGREE / RADIANS_PER_RPM,
    ),
    WeakenedFault(
        "slope too steep",
        "slope-doubled",
        "ADV-2",
        LOAD_STEPS,
        weakest=1.0,
        strongest=4.0,
        factor="angle_slope",
    ),
    WeakenedFault(
        "angle drifts",
        "drifts",
        "CNV-1",
        NOMINAL_PLANT,
        weakest=0.01 * _DEGREE,
        strongest=0.5 * _DEGREE,
        is_flat=True,
    ),
    WeakenedFault(
        "power wrong in a pocket",
        "power-one-percent-high",
        "PWR-2",
        LOAD_STEPS,
        pocket=LOAD_STEPS.place(speed=1070.0, after=0.63, supply=1.02, emf=1.02),
    ),
    WeakenedFault(
        "power wrong in a corner",
        "power-one-percent-high",
        "PWR-2",
        LOAD_STEPS,
        pocket=LOAD_STEPS.place(speed=1500.0, after=0.9, supply=0.97),
    ),
    WeakenedFault(
        "angle drifts in a corner",
        "drifts",
        "ROB-1",
        OTHER_PLANTS,
        pocket=OTHER_PLANTS.place(speed=1500.0, share=0.9, emf=1.05, resistance=1.5),
    ),
)
"""What the methods are compared on."""
