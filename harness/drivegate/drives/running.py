"""Runs on the kind of drive that a scenario names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from numpy.typing import NDArray

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import CandidateFault
from drivegate.candidates.step_costs import NO_COSTS, StepCosts
from drivegate.checks.check import Record
from drivegate.checks.installed import installed_checks
from drivegate.containment.contained_controller import ContainedController
from drivegate.containment.messages import AnyController, JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.parting import SEED_IN_RESET, Parting, empty_commands, parting_of
from drivegate.drives.kinds import kind_of, require_contract
from drivegate_cases.scenario.scenario import Scenario

_OUTSIDE: Final = (
    f"something outside of the instance is kept, or the answer goes by chance or a clock; {SEED_IN_RESET}"
)


def run_scenario(scenario: Scenario, controller: AnyController, **options: Any) -> Any:
    """Reset a controller and run it through a scenario, with options of its contract's `run`."""
    prepare = kind_of(scenario.drive).prepare_loop()
    return contract_of(scenario.drive).run(prepare, scenario, controller, **options)


def recorded(
    loaded: JudgedCandidate,
    scenario: Scenario,
    controller: AnyController,
    *,
    trace_every: int = 0,
    kept: NDArray[Any] | None = None,
    keeps_steps: bool = False,
) -> Record:
    """Run a candidate through a scenario for the checks, observed as its declaration requires."""
    require_contract(loaded.candidate, scenario.drive)
    declaration = loaded.candidate.declaration
    try:
        record: Record = contract_of(scenario.drive).record(
            kind_of(scenario.drive).prepare_loop(),
            declaration,
            scenario,
            controller,
            trace_every=1 if _needs_all(declaration, scenario) else trace_every,
            kept=kept,
            keeps_steps=keeps_steps,
        )
    except CandidateFault as ended:
        raise CandidateFault(replace(ended.fault, scenario=scenario.to_mapping())) from ended
    costs = taken_costs(controller)
    if isinstance(controller, ContainedController) and controller.remarks:
        record = replace(record, remarks=controller.remarks)
    if costs == NO_COSTS:
        return record
    return replace(record, costs=costs, allowed_costs=loaded.candidate.step_limits)


def _needs_all(declaration: Declaration, scenario: Scenario) -> bool:
    """Return True if rows or installed checks judge a run, which may look at every control period."""
    return declaration.requirements is not None or bool(installed_checks(scenario.drive.contract))


def taken_costs(controller: AnyController) -> StepCosts:
    """Return the greatest costs of a step on an emulated target since they were last taken."""
    return controller.taken_costs() if isinstance(controller, ContainedController) else NO_COSTS


def with_repetitions(
    loaded: JudgedCandidate, record: Record, kept: NDArray[Any], controller: AnyController
) -> Record:
    """Repeat a finished run whose commands were kept, and return where the repetitions part from it."""
    digests, partings = [], []
    # A new instance takes the place of the one before, so it is made after that has run.
    for new in (False, True):
        rows = empty_commands(record.scenario)
        instance = loaded.controller() if new else controller
        digests.append(recorded(loaded, record.scenario, instance, kept=rows).run.digest)
        partings.append(parting_of(record.scenario, rows, kept))
    return replace(record, repeated_digests=tuple(digests), parting=_in_words(partings))


def _in_words(partings: Sequence[Parting | None]) -> str:
    same, new = partings
    if same is None:
        return "" if new is None else f"the run on a new instance {new}; {_OUTSIDE}"
    cause = "reset kept something" if new is None else f"so does that on a new instance: {_OUTSIDE}"
    return f"the second run on the same instance {same}; {cause}"
