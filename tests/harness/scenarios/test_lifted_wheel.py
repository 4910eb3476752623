"""A driven wheel that is lifted from the ground and set down: the inertia changes during a run."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.current.scenarios.building import plain_scenario
from drivegate.contracts.current.scenarios.simplification import SIMPLIFICATIONS
from drivegate.drives.running import recorded, run_scenario
from drivegate.scenarios.facts import facts_of
from drivegate.scenarios.simplification import simplified
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.courses import COURSES
from drivegate_cases.scenario.profile import dwells
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

DRIVES = ("paper-5-phase", "star-3-phase", "pm-ac-interior")


def lifted(name: str) -> Scenario:
    drive = load_drive(name)
    declaration = resolve_candidate(contract_of(drive).usual_candidate).declaration
    (run,) = (
        run
        for run in contract_of(drive).fixed_scenarios(drive, declaration)
        if run.drift is not None and run.drift.inertia is not None
    )
    return run


def shaft(scenario: Scenario) -> dict[str, NDArray[np.float64]]:
    """Return time (s), speed (rad/s), torque and load (N m) of each control period."""
    loaded = own_candidate(resolve_candidate(contract_of(scenario.drive).usual_candidate))
    if scenario.drive.kind == "pm-ac":
        run = recorded(loaded, scenario, loaded.controller()).run
        return {name: run.column(name) for name in ("time", "speed", "torque", "load")}
    run = run_scenario(scenario, loaded.controller(), trace_every=1)
    names = {"time": "time_s", "torque": "torque_nm", "load": "load_torque_nm"}
    return {key: run.trace[name] for key, name in names.items()} | {
        "speed": run.trace["speed_rpm"] * RADIANS_PER_RPM
    }


@pytest.mark.parametrize("name", DRIVES)
def test_the_shaft_gains_speed_by_the_inertia_that_it_has_at_that_time(name: str) -> None:
    scenario = lifted(name)
    trace, plant = shaft(scenario), scenario.drive.plant(scenario.scales)
    driving = trace["torque"] - trace["load"] - plant.friction - plant.viscous_friction * trace["speed"]
    times, factors = np.array(COURSES["inertia"].profile(scenario)).T
    inertia = plant.inertia * np.interp(trace["time"], times, factors)
    expected = (driving * scenario.control_period_s / inertia)[:-1]
    gained = np.diff(trace["speed"])
    is_lifted = (trace["time"] > times[1])[:-1] & (trace["time"] < times[3])[:-1]
    assert min(np.abs(gained[is_lifted]).max(), np.abs(gained[~is_lifted]).max()) > 0.0
    for stretch in (is_lifted, ~is_lifted):
        # The drag of the core loss, and what friction changes within a period, are not in the trace.
        missing = np.abs(gained - expected)[stretch].max() / np.abs(gained[stretch]).max()
        assert missing < 0.03, f"the speed changes by {missing:.2%} more or less than torque over inertia"


@pytest.mark.parametrize("name", DRIVES)
def test_it_is_a_stretch_of_its_own_and_is_reported(name: str) -> None:
    scenario = lifted(name)
    factor = min(value for _, value in COURSES["inertia"].profile(scenario))
    own = scenario.scales.inertia
    assert {dwell.scales.inertia for dwell in dwells(scenario)} == {own, own * factor}
    facts = facts_of(scenario.to_mapping())
    assert any(fact.startswith(f"J changes by 1 → {factor:g} → 1 times at ") for fact in facts), facts


def test_a_moment_that_rounding_would_take_away_is_no_simpler_scenario() -> None:
    moment = ((0.0, 1.0), (9.1, 1.0), (9.1, 0.3), (9.4, 0.3), (9.4, 1.0))
    run = plain_scenario(load_drive("paper-5-phase")).replaced(duration_s=20.0, drift={"inertia": moment})
    fields = (fields for simplification in SIMPLIFICATIONS for fields in simplification(run))
    simpler = [found.drift for changed in fields if (found := simplified(run, changed)) is not None]
    left = {drift.inertia for drift in simpler if drift is not None}
    assert None in simpler
    assert moment in left


@pytest.mark.parametrize(
    ("inertia", "sentence"),
    [
        ([[0.0, 1.0], [1.0, 0.0]], r"the key 'drift.inertia' is .*, but must have factors from 0.1 to 10"),
        ([[0.0, 1.0], [1e4, 2.0]], "the key 'drift.inertia' has a point at 10000.0 s, but must end within"),
        ([[0.5, 1.0]], r"the key 'drift.inertia' is .*, but must have its first point at time 0"),
    ],
)
def test_a_course_that_cannot_be_is_refused_in_a_sentence(inertia: list[list[float]], sentence: str) -> None:
    given = lifted("paper-5-phase").to_mapping() | {"drift": {"inertia": inertia}}
    with pytest.raises(InputError, match=sentence):
        parse_document(given, Scenario, "lifted.toml")


def test_a_drift_of_nothing_names_what_could_be_given() -> None:
    given = lifted("paper-5-phase").to_mapping() | {"drift": {}}
    with pytest.raises(
        InputError, match="must give 'resistance', 'emf_constant', 'inertia' or 'friction_n_m'"
    ):
        parse_document(given, Scenario, "lifted.toml")
