"""Compiling the kernels once, before a candidate's workers start, so that none of them compiles next to another.

`python -m drivegate.gate.warm_up` compiles what a first check on any kind of drive may use, for example in a container
image.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.candidates.fault import Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import own_candidate
from drivegate.containment.machine_memory import usual_workers
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.pool import WorkerPool
from drivegate.containment.templates import Preparation
from drivegate.contracts.catalogue import contract_named
from drivegate.contracts.contract import Contract
from drivegate.drives.envelope_document import envelope_of
from drivegate.drives.kinds import DEFAULT_KIND, DRIVE_KINDS
from drivegate.drives.running import recorded
from drivegate.gate.witness_runs import witnesses_for
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.compilation.kernels import refused_cache_folders, required_cache_folder
from drivegate_models.errors import HarnessFault
from drivegate_models.steady import oracle
from drivegate_models.steady.steady_state import steady_state
from drivegate_models.units import RADIANS_PER_RPM

_log = logging.getLogger("drivegate")

MARKER = "all-kernels"
"""Begin of the names of files in the cache folder, each of which shows that every kernel of a kind is compiled."""
FIRST_CHECK_MARKER = f"{MARKER}-first-check"
"""Name of the file that shows the same of all that a first check on any kind may use."""


def uncompiled_kinds(drives: Iterable[DriveDocument | None] = (None,)) -> tuple[str, ...]:
    """Find the kinds of some drives, the default one's for None, whose kernels are still to be compiled.

    Without a folder for compiled code this is refused: processes that each compile for themselves may differ in the
    last digit, and two plants would part.
    """
    folder = required_cache_folder()
    kinds = dict.fromkeys(DEFAULT_KIND.name if drive is None else drive.kind for drive in drives)
    return tuple(kind for kind in kinds if not (folder / f"{MARKER}-{kind}").exists())


def compile_for_first_check() -> None:
    """Compile the kernels of all kinds of drives, of their envelopes and of their witnesses, unless they are kept."""
    marker = required_cache_folder() / FIRST_CHECK_MARKER
    if marker.exists():
        return
    drives = [load_drive(kind.default_drive) for kind in DRIVE_KINDS.values()]
    compile_missing(drives)
    for drive in drives:
        envelope_of(drive)
        for witness in witnesses_for(drive):
            # One that is made for a scenario is no compiled code.
            if witness.made_for is None:
                loaded = own_candidate(resolve_candidate(witness.candidate))
                recorded(loaded, _plain_scenario(drive.kind), loaded.controller())
    marker.touch()


def compile_missing(drives: Iterable[DriveDocument | None] = (None,)) -> None:
    """Compile the kernels of some drives' kinds, the default one's for None, unless they are kept from before."""
    kinds = uncompiled_kinds(drives)
    if kinds:
        compile_kernels(kinds)


def compile_kernels(kinds: Collection[str], is_ended: Callable[[], bool] = lambda: False) -> None:
    """Compile every kernel of some kinds of drives in processes of their own, and note that it is done.

    The kinds are compiled at the same time: they have little in common. `WorkEnded` is raised once `is_ended` returns
    True.
    """
    for refusal in refused_cache_folders():
        _log.warning("compiled code is stored elsewhere, since %s", refusal)
    with ThreadPoolExecutor() as together:
        # Taking the results raises what has gone wrong.
        list(together.map(partial(_compile_kind, is_ended=is_ended), kinds))
    folder = required_cache_folder()
    for kind in kinds:
        (folder / f"{MARKER}-{kind}").touch()


def judges_on(drive: DriveDocument) -> Preparation:
    return Preparation(__name__, load_kernels.__name__, drive.kind)


def load_kernels(kind: str) -> None:
    """Load the compiled kernels and import the modules that judges of runs on a kind of drive need."""
    candidate = own_candidate(resolve_candidate(_contract(kind).usual_candidate))
    drive = load_drive(DRIVE_KINDS[kind].default_drive)
    _contract(kind).drawn_scenarios(drive, candidate.candidate.declaration, 0)
    for use in (_use_oracle, _judge_a_run):
        use(candidate, kind)


def _compile_kind(kind: str, *, is_ended: Callable[[], bool]) -> None:
    """Compile the parts of a kind at once: what two of them need is compiled by one, and the other waits for it."""
    candidate = resolve_candidate(_contract(kind).usual_candidate)
    rounds = ((_use_oracle, _use_closed_loop, _use_steady_state), (_judge_a_run,))
    with WorkerPool(candidate, workers=min(len(rounds[0]), usual_workers()), is_ended=is_ended) as pool:
        for targets in rounds:
            for outcome in pool.map([Job(target, kind) for target in targets]):
                if isinstance(outcome, Fault):
                    raise HarnessFault(f"the kernels cannot be compiled: {outcome.message}")


def _use_oracle(_loaded: JudgedCandidate, kind: str) -> None:
    scenario = _plain_scenario(kind)
    _contract(kind).unfair_because(scenario)
    if not DRIVE_KINDS[kind].has_angles:
        # Rules and checks use all of the oracle that there is.
        return
    drive = scenario.drive.plant()
    speed = scenario.speed_rpm[0][1] * RADIANS_PER_RPM
    torque = scenario.drive.rating.rated_power_w / speed
    optimum = oracle.least_current_sum(drive, speed, torque)
    oracle.point_at_torque(drive, speed, optimum.advance, torque)


def _use_closed_loop(loaded: JudgedCandidate, kind: str) -> None:
    # At this low a speed no diodes rectify, so the loop need not wait for the kernel that settles their current.
    recorded(loaded, _fixed_scenarios(kind)[0], loaded.controller())


def _use_steady_state(_loaded: JudgedCandidate, kind: str) -> None:
    if not DRIVE_KINDS[kind].has_angles:
        return
    drive = _plain_scenario(kind).drive.plant()
    steady_state(drive, 100.0, 10.0, 0.5)


def _judge_a_run(loaded: JudgedCandidate, kind: str) -> None:
    judged(recorded(loaded, _plain_scenario(kind), loaded.controller()), _contract(kind).checks)


def _plain_scenario(kind: str) -> Scenario:
    return _fixed_scenarios(kind)[1]


def _fixed_scenarios(kind: str) -> tuple[Scenario, ...]:
    drive = load_drive(DRIVE_KINDS[kind].default_drive)
    return _contract(kind).fixed_scenarios(drive, NOTHING_DECLARED)


def _contract(kind: str) -> Contract:
    return contract_named(DRIVE_KINDS[kind].contract)


if __name__ == "__main__":
    # A worker finds the functions of its jobs by the name of their module, which must not be __main__.
    from drivegate.gate import warm_up  # noqa: PLW0406

    warm_up.compile_for_first_check()
