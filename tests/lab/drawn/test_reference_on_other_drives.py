"""The reference converges where its own steps look like another load, where inertia is small, and after a climb."""

import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import Check
from drivegate.contracts.current.checks.convergence import (
    CNV_1,
    CNV_2,
    converges,
    reaches_optimum,
    window_convergence,
)
from drivegate.contracts.current.checks.robustness import ROB_2, ROB_3
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.building import coming_on, steady_scenario, vehicle_scenario
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import with_load_factor, with_scales
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.disturbance import CurrentError, Dropout
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.drawn.kinds import HALF_BRIDGE
from drivegate_lab.drawn.kinds import STAR as DRAWN_STAR

FAN, TRACTION, PAPER, STAR, WIDE_WINDOW = map(
    load_drive,
    ("fan-3-phase", "traction-7-phase", "paper-5-phase", "star-3-phase", "star-3-phase-150-window"),
)
BARE_ROTOR = PAPER.replaced(name="bare-rotor", inertia_kg_m2=0.2 * PAPER.machine.inertia_kg_m2)
THRUSTER = PAPER.replaced(
    name="thruster",
    advance=None,
    pole_pairs=6,
    resistance_ohm=0.097,
    inductance_h=5.6e-3,
    emf_constant_v_s_per_rad=0.785,
    emf_flat_deg=105.0,
    core_loss_conductance_s=1.7e-3,
    inertia_kg_m2=0.3,
    friction_n_m=1.5,
    supply_voltage_v=200.0,
    hysteresis_band_a=0.6,
    base_speed_rpm=900.0,
    highest_speed_rpm=2700.0,
    overspeed_rpm=3600.0,
    rated_power_w=15000.0,
    current_limit_a=62.5,
)
LIFT = PAPER.replaced(
    name="lift",
    advance=None,
    phases=7,
    pole_pairs=8,
    resistance_ohm=0.11,
    inductance_h=6.6e-3,
    emf_constant_v_s_per_rad=1.32,
    emf_flat_deg=105.0,
    window_deg=1080.0 / 7.0,
    core_loss_conductance_s=1.2e-3,
    inertia_kg_m2=0.9,
    friction_n_m=1.0,
    supply_voltage_v=135.0,
    hysteresis_band_a=0.5,
    base_speed_rpm=450.0,
    highest_speed_rpm=1200.0,
    overspeed_rpm=1500.0,
    rated_power_w=9000.0,
    current_limit_a=52.0,
    speed_tolerance_rpm=None,
    settling_s=None,
)
# A load that grows by less than a percent from one decision to the next, for three seconds.
SLOWLY_GROWING = tuple(
    with_load_factor(
        steady_scenario(drive, speed, power_share=1.0, constant_power=constant_power),
        ((0.0, 0.0), (0.5, 0.65), (begin, 0.65), (end, 0.8)),
    ).replaced(duration_s=20.0 + end)
    for drive, speed, constant_power, begin, end in (
        (HALF_BRIDGE.draw(0, 71).document, 1340.0, True, 12.0, 15.2),
        (HALF_BRIDGE.draw(0, 83).document, 370.0, True, 12.0, 15.2),
        # Steps that save as much as the load grows meanwhile look flat, far from the initial angle too.
        (HALF_BRIDGE.draw(0, 62).document, 1160.0, True, 9.0, 11.4),
        (next(DRAWN_STAR.draws(0, 2)), 2720.0, False, 12.0, 15.2),
    )
)
# A whole step costs more speed than on the paper's drive, although its angle has the torque.
STEEP = tuple(
    steady_scenario(
        HALF_BRIDGE.draw(0, number).document, speed, power_share=share, constant_power=constant_power
    )
    for number, speed, share, constant_power in (
        (44, 458.0, 1.0, True),
        (53, 9920.0, 0.5, False),
        (31, 1820.0, 0.65, False),
        (73, 1110.0, 1.0, True),
        (82, 5150.0, 1.0, True),
    )
)
# A regulator wound up on the way back takes more current than the load needs, which is no other load; and it needs no
# less than at the good angle.
WOUND_UP = (
    *(
        vehicle_scenario(STAR, speed, mass_units=mass, gear_units=gear, grade_percent=((0.0, 0.0),))
        for speed, mass, gear in ((1320.0, 4, 6), (1340.0, 4, 6), (1480.0, 3, 6), (1480.0, 4, 8))
    ),
    steady_scenario(WIDE_WINDOW, 1500.0, power_share=1.0, constant_power=False).replaced(
        name="1500rpm-9.8Nm",
        load=ConstantTorqueLoad(kind="constant_torque", torque_nm=9.8, factor=coming_on(WIDE_WINDOW)),
    ),
)
RUNS = (
    *SLOWLY_GROWING,
    *STEEP,
    *WOUND_UP,
    # A long climb for torque is searched back by whole steps; after a loss of speed the first small one would mislead
    # as long as the speed is on its way back.
    *(
        steady_scenario(THRUSTER, speed, power_share=1.0, constant_power=True).replaced(
            duration_s=38.0, supply_v=((0.0, 200.0), (20.0, 200.0), (20.0, 184.0))
        )
        for speed in (2060.0, 2070.0, 2100.0)
    ),
    # What a step does comes late, so that each turn of the search seems to pay.
    *(steady_scenario(LIFT, speed, power_share=0.12, constant_power=False) for speed in (1022.5, 1097.5)),
    steady_scenario(FAN, 5550.0, power_share=0.1, constant_power=False),
    vehicle_scenario(FAN, 6000.0, mass_units=4, gear_units=6, grade_percent=((0.0, 0.0),)),
    steady_scenario(TRACTION, 3320.0, power_share=0.1, constant_power=False),
    steady_scenario(BARE_ROTOR, 550.0, power_share=1.0, constant_power=True),
    steady_scenario(BARE_ROTOR, 1500.0, power_share=0.5, constant_power=False),
    # Where no advance is needed, the line is zero and the optimum lies above it.
    *(
        steady_scenario(next(DRAWN_STAR.draws(0, number)), speed, power_share=1.0, constant_power=True)
        for number, speed in ((1, 630.0), (2, 2720.0))
    ),
    # The optimum lies above the initial angle, and steps down lose the torque or change less than noise.
    steady_scenario(next(DRAWN_STAR.draws(0, 14)), 845.0, power_share=1.0, constant_power=True),
    # Sixty degrees from the optimum, a long step costs as much speed as another load.
    steady_scenario(next(DRAWN_STAR.draws(0, 8)), 2190.0, power_share=1.0, constant_power=True),
)
# Past the current of greatest torque, more current reference gives less torque.
FALLING_ON = (
    with_scales(
        steady_scenario(HALF_BRIDGE.draw(0, 9).document, 645.0, power_share=1.0, constant_power=True),
        inductance=1.2,
    ),
    steady_scenario(HALF_BRIDGE.draw(0, 60).document, 4840.0, power_share=0.5, constant_power=False),
)
# A step that loses the torque a little beyond the edge, 60 degrees below the initial angle.
LATE_AT_THE_EDGE = with_scales(
    vehicle_scenario(STAR, 1380.0, mass_units=3, gear_units=8, grade_percent=((0.0, 1.0),)), emf_constant=0.95
).replaced(
    duration_s=25.0,
    supply_v=((0.0, 48.0), (3.0, 48.0), (3.0, 46.08)),
    current_errors=(CurrentError(phase=3, gain=1.0, offset_a=0.5),),
    restarts_s=tuple(5.4 + 0.4 * count for count in range(20)),
)
# And one whose next step would find the speed still falling.
SAGGING_AT_THE_EDGE = steady_scenario(PAPER, 1220.0, power_share=0.5, constant_power=False).replaced(
    name="700-1220rpm",
    control_period_s=0.00025,
    duration_s=16.1,
    initial_speed_rpm=700.0,
    speed_rpm=((0.0, 700.0), (7.0, 700.0), (7.0, 1220.0)),
    supply_v=((0.0, 44.16),),
    load=ConstantTorqueLoad(
        kind="constant_torque", torque_nm=4.1, factor=((0.0, 0.0), (7.0, 0.0), (7.0, 0.6))
    ),
    dropouts=(Dropout(signal="supply", phase=None, start_s=7.0, duration_s=0.01),),
)
# And one whose end alone would not be enough to forbid: the search came back to it in ever smaller steps.
SOON_BACK_AT_THE_EDGE = steady_scenario(STAR, 1380.0, power_share=0.5, constant_power=False).replaced(
    name="1380rpm-10%",
    duration_s=11.2,
    load=ConstantTorqueLoad(kind="constant_torque", torque_nm=10.38, factor=((0.0, 0.0), (0.2, 0.1))),
)
# Loads that change within a search: one that grows, one that falls slowly, and one under which the angle took over.
CHANGED_WITHIN = tuple(
    with_scales(
        with_load_factor(steady_scenario(drive, speed, power_share=share, constant_power=is_power), factor),
        emf_constant=emf,
    ).replaced(duration_s=end)
    for drive, speed, share, is_power, emf, factor, end in (
        (
            PAPER,
            1000.0,
            1.05,
            False,
            1.04,
            ((0.0, 0.0), (8.0, 0.0), (8.0, 0.1), (10.0, 0.1), (10.0, 0.5)),
            19.0,
        ),
        (PAPER, 790.0, 1.0, True, 1.0, ((0.0, 0.0), (0.2, 0.95), (4.0, 0.95), (6.6, 0.7)), 15.6),
        (
            STAR,
            1500.0,
            1.0,
            False,
            1.01,
            ((0.0, 0.0), (12.0, 0.0), (12.0, 0.2), (14.0, 0.2), (14.0, 0.6)),
            25.0,
        ),
    )
)


