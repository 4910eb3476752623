"""Checks on a drive of one's own: its limits judge, and its numbers stand in the texts."""

import re

import pytest

from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.candidates.declaration import Declaration
from drivegate.contracts.catalogue import TEXTS, on_drive
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.contracts.traceability import traced_checks
from drivegate.drives.running import run_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.requirements import RequiredPoint
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.controllers.current.builtin import SEARCHES
from drivegate_models.units import RADIANS_PER_RPM

PAPER = load_drive("paper-5-phase")
BY_ID = {check.id: check for check in CHECKS}
OTHER = PAPER.replaced(
    base_speed_rpm=3000.0,
    highest_speed_rpm=8000.0,
    overspeed_rpm=9000.0,
    rated_power_w=60.0,
    current_limit_a=7.5,
    inertia_kg_m2=2e-5,
    requirements={},
)
NUMBERS_OF_THE_PAPER = re.compile(
    r"\b(500|550|1500|2000) rpm|1\.5 kW|26 A|9\.8 N·m|\b5 rpm|0\.5 N·m|three times base speed"
)


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.id)
def test_no_number_of_the_paper_is_reported_of_another_drive(check) -> None:
    reported = on_drive(check, OTHER)
    for name in set(TEXTS) - {"why"}:
        text = getattr(reported, name)
        assert "{" not in text, f"{check.id}: {name} has a number that was not written: {text}"
        assert not NUMBERS_OF_THE_PAPER.search(text), f"{check.id}: {name} is the paper's: {text}"


def test_the_numbers_are_the_drive_s() -> None:
    rows = {row["id"]: row for row in traced_checks(OTHER)}
    assert rows["CPW-1"]["requirement"] == (
        "Constant power: 60 W is held within k1 at every speed from 3240 to 8000 rpm."
    )
    assert rows["CMD-1"]["limit"] == "0 to 7.5 A"
    assert rows["ADV-1"]["limit"] == "exactly 0° below 3000 rpm"
    assert rows["CNV-1"]["limit"] == "k1 = 30 rpm, k2 = 0.5 % of Σ|i|, 1°"
    assert rows["RIP-1"]["requirement"].startswith("Torque ripple at 8000 rpm and 0.0735 N·m,")


def test_the_paper_s_texts_are_as_published() -> None:
    rows = {row["id"]: row for row in traced_checks(PAPER)}
    assert rows["CPW-1"]["requirement"] == (
        "Constant power: 1.5 kW is held within k1 at every speed from 550 to 1500 rpm."
    )
    assert rows["RIP-1"]["requirement"].startswith("Torque ripple at 1500 rpm and 9.8 N·m,")
    assert rows["ROB-1"]["requirement"].endswith("and up to 0.5 N·m of friction added.")
    assert rows["CNV-2"]["limit"] == "2 % above the least Σ|i|"


def test_the_sensors_are_those_that_the_drive_has() -> None:
    for drive, reported in (
        (PAPER, "the sensors of the published implementation: encoder, Hall sensors, converter."),
        (load_drive("star-3-phase"), "three Hall switches, current sensors, converter."),
    ):
        (row,) = [row for row in traced_checks(drive) if row["id"] == "ROB-2"]
        assert row["requirement"].startswith("CNV-1 and CNV-3 hold through the sensors of")
        assert row["requirement"].endswith(reported)


def test_a_star_is_said_to_have_neither_an_encoder_nor_halves_to_be_unequal() -> None:
    for drive, requirement, sensor in (
        (
            PAPER,
            "sensor dropouts and encoder glitches, and with unequal halves of the supply and drifting parameters",
            "an encoder",
        ),
        (load_drive("star-3-phase"), "sensor dropouts, and with drifting parameters", "Hall switches"),
    ):
        reported = on_drive(BY_ID["ROB-3"], drive)
        assert reported.requirement == f"CNV-1 and CNV-3 hold after {requirement}."
        assert f"(through {sensor} as ROB-2)" in reported.limit


def test_a_candidate_s_speeds_are_compared_with_the_drive_s() -> None:
    declaration = Declaration(speed_range_rpm=(3240.0, 7000.0))
    assert BY_ID["CPW-1"].reason_not_applicable(declaration, OTHER) is None
    reason = BY_ID["CPW-1"].reason_not_applicable(declaration, PAPER)
    assert reason is not None
    assert reason.endswith("none of the speeds from 550 to 1500 rpm")


@pytest.mark.parametrize(
    ("requirement", "window", "check"),
    [
        ({"speed_tolerance_rpm": 2.0}, {"SPEED_ERROR": 3.0 * RADIANS_PER_RPM}, "CNV-1"),
        ({"angle_tolerance_deg": 0.1}, {"ANGLE_HIGHEST": 0.925}, "CNV-1"),
        ({"closed_loop_ripple_percent": 8.0}, {"RIPPLE": 0.1}, "RIP-3"),
    ],
)
def test_a_stated_limit_judges(record, scenario, checks, requirement, window, check) -> None:
    stated = scenario().replaced(drive=PAPER.replaced(**requirement))
    assert checks[check].evaluate(record(scenario(), window=window)).met, "with the paper's limit"
    assert not checks[check].evaluate(record(stated, window=window)).met, f"with {requirement}"


def test_the_ripple_is_judged_at_every_required_point(record, scenario, checks) -> None:
    run = scenario(speed_rpm=[[0.0, 1200.0]])
    assert checks["RIP-1"].evaluate(record(run)) is None, "1200 rpm is no required point of the paper"
    torque = run.load.torque_nm
    point = RequiredPoint(speed_rpm=1200.0, torque_n_m=torque)
    assert checks["RIP-1"].evaluate(record(run.replaced(drive=PAPER.replaced(point=(point,))))) is not None


@pytest.mark.parametrize("name", ["lock-up", "700rpm-1500W", "1150rpm-1500W"])
def test_a_drive_of_twice_the_voltage_is_judged_like_the_paper_s(name: str) -> None:
    """All of it is the same in shares of its rating: so are scenarios, currents and margins."""
    twice = PAPER.replaced(
        name="twice",
        supply_voltage_v=96.0,
        resistance_ohm=0.16,
        inductance_h=5.76e-3,
        emf_constant_v_s_per_rad=0.678,
        core_loss_conductance_s=1.5e-3,
        inertia_kg_m2=0.1,
        rated_power_w=3000.0,
        requirements={},
    )
    place = [scenario.name for scenario in fixed_scenarios(PAPER)].index(name)
    on_paper, on_twice = (
        {check.id: check.evaluate(record) for check in CHECKS}
        for drive in (PAPER, twice)
        for record in [made(fixed_scenarios(drive)[place])]
    )
    for check in ("ADV-2", "CMD-1", "RIP-1", "CNV-1", "CNV-2", "CNV-3", "CPW-1"):
        one, other = on_paper[check], on_twice[check]
        assert (one is None) == (other is None), f"{check} judges one of them alone"
        if one is not None and other is not None:
            assert other.value == pytest.approx(one.value, abs=0.02), f"{check}: {one} and {other}"


def made(scenario: Scenario) -> CurrentRecord:
    run = run_scenario(scenario, BuiltinController(SEARCHES["reference"]))
    return CurrentRecord(scenario, run, Declaration(estimates_power=True))
