"""Faults of controllers that answer with duty ratios, weakened, and their cubes of scenarios."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from drivegate.containment.messages import AnyController
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.building import share_scenario, speed_scenario, torque_of
from drivegate.scenarios.changes import in_steps, with_scales
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS, DutyFault
from drivegate_lab.candidates.faulty_duty_controller import FaultyDutyController, load_faulty_duty_controller
from weakening import Cube, WeakenedFault

DRIVE: Final = duty_document(load_drive("pm-ac-interior"))
QUICK_DRIVE: Final = DRIVE.replaced(requirements=DRIVE.requirements.model_copy(update={"settling_s": 0.2}))
"""The same, whose torques are judged 0.2 s after a change: a steady state there has long been reached."""
_LATEST_S: Final = 0.05


def _torque_step(values: dict[str, float]) -> Scenario:
    run = share_scenario(QUICK_DRIVE, values["speed"], values["before"], values["after"])
    torques = [torque_of(QUICK_DRIVE, values["speed"], values[name]) for name in ("before", "after")]
    load = DynamometerLoad(
        kind="dynamometer",
        torque_reference_nm=in_steps(torques, (round(0.5 * run.duration_s + values["delay"], 4),)),
    )
    return run.replaced(
        load=load, duration_s=round(run.duration_s + _LATEST_S, 4), initial_angle_deg=values["angle"]
    )


def _held_torque(values: dict[str, float]) -> Scenario:
    run = share_scenario(QUICK_DRIVE, values["speed"], values["torque"])
    supply = round(values["supply"] * QUICK_DRIVE.inverter.supply_voltage_v, 6)
    return run.replaced(supply_v=((0.0, supply),), initial_angle_deg=values["angle"])


def _other_plant(values: dict[str, float]) -> Scenario:
    fastest = max(values["before"], values["after"])
    run = speed_scenario(
        DRIVE,
        (values["after"],),
        torque_nm=torque_of(DRIVE, fastest, values["share"]),
        initial_speed_rpm=values["before"],
        inertia_factor=values["inertia"],
    )
    return with_scales(
        run,
        inertia=values["inertia"],
        resistance=values["resistance"],
        inductance=values["inductance"],
        emf_constant=values["emf"],
    )


TORQUE_STEPS: Final = Cube(
    QUICK_DRIVE,
    (
        ("delay", 0.0, _LATEST_S),
        ("angle", 0.0, 359.0),
        ("before", -1.0, 1.0),
        ("after", -1.0, 1.0),
        ("speed", 100.0, 2000.0),
    ),
    _torque_step,
)
"""A step of the torque reference at a held speed on the nominal drive, 2 s."""
HELD_TORQUES: Final = Cube(
    QUICK_DRIVE,
    (("angle", 0.0, 359.0), ("supply", 0.85, 1.15), ("torque", -1.0, 1.0), ("speed", 300.0, 5900.0)),
    _held_torque,
)
"""One torque at a held speed and another voltage of the link, 1 s."""
OTHER_PLANTS: Final = Cube(
    DRIVE,
    (
        ("resistance", 0.5, 2.0),
        ("inductance", 0.7, 1.3),
        ("emf", 0.8, 1.05),
        ("inertia", 0.3, 2.0),
        ("share", 0.0, 0.7),
        ("before", 300.0, 2100.0),
        ("after", 300.0, 3000.0),
    ),
    _other_plant,
)
"""A step of the speed under a load, on plants that are not the nameplate's."""


def _scaled(name: str, *constants: str) -> Callable[[float], FaultyDutyController]:
    """Make the fault whose constants are multiplied by any factor."""

    def made(factor: float) -> FaultyDutyController:
        factors = tuple((constant, factor) for constant in constants)
        return FaultyDutyController(replace(DUTY_FAULTS[name], factors=factors))

    return made


def _strong_magnets(factor: float) -> FaultyDutyController:
    fault: DutyFault = DUTY_FAULTS["strong-magnets-assumed"]
    believed = {"magnet_flux": lambda plate: factor * plate.magnet_flux}
    return FaultyDutyController(replace(fault, believes=believed))


def _torque_wrong(_: float) -> AnyController:
    return load_faulty_duty_controller("current-sensor-gain")


DUTY_FAULTS_WEAKENED: Final = (
    WeakenedFault(
        "eager integrals",
        "STP-1",
        TORQUE_STEPS,
        _scaled("eager-integrals", "direct_integral_step", "quadrature_integral_step"),
        strongest=10.0,
    ),
    WeakenedFault("strong magnets assumed", "FWK-2", HELD_TORQUES, _strong_magnets, strongest=1.4),
    WeakenedFault(
        "light rotor assumed",
        "ROB-4",
        OTHER_PLANTS,
        _scaled("light-rotor-assumed", "speed_gain"),
        strongest=0.25,
    ),
    WeakenedFault(
        "torque wrong in a pocket",
        "ACC-1",
        HELD_TORQUES,
        _torque_wrong,
        pocket=HELD_TORQUES.place(speed=2600.0, torque=0.55, supply=1.03),
    ),
    WeakenedFault(
        "torque wrong in a corner",
        "ACC-1",
        HELD_TORQUES,
        _torque_wrong,
        pocket=HELD_TORQUES.place(speed=300.0, torque=1.0, supply=0.85),
    ),
)
"""What the methods are compared on."""
