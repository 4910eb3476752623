"""Campaigns of controllers that answer with duty ratios: the same command, with the checks of their contract."""

import json
from pathlib import Path

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.catalogue import all_contracts
from drivegate.studies.campaign.file import read_campaign
from drivegate.studies.campaign.plan import planned
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError

CASE = {
    "schema": 2,
    "drive": "pm-ac-interior",
    "duration_s": 0.05,
    "speed_rpm": [[0.0, 900.0]],
}


@pytest.fixture
def duty_cases(folder: Path) -> list[str]:
    """A short run that follows a torque on a dynamometer, and one that follows a speed under a load."""
    torque = {"kind": "dynamometer", "torque_reference_nm": [[0.0, 0.0], [0.02, 0.0], [0.02, 0.8]]}
    speed = {"kind": "constant_torque", "torque_nm": 0.4, "factor": [[0.0, 1.0]]}
    for name, load in (("torque", torque), ("speed", speed)):
        (folder / f"{name}.json").write_text(
            json.dumps(CASE | {"name": name, "load": load}), encoding="utf-8"
        )
    return ["torque.json", "speed.json"]


@pytest.fixture
def plan(write, folder, duty_cases):
    """Plan a campaign of such cases."""

    def made(**changes):
        return planned(
            read_campaign(write(**{"candidates": ["foc"], "cases": duty_cases, **changes})), folder
        )

    return made


def test_the_first_runs_are_made_by_a_candidate_of_the_contract(plan):
    for contract in all_contracts():
        assert resolve_candidate(contract.rehearsed).contract == contract.name


def test_parameters_change_the_plant_and_the_drive_of_a_case(plan):
    run = plan(
        grid={"load_share": [0.5], "direct_inductance_h": [0.01], "supply_share": [0.9]},
        spread={"emf_constant": {"kind": "uniform", "lowest": 0.9, "highest": 0.95}},
    ).run(0)
    scenario = run.scenario
    assert scenario.load.torque_reference_nm == ((0.0, 0.0), (0.02, 0.0), (0.02, 0.4))
    assert scenario.drive.machine.direct_inductance_h == 0.01
    assert scenario.scales.emf_constant == run.parameters["emf_constant"] < 0.95
    assert scenario.supply_profile[0][1] == pytest.approx(0.9 * scenario.drive.inverter.supply_voltage_v)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        (
            {"candidates": ["reference"]},
            "'reference' answers with a current reference and an advance angle, but",
        ),
        ({"cases": ["torque.json", "fig5-search"]}, "make a campaign of each"),
        ({"checks": ["CNV-1"]}, "the check 'CNV-1' does not judge controllers that answer with duty ratios"),
        (
            {"grid": {"hysteresis_band_a": [0.1]}},
            "which has no key 'hysteresis_band_a'; leave it out of the grid",
        ),
        ({"grid": {"dead_time_s": [1.0]}}, "'dead_time_s' is 1, but must be at most a quarter"),
        (
            {"candidates": ["inner:pi:reference"]},
            "has a reference of the torque, which the candidate 'inner:pi:reference' declares not to follow",
        ),
    ],
)
def test_what_does_not_fit_the_contract_is_refused(plan, changes, reason):
    with pytest.raises(InputError) as refused:
        plan(**changes)
    assert reason in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_case_takes_the_control_period_of_the_drive_that_takes_its_own_s_place(write, folder, duty_cases):
    other = load_drive("pm-ac-surface").with_overrides(["carrier_frequency_hz=20000"])
    campaign = read_campaign(write(candidates=["foc"], cases=duty_cases))
    scenario = planned(campaign, folder, other).run(0).scenario
    assert scenario.control_period_s == other.control_period_s == 5e-5
