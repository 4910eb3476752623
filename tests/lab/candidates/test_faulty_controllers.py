"""The faulty controllers: each differs from the controller it is made from, and from nothing else."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.margin import Margin
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.building import base_speed_scenario, coming_on
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios, steady_scenario
from drivegate.contracts.current.scenarios.rare import RARE
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import (
    pulsed,
    stepped,
    with_dropout,
    with_load_factor,
    with_speed,
    with_supply,
)
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.candidates.faults.catalogue import MUTATIONS
from drivegate_lab.candidates.faults.mutation import Mutation
from drivegate_lab.candidates.faults.tolerances import NEAR_DESIGNS
from drivegate_lab.candidates.faulty_controller import FaultyController
from drivegate_lab.kernels.faults.current.clocks import alter_search_by_counters
from drivegate_lab.kernels.faults.current.state import FAULTY_STATE
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.controllers.current.builtin import SEARCHES
from drivegate_models.controllers.current.state import CONTROLLER_STATE
from drivegate_models.errors import InputError

KNOWN = {check.id: check for check in CHECKS}
DRIVE = load_drive("paper-5-phase")
SHORT = steady_scenario(DRIVE, 1500.0, power_share=1.0, constant_power=False)
# Where the peak EMF is well below the supply, the reference only searches.
SLOWER = steady_scenario(DRIVE, 1000.0, power_share=1.0, constant_power=False)
LIGHT = steady_scenario(DRIVE, 1000.0, power_share=0.35, constant_power=False)
BETWEEN_FIXED_SPEEDS = steady_scenario(DRIVE, 1250.0, power_share=1.0, constant_power=False)
KEEPS_SOMETHING = sorted(
    name for name, mutation in MUTATIONS.items() if mutation.keeps and mutation.check == "DET-1"
)
DIFFERS_LATER = {"slow-step", "searches-in-seven-runs", *KEEPS_SOMETHING}


def long_run() -> Scenario:
    return SLOWER.replaced(duration_s=85.0)


def changed_late() -> Scenario:
    return with_load_factor(long_run(), (*coming_on(DRIVE), (70.0, 1.0), (70.0, 0.6)))


def short_period() -> Scenario:
    return SHORT.replaced(control_period_s=100e-6)


def shortest_period() -> Scenario:
    return SHORT.replaced(control_period_s=50e-6)


def shortest_period_at_part_load() -> Scenario:
    return RARE["short control period"](DRIVE)[-1]


def disturbed_often() -> Scenario:
    """Load steps every four seconds, more than twenty of them."""
    factor = [(0.0, 0.0), (0.2, 0.6)]
    for number in range(1, 23):
        factor += [(4.0 * number, factor[-1][1]), (4.0 * number, 1.0 if number % 2 else 0.6)]
    return SLOWER.replaced(duration_s=98.0, load=SLOWER.load.model_copy(update={"factor": tuple(factor)}))


def speed_lost_often() -> Scenario:
    run = SHORT
    for number in range(6):
        run = with_dropout(run, "speed", 4.0 + 0.5 * number, 0.01)
    return run


def through_standstill() -> Scenario:
    course = ((0.0, 1500.0), (10.0, 1500.0), (12.0, 0.0), (14.0, 0.0), (16.0, 1500.0))
    return SHORT.replaced(duration_s=26.0, speed_rpm=course)


def lightly_loaded() -> Scenario:
    return steady_scenario(DRIVE, 1180.0, power_share=0.1, constant_power=False)


def currents_lost() -> Scenario:
    return with_dropout(SHORT, "currents", 10.0, 0.01)


def swell() -> Scenario:
    return with_supply(SHORT, stepped(1.0, 1.1, 10.0))


def step_beyond() -> Scenario:
    return with_speed(
        steady_scenario(DRIVE, 1900.0, power_share=1.0, constant_power=True), stepped(1600.0, 1900.0, 14.0)
    )


def vanishing() -> Scenario:
    part = steady_scenario(DRIVE, 600.0, power_share=0.5, constant_power=False)
    return with_load_factor(part, (*coming_on(DRIVE), *pulsed(1.0, 0.0, 10.0, 0.5)[1:]))


# What few scenarios have.
SHOWN_BY: dict[str, Callable[[], Scenario]] = {
    "milliseconds-overflow": long_run,
    "timer-always-due": changed_late,
    "integral-of-eight-bits": short_period,
    "power-sum-overflows": short_period,
    "step-count-in-a-byte": short_period,
    "period-taken-for-1-millisecond": shortest_period_at_part_load,
    "heat-counted-in-steps": shortest_period,
    "derates-after-a-minute": long_run,
    "derating-chatters": long_run,
    "twenty-restarts": disturbed_often,
    "lost-speeds-add-up": speed_lost_often,
    "standstill-latches": through_standstill,
    "corner-without-limit": lightly_loaded,
    "reference-ramped-beyond": step_beyond,
    "step-beyond-trips": step_beyond,
    "idling-trips": vanishing,
    "idling-ends-advance": vanishing,
    "lost-current-trips": currents_lost,
    "swell-trips": swell,
}
SHARING = "instances-share-the-integral"
STARTS_LATE = "catches-up-with-the-clock"


# A fault is looked for until a scenario shows it, so those that show one first come first.
SHOWING = (
    BETWEEN_FIXED_SPEEDS.name,
    "550rpm-1500W",
    "600rpm-11.94Nm",
    "300-520-490rpm-unloaded",
    "1500rpm-7.639Nm-48-43.2-48V",
    "700rpm-1500W-L×1.2",
    "900rpm-1500W-100-50%",
    "1500rpm-9.549Nm-50-100%",
    "2000rpm-1500W",
    "800-1100rpm-9.115Nm-100-0-100%-J-changes×1-0.3-1",
    "1500rpm-7.639Nm-speed-lost-10ms",
    "1000rpm-11.46Nm-mcs96-glitch+20",
)


@cache
def scenarios() -> tuple[Scenario, ...]:
    every = (BETWEEN_FIXED_SPEEDS, *fixed_scenarios(DRIVE))
    return tuple(sorted(every, key=lambda scenario: scenario.name not in SHOWING))


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
    healthy = Mutation("healthy", "Nothing is wrong with it.", "CNV-1", base)
    digest = run_scenario(SHORT, FaultyController(healthy)).digest
    assert digest == run_scenario(SHORT, BuiltinController(SEARCHES[base])).digest


@pytest.mark.one_in(16)
@pytest.mark.parametrize("name", sorted(set(MUTATIONS) - DIFFERS_LATER - set(SHOWN_BY) - {STARTS_LATE}))
def test_each_answers_unlike_its_base_somewhere(name: str) -> None:
    assert differing_scenario(MUTATIONS[name]) is not None, "no scenario shows the fault"


def named_margin(candidate: str, check: str, scenario: Scenario) -> Margin:
    found = resolve_candidate(candidate)
    run = run_scenario(scenario, load_controller(found))
    margin = KNOWN[check].evaluate(CurrentRecord(scenario, run, found.declaration))
    assert margin is not None, f"{check} does not judge {scenario.name}"
    return margin


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", SHOWN_BY)
def test_a_rare_one_fails_its_check_where_it_shows_and_its_base_passes(name: str) -> None:
    mutation, scenario = MUTATIONS[name], SHOWN_BY[name]()
    assert mutation.shown_by, "the catalogue does not say what shows it"
    failed = named_margin(f"faulty:{name}", mutation.check, scenario)
    assert not failed.met, failed
    assert not failed.advisory, failed
    passed = named_margin(mutation.base, mutation.check, scenario)
    assert passed.met, passed


@pytest.mark.parametrize(("start", "steps"), [(0.0, 200), (3600.0, 1)])
def test_one_that_catches_up_decides_at_every_step_where_its_clock_starts_later(
    start: float, steps: int
) -> None:
    state = np.zeros(1, FAULTY_STATE)
    state["steps"] = 1
    state["controller"]["decision_steps"] = 200
    state["controller"]["control_period"] = state["controller"]["paced_period"] = 0.0005
    state["sense"]["time"] = start
    alter_search_by_counters(state[0], MUTATIONS[STARTS_LATE].fault)
    assert state["controller"]["decision_steps"][0] == steps


def test_one_that_counts_its_runs_stops_searching_in_the_eighth() -> None:
    controller = FaultyController(MUTATIONS["searches-in-seven-runs"])
    digests = [run_scenario(SHORT, controller).digest for _ in range(8)]
    assert digests[:7] == [run_scenario(SHORT, BuiltinController(SEARCHES["reference"])).digest] * 7
    assert digests[7] != digests[6], "it searches for ever"


def test_the_slow_one_differs_in_its_time_alone() -> None:
    slow = FaultyController(MUTATIONS["slow-step"])
    brief = SHORT.model_copy(update={"duration_s": 0.5})
    digest = run_scenario(brief, slow).digest
    assert digest == run_scenario(brief, BuiltinController(SEARCHES["reference"])).digest


@pytest.mark.parametrize("name", sorted(set(KEEPS_SOMETHING) - {SHARING}))
def test_one_that_survives_a_reset_differs_in_its_second_run(name: str) -> None:
    controller = FaultyController(MUTATIONS[name])
    first, second = (run_scenario(SHORT, controller).digest for _ in range(2))
    assert first == run_scenario(SHORT, FaultyController(MUTATIONS[name])).digest
    assert second != first, "the reset forgot everything"


def test_one_that_shares_its_state_differs_in_a_new_instance() -> None:
    first, second = (run_scenario(SHORT, FaultyController(MUTATIONS[SHARING])).digest for _ in range(2))
    assert second != first, "the new instance knows nothing of the old one"


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", NEAR_DESIGNS)
def test_one_near_a_limit_answers_unlike_the_reference_and_fails_nothing(name: str) -> None:
    candidate = resolve_candidate(f"near:{name}")
    run = run_scenario(SHORT, load_controller(candidate))
    record = CurrentRecord(SHORT, run, candidate.declaration)
    margins = [check.evaluate(record) for check in CHECKS if check.level == "required"]
    failed = [margin for margin in margins if margin is not None and not margin.met and not margin.advisory]
    assert not failed, failed
    reference = BuiltinController(SEARCHES["reference"])
    differs = [
        scenario.name
        for scenario in (SHORT, LIGHT, base_speed_scenario(DRIVE, 480.0, 560.0, 8.0))
        for digest in [run_scenario(scenario, load_controller(candidate)).digest]
        if name.startswith("power") or digest != run_scenario(scenario, reference).digest
    ]
    assert differs, "it is the reference by another name"


@pytest.mark.parametrize("mutation", MUTATIONS.values(), ids=MUTATIONS)
def test_each_is_reported_in_a_sentence_and_names_a_check_of_candidates(mutation: Mutation) -> None:
    assert mutation.sentence[0].isupper()
    assert mutation.sentence.endswith(".")
    assert mutation.check in KNOWN, f"there is no check '{mutation.check}'"
    check = KNOWN[mutation.check]
    assert check.subject == "candidate"
    declaration = resolve_candidate(f"faulty:{mutation.name}").declaration
    assert check.reason_not_applicable(declaration, DRIVE) is None, "the check does not apply to it"
    assert {name for name, _ in mutation.factors} <= set(CONTROLLER_STATE.names or ())
    assert set(mutation.keeps) <= {*(CONTROLLER_STATE.names or ()), *(FAULTY_STATE.names or ())}
    assert {name for name, _ in mutation.believes} <= set(Nameplate._fields)


def test_every_required_check_of_candidates_has_a_fault_to_catch() -> None:
    named = {mutation.check for mutation in MUTATIONS.values()}
    required = {check.id for check in CHECKS if check.level == "required" and check.subject == "candidate"}
    assert required <= named, f"no fault shows that these checks work: {sorted(required - named)}"
    assert len(MUTATIONS) >= 71


@pytest.mark.nightly
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
