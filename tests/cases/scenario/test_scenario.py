import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.profile import dwells
from drivegate_cases.scenario.scenario import Scenario, load_scenario, scenario_names


@pytest.mark.parametrize("name", scenario_names())
def test_every_scenario_of_the_package_loads_and_starts_unloaded(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.name == name
    assert scenario.description
    if scenario.drive.contract == "current":
        assert scenario.load_profile[0] == (0.0, 0.0), "a run has to start in a true steady state"
        assert scenario.initial_speed_rpm == scenario.speed_rpm[0][1]
    assert dwells(scenario), "nothing can be judged in a run without a dwell"


@pytest.mark.parametrize(("name", "duration"), [("fig5-search", 12.0), ("lock-up", 20.0)])
def test_the_runs_of_the_paper_are_at_its_operating_point(name: str, duration: float) -> None:
    scenario = load_scenario(name)
    assert scenario.duration_s == duration
    assert scenario.speed_rpm == ((0.0, 1500.0),)
    assert isinstance(scenario.load, ConstantTorqueLoad)
    assert scenario.load.torque_nm == 9.8


def test_the_defaults(scenario_mapping: dict[str, Any]) -> None:
    scenario = parse_document(scenario_mapping, Scenario, "here")
    assert scenario.drive == load_drive("paper-5-phase")
    assert scenario.control_period_s == 0.0005
    assert scenario.control_periods == 2000
    assert scenario.initial_speed_rpm == 1500.0
    assert scenario.supply_profile == ((0.0, 48.0),)
    assert scenario.load_profile == ((0.0, 0.0), (0.2, 1.0))
    assert scenario.sensors.kind == "ideal"
    assert scenario.scales.resistance == 1.0


def test_an_omitted_supply_follows_the_drive(scenario_mapping: dict[str, Any]) -> None:
    scenario = parse_document(scenario_mapping, Scenario, "here")
    stronger = scenario.replaced(drive=scenario.drive.with_overrides(["supply_voltage_v=60"]))
    assert stronger.supply_profile == ((0.0, 60.0),)


def test_a_written_scenario_holds_its_drive_not_a_name(scenario_mapping: dict[str, Any]) -> None:
    written = json.loads(parse_document(scenario_mapping, Scenario, "here").to_json())
    assert written["drive"]["machine"]["inductance_h"] == load_drive("paper-5-phase").machine.inductance_h


def test_a_drive_file_is_looked_for_beside_the_scenario(
    tmp_path: Path, scenario_mapping: dict[str, Any]
) -> None:
    (tmp_path / "mine.json").write_text(load_drive("paper-5-phase").replaced(name="mine").to_json())
    (tmp_path / "run.json").write_text(json.dumps(scenario_mapping | {"drive": "mine.json"}))
    assert load_scenario(tmp_path / "run.json").drive.name == "mine"


def test_a_drive_may_stand_in_the_scenario_without_schema(scenario_mapping: dict[str, Any]) -> None:
    drive = load_drive("paper-5-phase").to_mapping()
    del drive["schema"]
    assert parse_document(scenario_mapping | {"drive": drive}, Scenario, "here").drive.machine.phases == 5


RAMP = [[0, 0], [0.2, 1]]


@pytest.mark.parametrize(
    ("changes", "reported"),
    [
        ({"drive": "paper-3-phase"}, "in the key 'drive', no drive is called 'paper-3-phase'"),
        ({"drive": "none.toml"}, "in the key 'drive', none.toml does not exist"),
        ({"drive": 5}, "the key 'drive' is 5, but must be a table"),
        ({"drive": {"machine": {"phases": 99}}}, "the key 'drive.machine.phases' is 99"),
        ({"drive": {"schema": 7}}, "the key 'drive.schema' is 7, but must be 1 here"),
        ({"sclaes": {}}, "the key 'sclaes' is unknown, the nearest known key is 'scales'"),
        (
            {"scales": {"inductanse": 1}},
            "the key 'scales.inductanse' is unknown, the nearest known key is 'induc",
        ),
        ({"scales": {"inductance": 0}}, "the key 'scales.inductance' is 0"),
        ({"scales": {"friction_added_n_m": -1}}, "the key 'scales.friction_added_n_m' is -1"),
        ({"duration_s": 0}, "the key 'duration_s' is 0, but must be greater than 0"),
        ({"duration_s": 1e9}, "the key 'duration_s'"),
        ({"duration_s": 0.70013}, "must be a whole number of control periods of 0.0005 s, such as 0.7"),
        ({"duration_s": 1e-7}, "must be a whole number of control periods of 0.0005 s, such as 0.0005"),
        ({"control_period_s": 0.001}, "the key 'control_period_s' is 0.001"),
        ({"control_period_s": 0}, "the key 'control_period_s' is 0"),
        ({"seed": -1}, "the key 'seed' is -1"),
        ({"seed": 2**63}, "the key 'seed'"),
        ({"seed": 1.0}, "the key 'seed' is 1.0, but must be a whole number"),
        (
            {"sensors": "perfect"},
            "the key 'sensors.kind' is \"perfect\", but must be one of 'ideal', 'mcs96', 'hall'",
        ),
        (
            {"sensors": "hall"},
            "the sensors 'hall' are three switches for a drive with 3 phases, but this one has 5",
        ),
        (
            {"drive": "star-3-phase", "sensors": {"kind": "hall", "placement_error_deg": 16}},
            "the key 'sensors.placement_error_deg' is 16, but must be less than or equal to 15",
        ),
        (
            {"drive": "star-3-phase", "sensors": {"kind": "hall", "hysteresis_deg": float("nan")}},
            "the key 'sensors.hysteresis_deg' is NaN",
        ),
        (
            {"drive": "star-3-phase", "sensors": {"kind": "hall", "encoder_lines": 500}},
            "the key 'sensors.encoder_lines' is unknown",
        ),
        (
            {"drive": "star-3-phase", "sensors": "hall", "glitches": [{"time_s": 0.1, "counts": 3}]},
            "the key 'glitches' needs the sensors 'mcs96', or an encoder on a PM AC drive, since 'hall' have no ",
        ),
        ({"initial_speed_rpm": -1}, "the key 'initial_speed_rpm' is -1"),
        ({"speed_rpm": "1500"}, "the key 'speed_rpm' is \"1500\", but must be a number, a list"),
        ({"speed_rpm": []}, "must have its first point at time 0"),
        (
            {"speed_rpm": [[0, -5]]},
            'must have speeds from 0, since a drive of the kind "half-bridge" turns forward',
        ),
        (
            {"drive": "pm-ac-surface", "speed_rpm": [[0, -2e6]]},
            "must have speeds of at most 1e+06 rpm either way on this drive",
        ),
        (
            {"load": {"kind": "hoist", "torque_nm": 1, "factor": RAMP}},
            "the load 'hoist' is for drives of the kind",
        ),
        ({"speed_rpm": [[0.1, 5]]}, "must have its first point at time 0"),
        ({"speed_rpm": [[0, 5], [0.5, 5], [0.4, 5]]}, "must have times that never decrease"),
        ({"speed_rpm": [[0, 5], [1.5, 5]]}, "the key 'speed_rpm' has a point at 1.5 s, but must end within"),
        ({"speed_rpm": [[0, float("nan")]]}, "the key 'speed_rpm[0][1]' is NaN"),
        ({"speed_rpm": [[float("inf"), 1]]}, "the key 'speed_rpm[0][0]' is Infinity"),
        ({"supply_v": [[0, 0]]}, "must have voltages above 0"),
        ({"supply_v": [[0, 48], [2, 48]]}, "the key 'supply_v' has a point at 2.0 s"),
        ({"load": {"kind": "crane"}}, "the key 'load.kind' is \"crane\", but must be one of 'locked'"),
        ({"load": {"kind": "locked", "factor": RAMP}}, "the key 'load.factor' is unknown"),
        ({"load": {"kind": "constant_torque", "factor": RAMP}}, "the key 'load.torque_nm' is missing"),
        ({"load": {"kind": "constant_torque"}}, "the key 'load.torque_nm' is missing"),
        (
            {"load": {"kind": "constant_torque", "torque_nm": 1, "factor": RAMP, "power_w": 1}},
            "the key 'load.power_w' is unknown",
        ),
        ({"load": {"kind": "constant_power", "power_w": -1, "factor": RAMP}}, "the key 'load.power_w' is -1"),
        ({"load": {"kind": "fan", "torque_nm": 1, "factor": RAMP}}, "the key 'load.speed_rpm' is missing"),
        (
            {"load": {"kind": "fan", "torque_nm": 1, "speed_rpm": 0, "factor": RAMP}},
            "the key 'load.speed_rpm' is 0",
        ),
        (
            {"load": {"kind": "constant_torque", "torque_nm": 1, "factor": [[0, -1]]}},
            "must have shares from 0",
        ),
        (
            {"load": {"kind": "constant_torque", "torque_nm": 1, "factor": [[0, 1], [3, 1]]}},
            "the key 'load.factor' has a point at 3.0 s",
        ),
        (
            {"load": {"kind": "locked"}, "initial_speed_rpm": 10},
            "the key 'initial_speed_rpm' is 10.0, but must be the first speed reference",
        ),
        ({"initial_angle_deg": 360.0}, "the key 'initial_angle_deg' is 360.0"),
        ({"clock_start_s": -1}, "the key 'clock_start_s' is -1"),
        ({"restarts_s": [0.5, 0.5]}, "must have times above 0 that increase"),
        ({"restarts_s": [0.0]}, "must have times above 0 that increase"),
        ({"restarts_s": [1.5]}, "the key 'restarts_s' has one that ends at 1.5 s, but must end within"),
        ({"current_errors": [{"phase": 1}]}, "must give a 'gain' other than 1"),
        ({"current_errors": [{"phase": 6, "gain": 0.5}]}, "names the phase 6, but the motor has 5"),
        ({"current_errors": [{"phase": 2, "gain": 0.5}] * 2}, "must name each phase at most once"),
        (
            {"dropouts": [{"signal": "speed", "phase": 1, "start_s": 0.1, "duration_s": 0.1}]},
            "must not give 'phase' for the signal 'speed'",
        ),
        (
            {"dropouts": [{"signal": "currents", "phase": 6, "start_s": 0.1, "duration_s": 0.1}]},
            "the key 'dropouts' names the phase 6",
        ),
    ],
)
def test_a_wrong_scenario_is_reported(
    scenario_mapping: dict[str, Any], refusal: Callable[..., str], changes: dict[str, Any], reported: str
) -> None:
    message = refusal(parse_document, scenario_mapping | changes, Scenario, "run.toml")
    assert message.startswith("run.toml: ")
    assert reported in message


def test_a_wrong_profile_is_reported_once(
    scenario_mapping: dict[str, Any], refusal: Callable[..., str]
) -> None:
    message = refusal(
        parse_document, scenario_mapping | {"speed_rpm": [["a", "b", "c"]]}, Scenario, "run.toml"
    )
    assert "initial_speed_rpm" not in message


@pytest.mark.parametrize(
    ("speed", "valid"),
    [
        ([[0, 0], [0.1, 500]], True),
        ([[0, 500], [0.5, 0]], False),
        ([[0, 500], [0.5, 500], [0.5, 0], [0.6, 500]], False),
        ([[0, 0], [0.3, 500]], True),
        ([[0, 0], [0.1, 0], [0.4, 500]], True),
        ([[0, 0], [0.3, 0], [0.4, 500]], False),
    ],
)
def test_constant_power_needs_a_turning_shaft(
    scenario_mapping: dict[str, Any], refusal: Callable[..., str], speed: list[list[float]], valid: bool
) -> None:
    load = {"kind": "constant_power", "power_w": 1500, "factor": [[0, 0], [0.25, 0], [0.3, 1]]}
    mapping = scenario_mapping | {"speed_rpm": speed, "load": load}
    if valid:
        assert parse_document(mapping, Scenario, "here").speed_rpm[-1] == tuple(speed[-1])
    else:
        assert "the key 'speed_rpm' is 0 at" in refusal(parse_document, mapping, Scenario, "here")


def test_a_locked_shaft_has_the_whole_load_throughout(scenario_mapping: dict[str, Any]) -> None:
    scenario = parse_document(scenario_mapping | {"load": {"kind": "locked"}}, Scenario, "here")
    assert scenario.load_profile == ((0.0, 1.0),)


@pytest.mark.parametrize("name", ["fig5-serch", "no/such.toml", "run.txt"])
def test_an_unknown_scenario_is_refused(refusal: Callable[..., str], name: str) -> None:
    refusal(load_scenario, name)


FACTORS = st.lists(st.floats(0.0, 10.0), min_size=1, max_size=4).map(
    lambda shares: [[0.25 * index, share] for index, share in enumerate(shares)]
)
LOADS = st.one_of(
    st.just({"kind": "locked"}),
    st.builds(
        lambda torque, factor: {"kind": "constant_torque", "torque_nm": torque, "factor": factor},
        st.floats(0.0, 100.0),
        FACTORS,
    ),
    st.builds(
        lambda power, factor: {"kind": "constant_power", "power_w": power, "factor": factor},
        st.floats(0.0, 1e4),
        FACTORS,
    ),
    st.builds(
        lambda torque, factor: {"kind": "fan", "torque_nm": torque, "speed_rpm": 1500, "factor": factor},
        st.floats(0.0, 100.0),
        FACTORS,
    ),
)


@given(
    LOADS,
    st.floats(1.0, 3000.0),
    st.floats(1.0, 3000.0),
    st.none() | st.floats(10.0, 100.0),
    st.floats(0.5, 2.0),
    st.integers(0, 2**63 - 1),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_scenario_survives_a_round_trip(
    scenario_mapping: dict[str, Any],
    load: dict[str, Any],
    first: float,
    second: float,
    supply: float | None,
    resistance: float,
    seed: int,
) -> None:
    changes: dict[str, Any] = {
        "load": load,
        "speed_rpm": [[0, first], [0.5, first], [0.5, second]],
        "scales": {"resistance": resistance},
        "seed": seed,
    }
    if supply is not None:
        changes["supply_v"] = [[0, 48], [0.5, supply]]
    scenario = parse_document(scenario_mapping | changes, Scenario, "here")
    again = parse_document(json.loads(scenario.to_json()), Scenario, "there")
    assert again == scenario
    assert hash(again) == hash(scenario)
    assert again.to_json() == scenario.to_json(), "equal scenarios were written differently"
