"""Faults of controllers that answer with a current reference, weakened, and their cubes of scenarios."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import radians
from typing import Final

from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.scenarios.changes import with_load_shares, with_scales
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.candidates.faults.catalogue import MUTATIONS
from drivegate_lab.candidates.faulty_controller import FaultyController
from drivegate_models.units import RADIANS_PER_RPM
from weakening import Cube, WeakenedFault

DRIVE: Final = load_drive("paper-5-phase").replaced(hysteresis_band_a=0.0)
_STEADY_S: Final = 9.2
_SHORT_S: Final = 1.0


def _at_supply(scenario: Scenario, share: float) -> Scenario:
    return scenario.replaced(supply_v=((0.0, round(share * scenario.drive.inverter.supply_voltage_v, 6)),))


def _load_step(values: dict[str, float]) -> Scenario:
    run = steady_scenario(DRIVE, values["speed"], power_share=1.0, constant_power=False)
    run = with_load_shares(run, (0.0, values["before"]), (values["time"], values["after"]))
    run = with_scales(run, resistance=values["resistance"], emf_constant=values["emf"])
    return _at_supply(run, values["supply"]).replaced(duration_s=_SHORT_S)


def _other_plant(values: dict[str, float]) -> Scenario:
    run = steady_scenario(DRIVE, values["speed"], power_share=values["share"], constant_power=False)
    run = with_scales(
        run,
        resistance=values["resistance"],
        inductance=values["inductance"],
        emf_constant=values["emf"],
        friction_added_n_m=values["friction"],
    )
    return run.replaced(duration_s=_STEADY_S)


def _nominal_plant(values: dict[str, float]) -> Scenario:
    run = steady_scenario(DRIVE, values["speed"], power_share=values["share"], constant_power=False)
    load = run.load.model_copy(update={"factor": ((0.0, 0.0), (values["ramp"], 1.0))})
    # The windows begin when the ramp has ended.
    duration = round(values["ramp"] + 9.1, 1)
    return _at_supply(run, values["supply"]).replaced(load=load, duration_s=duration)


LOAD_STEPS: Final = Cube(
    DRIVE,
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
    DRIVE,
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
    DRIVE,
    (("ramp", 0.1, 0.9), ("supply", 0.97, 1.05), ("share", 0.5, 0.95), ("speed", 600.0, 1500.0)),
    _nominal_plant,
)
"""Steady runs on the nominal plant; the load comes on as a ramp, the supply is not quite nominal."""


_DEGREE: Final = radians(1.0)


def _sized(name: str) -> Callable[[float], FaultyController]:
    """Make a fault of any size."""
    return lambda size: FaultyController(replace(MUTATIONS[name], size=size))


def _full(name: str) -> Callable[[float], FaultyController]:
    """Make a fault of its own size."""
    return lambda _: FaultyController(MUTATIONS[name])


def _steep(factor: float) -> FaultyController:
    """Make a slope that is too steep by a factor."""
    steep = MUTATIONS["slope-doubled"]
    return FaultyController(replace(steep, factors=(("angle_slope", factor),), constants=()))


CURRENT_FAULTS: Final = (
    WeakenedFault(
        "boost behind the limits",
        "ADV-2",
        LOAD_STEPS,
        _sized("angle-unclamped"),
        weakest=0.05 * _DEGREE / RADIANS_PER_RPM,
        strongest=20.0 * _DEGREE / RADIANS_PER_RPM,
    ),
    WeakenedFault("slope too steep", "ADV-2", LOAD_STEPS, _steep, weakest=1.0, strongest=4.0),
    WeakenedFault(
        "angle drifts",
        "CNV-1",
        NOMINAL_PLANT,
        _sized("drifts"),
        weakest=0.01 * _DEGREE,
        strongest=0.5 * _DEGREE,
        is_flat=True,
    ),
    WeakenedFault(
        "power wrong in a pocket",
        "PWR-2",
        LOAD_STEPS,
        _full("power-one-percent-high"),
        pocket=LOAD_STEPS.place(speed=1070.0, after=0.63, supply=1.02, emf=1.02),
    ),
    WeakenedFault(
        "power wrong in a corner",
        "PWR-2",
        LOAD_STEPS,
        _full("power-one-percent-high"),
        pocket=LOAD_STEPS.place(speed=1500.0, after=0.9, supply=0.97),
    ),
    WeakenedFault(
        "angle cycles in a corner",
        "ROB-1",
        OTHER_PLANTS,
        _full("angle-cycles"),
        pocket=OTHER_PLANTS.place(speed=1500.0, share=0.9, emf=1.05, resistance=1.5),
    ),
)
"""What the methods are compared on."""