def recorded_run(scenario: Scenario, name: str = "reference") -> CurrentRecord:
    candidate = resolve_candidate(name)
    run = run_scenario(scenario, load_controller(candidate))
    return CurrentRecord(scenario, run, candidate.declaration)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("scenario", RUNS, ids=lambda scenario: f"{scenario.drive.name}, {scenario.name}")
def test_the_search_rests_at_the_optimum(scenario: Scenario) -> None:
    record = recorded_run(scenario)
    for check in (converges, reaches_optimum):
        margin = check(record)
        assert margin is None or margin.advisory or margin.met, margin


@pytest.mark.parametrize(
    "scenario", FALLING_ON, ids=lambda scenario: f"{scenario.drive.name}, {scenario.name}"
)
def test_a_speed_that_falls_on_is_caught_before_the_regulator_winds_up(scenario: Scenario) -> None:
    record = recorded_run(scenario)
    for window in record.windows():
        value, measured = window_convergence(window)
        assert value >= 0.0, measured


@pytest.mark.parametrize(
    "scenario", CHANGED_WITHIN, ids=lambda scenario: f"{scenario.drive.name}, {scenario.name}"
)
def test_what_a_search_has_found_is_not_taken_for_another_load_s(scenario: Scenario) -> None:
    record = recorded_run(scenario)
    optimum = reaches_optimum(record)
    assert optimum is None or optimum.met, optimum
    *_, last = record.windows()
    value, measured = window_convergence(last)
    assert value >= 0.0, measured


@pytest.mark.parametrize("share", [0.5, 0.75])
def test_the_angle_regulates_the_speed_where_the_emf_exceeds_the_supply(share: float) -> None:
    """There, at 1900 rpm, the least current sum is that of a current without limit."""
    scenario = steady_scenario(PAPER, 1900.0, power_share=share, constant_power=False)
    margin = CNV_2.evaluate(recorded_run(scenario))
    assert margin is not None, "CNV-2 judges this run"
    assert margin.value > 0.95, margin


@pytest.mark.parametrize(
    ("name", "scenario", "check"),
    [
        ("near:speed-offset", LATE_AT_THE_EDGE, ROB_2),
        ("near:speed-offset", SAGGING_AT_THE_EDGE, ROB_3),
        ("near:gain-doubled", SOON_BACK_AT_THE_EDGE, CNV_1),
    ],
    ids=["late", "sagging", "soon back"],
)
def test_a_step_that_loses_the_torque_is_given_back_whole(
    name: str, scenario: Scenario, check: Check
) -> None:
    margin = check.evaluate(recorded_run(scenario, name))
    assert margin is not None, f"{check.id} judges this run"
    assert margin.met, margin
