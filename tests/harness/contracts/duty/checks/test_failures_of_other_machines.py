"""Failures on machines of little inductance, little inertia or low speed, noticed by two independent detectors."""

from __future__ import annotations

from typing import Any

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.scenarios.building import (
    failing,
    speed_scenario,
    torque_of,
    torque_scenario,
)
from drivegate.contracts.duty.scenarios.drawn_range import unnoticed_because
from drivegate.drives.running import recorded
from drivegate.scenarios.changes import with_dropout, with_real_sensors
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.failure_kind import FailureKind
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.scenario import Scenario

NAMES = ("foc", "load-observer")


def made(inductance: float, speeds: tuple[float, float, float], **values: float | str) -> PmAcDocument:
    """Make a drive of one inductance (H), and of base, highest and overspeed (rpm)."""
    drive = load_drive("pm-ac-surface")
    assert isinstance(drive, PmAcDocument)
    given: dict[str, Any] = {
        "core_loss_conductance_s": 0.0,
        "direct_inductance_h": inductance,
        "quadrature_inductance_h": inductance,
        **dict(zip(("base_speed_rpm", "highest_speed_rpm", "overspeed_rpm"), speeds, strict=True)),
    }
    return drive.replaced(**given, **values)


def little_inductance(inductance: float, frequency: float) -> PmAcDocument:
    """Make a 24 V drive of 25 A with 7 pole pairs."""
    return made(
        inductance,
        (3500.0, 4000.0, 4400.0),
        pole_pairs=7,
        resistance_ohm=0.02762,
        magnet_flux_v_s=0.003931,
        inertia_kg_m2=7.06e-5,
        link_voltage_v=24.0,
        carrier_frequency_hz=frequency,
        rated_power_w=208.0,
        current_limit_a=25.0,
    )


EIGHT, TWELVE, TWENTY_THREE = (
    little_inductance(*values) for values in ((8e-6, 40e3), (1.258e-5, 20e3), (2.3e-5, 20e3))
)
FEW_SAMPLES = made(
    1.57e-5,
    (3000.0, 4200.0, 4600.0),
    pole_pairs=7,
    resistance_ohm=0.039,
    magnet_flux_v_s=0.002917,
    inertia_kg_m2=5e-5,
    link_voltage_v=24.0,
    carrier_frequency_hz=8e3,
    rated_power_w=265.0,
    current_limit_a=60.0,
)
"""An outrunner whose EMF at base speed moves the current by 51 A in a control period."""
HIGH_PEAK = made(
    6.5e-3,
    (4500.0, 6000.0, 6600.0),
    pole_pairs=3,
    resistance_ohm=2.4,
    magnet_flux_v_s=0.0815,
    inertia_kg_m2=6.6e-5,
    link_voltage_v=320.0,
    carrier_frequency_hz=8e3,
    rated_power_w=488.0,
    current_limit_a=12.0,
)
"""A servo whose peak current is four times the rated one."""
SLOW = made(
    0.003,
    (150.0, 180.0, 200.0),
    pole_pairs=30,
    resistance_ohm=0.05,
    magnet_flux_v_s=0.76,
    inertia_kg_m2=2.0,
    link_voltage_v=750.0,
    carrier_frequency_hz=3000.0,
    rated_power_w=49393.0,
    current_limit_a=150.0,
)
"""72 V of EMF at 30 rpm."""
HUB = made(
    1.2e-4,
    (220.0, 330.0, 363.0),
    pole_pairs=23,
    resistance_ohm=0.08,
    magnet_flux_v_s=0.0135,
    inertia_kg_m2=0.02,
    link_voltage_v=36.0,
    carrier_frequency_hz=16e3,
    dead_time_s=1e-6,
    rated_power_w=250.0,
    current_limit_a=30.0,
)
"""The hub of a bicycle."""
FAN = made(
    0.045,
    (2000.0, 2600.0, 2860.0),
    pole_pairs=4,
    resistance_ohm=12.0,
    magnet_flux_v_s=0.19,
    inertia_kg_m2=0.0012,
    link_voltage_v=310.0,
    carrier_frequency_hz=16e3,
    dead_time_s=1.5e-6,
    switch_drop_v=1.2,
    diode_drop_v=1.0,
    rated_power_w=160.0,
    current_limit_a=2.4,
)
"""A machine of great inductance and resistance."""
LIGHT = made(
    0.00143,
    (17.8, 19.0, 20.9),
    pole_pairs=52,
    resistance_ohm=0.00525,
    magnet_flux_v_s=3.725,
    inertia_kg_m2=1940.0,
    link_voltage_v=1200.0,
    carrier_frequency_hz=3000.0,
    rated_power_w=1.55e6,
    current_limit_a=3252.7,
)
"""A generator of 1.5 MW, whose rated torque accelerates it to base speed in 13 control periods."""
TRACTION = made(
    0.0016,
    (1500.0, 5000.0, 5500.0),
    pole_pairs=4,
    resistance_ohm=0.069,
    magnet_flux_v_s=0.175,
    inertia_kg_m2=0.05,
    link_voltage_v=500.0,
    carrier_frequency_hz=10e3,
    dead_time_s=2e-6,
    switch_drop_v=1.0,
    diode_drop_v=1.2,
    rated_power_w=25e3,
    current_limit_a=250.0,
).replaced(quadrature_inductance_h=0.00206)
"""A machine of a car, with 22 V of EMF at a fifth of base speed."""


