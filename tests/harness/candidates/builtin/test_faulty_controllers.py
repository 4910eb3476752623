"""The faulty controllers: each differs from the controller it is made from, and from nothing else."""

from functools import cache

import pytest

from drivegate.candidates.builtin.faults import MUTATIONS, Mutation
from drivegate.candidates.builtin.faulty_controller import FaultyController
from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.candidates.loading import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.catalogue import CHECKS
from drivegate.drives.running import run_scenario
from drivegate.scenarios.fixed import fixed_scenarios, steady_scenario
from drivegate_cases.motor.motor import load_motor
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError
from drivegate_models.half_bridge.controllers.builtin import SEARCHES
from drivegate_models.half_bridge.controllers.state import CONTROLLER_STATE

KNOWN = {check.id: check for check in CHECKS}
MOTOR = load_motor("paper-5-phase")
SHORT = steady_scenario(MOTOR, 1500.0, power_share=1.0, constant_power=False)
BETWEEN_FIXED_SPEEDS = steady_scenario(MOTOR, 1250.0, power_share=1.0, constant_power=False)
ANSWERS_LIKE_ITS_BASE = {"slow-step", "survives-reset"}


@cache
def scenarios() -> tuple[Scenario, ...]:
    return (BETWEEN_FIXED_SPEEDS, *fixed_scenarios(MOTOR))


@cache
def base_digest(base: str, index: int) -> int:
    return run_scenario(scenarios()[index], BuiltinController(SEARCHES[base])).digest


def differing_scenario(mutation: Mutation) -> str | None:
    controller = FaultyController(mutation)
    for index, scenario in enumerate(scenarios()):
        if run_scenario(scenario, controller).digest != base_digest(mutation.base, index):
            return scenario.name
    return None


@pytest.mark.parametrize("base", ["reference", "published"])
def test_without_a_fault_the_answers_are_those_of_the_base_bit_for_bit(base: str) -> None:
    healthy = Mutation("healthy", "Nothing is wrong with it.", "CNV-1", base)  # type: ignore[arg-type]
    digest = run_scenario(SHORT, FaultyController(healthy)).digest
    assert digest == run_scenario(SHORT, BuiltinController(SEARCHES[base])).digest


@pytest.mark.parametrize("name", sorted(set(MUTATIONS) - ANSWERS_LIKE_ITS_BASE))
def test_each_answers_unlike_its_base_somewhere(name: str) -> None:
    assert differing_scenario(MUTATIONS[name]) is not None, "no scenario shows the fault"


def test_the_slow_one_differs_in_its_time_alone() -> None:
    slow = FaultyController(MUTATIONS["slow-step"])
    brief = SHORT.model_copy(update={"duration_s": 0.5})
    digest = run_scenario(brief, slow).digest
    assert digest == run_scenario(brief, BuiltinController(SEARCHES["reference"])).digest


def test_the_one_that_survives_a_reset_differs_in_its_second_run_alone() -> None:
    controller = FaultyController(MUTATIONS["survives-reset"])
    first, second = (run_scenario(SHORT, controller).digest for _ in range(2))
    assert first == run_scenario(SHORT, BuiltinController(SEARCHES["reference"])).digest
    assert second != first, "the reset forgot everything"


@pytest.mark.parametrize("mutation", MUTATIONS.values(), ids=MUTATIONS)
def test_each_is_reported_in_a_sentence_and_names_a_check_of_candidates(mutation: Mutation) -> None:
    assert mutation.sentence[0].isupper()
    assert mutation.sentence.endswith(".")
    assert mutation.check in KNOWN, f"there is no check '{mutation.check}'"
    check = KNOWN[mutation.check]
    assert check.subject == "candidate"
    declaration = resolve_candidate(f"faulty:{mutation.name}").declaration
    assert check.reason_not_applicable(declaration) is None, "the check does not apply to it"
    assert {name for name, _ in mutation.factors} <= set(CONTROLLER_STATE.names or ())


def test_every_required_check_of_candidates_has_a_fault_to_catch() -> None:
    named = {mutation.check for mutation in MUTATIONS.values()}
    required = {check.id for check in CHECKS if check.level == "required" and check.subject == "candidate"}
    assert required <= named, f"no fault shows that these checks work: {sorted(required - named)}"
    assert len(MUTATIONS) >= 25


def test_a_faulty_controller_is_a_candidate_by_its_name() -> None:
    candidate = resolve_candidate("faulty:slope-doubled")
    assert (candidate.name, candidate.kind) == ("faulty:slope-doubled", "builtin")
    assert candidate.content_hash != resolve_candidate("reference").content_hash
    assert isinstance(load_controller(candidate), FaultyController)


def test_an_unknown_one_is_refused_with_the_nearest() -> None:
    with pytest.raises(
        InputError, match=r"'slope-dubled' is unknown, the nearest known one is 'slope-doubled'"
    ):
        resolve_candidate("faulty:slope-dubled")
