"""Controllers know no drive: one that differs in its units alone is controlled alike, bit for bit."""

from pathlib import Path

import numpy as np
import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.running import run_scenario
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.scenario.load import ConstantPowerLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.current.records import nameplate_record
from drivegate_models.controllers.current.builtin import SEARCHES, reset_function
from drivegate_models.controllers.current.state import CONTROLLER_STATE
from drivegate_models.units import RADIANS_PER_RPM

PAPER = load_drive("paper-5-phase")
EXAMPLE = str(Path(__file__).parents[4] / "examples" / "c" / "controller.c")
VOLTS, AMPERES, SPEED = 4.0, 2.0, 2.0


def in_other_units(drive: DriveDocument) -> DriveDocument:
    """Scale a drive by powers of two, which are exact: volts, amperes and speed, and with them all the rest."""
    machine, inverter, rating = drive.machine, drive.inverter, drive.rating
    assert drive.advance is not None
    ohms = VOLTS / AMPERES
    torque = VOLTS * AMPERES / SPEED
    return drive.replaced(
        name="the same in other units",
        resistance_ohm=machine.resistance_ohm * ohms,
        inductance_h=machine.inductance_h * ohms / SPEED,
        emf_constant_v_s_per_rad=machine.emf_constant_v_s_per_rad * VOLTS / SPEED,
        core_loss_conductance_s=machine.core_loss_conductance_s / ohms,
        inertia_kg_m2=machine.inertia_kg_m2 * torque / SPEED**2,
        supply_voltage_v=inverter.supply_voltage_v * VOLTS,
        hysteresis_band_a=inverter.hysteresis_band_a * AMPERES,
        base_speed_rpm=rating.base_speed_rpm * SPEED,
        highest_speed_rpm=rating.highest_speed_rpm * SPEED,
        overspeed_rpm=rating.overspeed_rpm * SPEED,
        rated_power_w=rating.rated_power_w * VOLTS * AMPERES,
        current_limit_a=rating.current_limit_a * AMPERES,
        slope_deg_per_rpm=drive.advance.slope_deg_per_rpm / SPEED,
    )


def step_of_load(drive: DriveDocument, speed: float, share: float, time: float) -> Scenario:
    """Make a run at multiples of base speed and of rated power, in which the load halves at half of the time."""
    rpm = speed * drive.rating.base_speed_rpm
    courses = ((0.0, 0.0), (0.2 * time, 1.0), (3.0 * time, 1.0), (3.1 * time, 0.5))
    load = ConstantPowerLoad(
        kind="constant_power", power_w=share * drive.rating.rated_power_w, factor=courses
    )
    return Scenario(
        name="steady",
        drive=drive,
        duration_s=6.0 * time,
        control_period_s=5e-4 * time,
        initial_speed_rpm=rpm,
        speed_rpm=((0.0, rpm),),
        load=load,
    )


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("speed", "share"), [(1.3, 1.0), (3.0, 1.0), (2.0, 0.3)])
@pytest.mark.parametrize("name", ["initial", "reference", EXAMPLE])
def test_a_drive_in_other_units_is_controlled_alike(name: str, speed: float, share: float) -> None:
    candidate = resolve_candidate(name)
    traces = [
        run_scenario(step_of_load(drive, speed, share, time), load_controller(candidate), trace_every=1).trace
        for drive, time in ((PAPER, 1.0), (in_other_units(PAPER), 1.0 / SPEED))
    ]
    assert np.ptp(traces[0]["current_reference_a"]) > 1.0, "a trace in which nothing happens proves nothing"
    for column, unit in (("advance_deg", 1.0), ("current_reference_a", AMPERES), ("speed_rpm", SPEED)):
        here, there = traces[0][column] * unit, traces[1][column]
        differing = np.nonzero(here != there)[0]
        assert not differing.size, (
            f"{column} differs from step {differing[0]} on, {here[differing[0]]!r} and {there[differing[0]]!r}: "
            f"{name} has a constant that belongs to one drive"
        )


def test_the_constants_for_the_paper_drive_are_those_that_were_tuned() -> None:
    nameplate = nameplate_record(PAPER.nameplate(0.0005))
    states = {}
    for name, search in SEARCHES.items():
        state = np.zeros(1, CONTROLLER_STATE)
        reset_function()(state, nameplate, search)
        states[name] = state[0]
    reference, published = states["reference"], states["published"]
    assert reference["conducting_phases"] == 4.0
    assert reference["proportional"] == 0.05 * 80.0 / (4.0 * 0.339)
    assert reference["integral_step"] == reference["proportional"] * 15.0 * 0.0005
    assert reference["angle_at_base"] == np.radians(33.0)
    assert reference["angle_slope"] == np.radians(0.025) * 30.0 / np.pi
    assert reference["advance_begins"] == (500.0 + 10.0) * RADIANS_PER_RPM
    for state in (reference, published):
        assert (state["speed_tolerance"], state["decision_steps"]) == (5.0 * RADIANS_PER_RPM, 200)
    assert published["angle_at_base"] == 0.0
    assert published["angle_slope"] == np.radians(0.058) * 30.0 / np.pi