def assert_safe(name: str, run: Scenario) -> None:
    loaded = own_candidate(resolve_candidate(name))
    margins = judged(recorded(loaded, run, loaded.controller()), contract_of(run.drive).checks).margins
    found = [margin for margin in margins if margin.check == "SAF-1"]
    assert found
    assert all(margin.met for margin in found), found


def assert_goes_on(name: str, run: Scenario) -> None:
    loaded = own_candidate(resolve_candidate(name))
    commands = recorded(loaded, run, loaded.controller()).run.commands
    assert not commands["fault"].any(), f"code {commands['fault'].max()} although nothing fails"


def under_torque(drive: PmAcDocument, speed_rpm: float, share: float = 0.5) -> Scenario:
    return torque_scenario(drive, speed_rpm, (torque_of(drive, speed_rpm, share),))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("phase", [1, 2, 3])
@pytest.mark.parametrize(
    ("drive", "speed_rpm"),
    [
        (EIGHT, 700.0),
        (EIGHT, 3500.0),
        (TWELVE, 2050.0),
        (TWENTY_THREE, 700.0),
        (HUB, 44.0),
        (FAN, 400.0),
        (FEW_SAMPLES, 3000.0),
        (HIGH_PEAK, 4500.0),
    ],
)
def test_an_open_phase_is_noticed_although_its_diodes_carry_current(
    drive: PmAcDocument, speed_rpm: float, phase: int, name: str
) -> None:
    run = with_real_sensors(under_torque(drive, speed_rpm), 2)
    assert_safe(name, failing(run, "open-phase", 0.55 * run.duration_s, phase))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["stuck-current", "lost-position", "slip"])
def test_sensors_that_fail_at_little_inductance_are_noticed(kind: FailureKind, name: str) -> None:
    run = under_torque(EIGHT, 2050.0)
    seen = run if kind == "slip" else with_real_sensors(run, 2)
    slip = 60.0 if kind == "slip" else None
    assert_safe(name, failing(seen, kind, 0.55 * run.duration_s, slip_deg=slip))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["open-phase", "lost-position"])
def test_failures_of_a_slow_machine_with_much_emf_are_noticed(kind: FailureKind, name: str) -> None:
    run = with_real_sensors(under_torque(SLOW, 30.0), 2)
    assert_safe(name, failing(run, kind, 0.55 * run.duration_s))


@pytest.mark.parametrize("name", NAMES)
def test_an_encoder_that_stops_at_a_fifth_of_base_speed_is_noticed(name: str) -> None:
    run = with_real_sensors(under_torque(TRACTION, 300.0), 1)
    assert_safe(name, failing(run, "lost-position", 0.6))


@pytest.mark.parametrize("name", NAMES)
def test_a_light_rotor_that_does_not_start_is_noticed_once_the_torque_has_risen(name: str) -> None:
    base = LIGHT.rating.base_speed_rpm
    start = speed_scenario(LIGHT, (base,), torque_nm=torque_of(LIGHT, base, 0.5), initial_speed_rpm=0.0)
    assert_safe(name, failing(start, "locked-rotor", 0.0))


@pytest.mark.parametrize(
    ("speed_rpm", "kind", "real", "hidden"),
    [
        (44.0, "lost-position", True, True),
        (66.0, "lost-position", True, False),
        (44.0, "lost-position", False, False),
        (44.0, "open-phase", True, False),
    ],
)
def test_an_encoder_that_stops_counts_where_the_emf_shows_it(
    speed_rpm: float, kind: FailureKind, real: bool, hidden: bool
) -> None:
    """At 44 rpm the hub has 1.4 V of EMF, 0.9 V across its resistance, and 0.6 V of uncertain link and dead time."""
    run = under_torque(HUB, speed_rpm)
    because = unnoticed_because(failing(with_real_sensors(run, 2) if real else run, kind, 0.1))
    assert (because is not None) is hidden


RECTIFYING = made(
    0.0222,
    (128.0, 333.0, 343.0),
    pole_pairs=19,
    resistance_ohm=0.312,
    magnet_flux_v_s=0.178,
    inertia_kg_m2=0.108,
    link_voltage_v=107.0,
    carrier_frequency_hz=2840.0,
    carrier="double",
    rated_power_w=257.0,
    current_limit_a=4.72,
).replaced(
    core_loss_conductance_s=0.00191,
    direct_inductance_h=0.0216,
    dead_time_s=2.27e-6,
    switch_drop_v=0.162,
    diode_drop_v=0.162,
)
"""Above base speed the diodes conduct 3 A, which little voltage is left to turn round."""


@pytest.mark.parametrize("name", NAMES)
def test_no_phase_is_missed_while_the_current_of_the_diodes_turns_round(name: str) -> None:
    assert_goes_on(name, torque_scenario(RECTIFYING, 230.0, (7.0,)))


TURNING_ROUND = made(
    0.0817,
    (365.0, 945.0, 1020.0),
    pole_pairs=11,
    resistance_ohm=1.9,
    magnet_flux_v_s=0.103,
    inertia_kg_m2=0.228,
    link_voltage_v=127.0,
    carrier_frequency_hz=3700.0,
    carrier="double",
    rated_power_w=144.0,
    current_limit_a=2.34,
).replaced(
    core_loss_conductance_s=0.00103,
    direct_inductance_h=0.0389,
    friction_n_m=0.0252,
    viscous_friction_n_m_s_per_rad=0.00171,
    dead_time_s=4.23e-7,
)
"""It turns round so close to an edge of the encoder that this shows 50 rpm for two control periods."""


@pytest.mark.parametrize("name", NAMES)
def test_a_shaft_that_turns_round_at_an_edge_is_neither_lost_nor_locked(name: str) -> None:
    reversal = speed_scenario(TURNING_ROUND, (180.0, -180.0), torque_nm=1.8837)
    assert_goes_on(name, with_real_sensors(reversal, 1))


@pytest.mark.parametrize("name", [*NAMES, "predictive-flux"])
def test_a_lost_sample_at_a_step_of_the_reference_is_no_missing_phase(name: str) -> None:
    """The currents that it does not show are farther from the new reference than from the old one."""
    drive = load_drive("pm-ac-interior")
    assert isinstance(drive, PmAcDocument)
    step = torque_scenario(drive, 2100.0, (-0.4547, 1.9326))
    assert isinstance(step.load, DynamometerLoad)
    begins = step.load.torque_reference_nm[-1][0]
    assert_goes_on(name, with_dropout(step, "currents", begins, step.control_period_s))


def test_a_shaft_that_locks_under_a_torque_reference_counts_for_nobody() -> None:
    """Its EMF moves the torque within the first control period, before any sample shows it."""
    because = unnoticed_because(failing(under_torque(HUB, HUB.rating.base_speed_rpm), "locked-rotor", 0.1))
    assert "under a torque reference" in str(because), because
