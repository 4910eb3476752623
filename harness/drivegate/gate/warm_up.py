"""Compiling the kernels once, before a candidate's workers start, so that none of them compiles beside another."""

from __future__ import annotations

from itertools import product
from pathlib import Path

from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES
from drivegate.candidates.fault import Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.judging import judged
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.pool import WorkerPool
from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.drives.running import recorded
from drivegate.runs.record import rated_torque
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.compilation.kernels import choose_cache_folder
from drivegate_models.errors import HarnessFault
from drivegate_models.units import RADIANS_PER_RPM

MARKER = "all-kernels"
"""Name of the file in the cache folder that tells that every kernel has been compiled."""


def missing_marker() -> Path | None:
    """Tell whether the kernels are still to be compiled."""
    folder = choose_cache_folder()
    if folder is None:
        return None
    marker = folder / MARKER
    return None if marker.exists() else marker


def compile_kernels(marker: Path) -> None:
    """Compile every kernel in processes of their own, and note that it is done.

    The oracle is compiled beside all else. What both need comes early in the one and late in the other, which finds it
    compiled by then: the phase in the oracle, the whole steady state in what is beside it.
    """
    candidate = resolve_candidate(next(iter(BUILTIN_CANDIDATES)))
    with WorkerPool(candidate, workers=2) as pool:
        rounds = ((_use_oracle, _use_closed_loop, _use_steady_state), (_judge_a_run,))
        for kind, targets in product(DRIVE_KINDS, rounds):
            for outcome in pool.map([Job(target, kind) for target in targets]):
                if isinstance(outcome, Fault):
                    raise HarnessFault(f"the kernels cannot be compiled: {outcome.message}")
    marker.touch()


def _use_oracle(_loaded: JudgedCandidate, kind: str) -> None:
    drive_kind, scenario = DRIVE_KINDS[kind], _plain_scenario(kind)
    drive_kind.unfair_because(scenario)
    oracle, drive = drive_kind.oracle(), scenario.drive.plant()
    speed = scenario.speed_rpm[0][1] * RADIANS_PER_RPM
    torque = rated_torque(scenario, speed)
    optimum = oracle.least_current_sum(drive, speed, torque)
    oracle.point_at_torque(drive, speed, optimum.advance, torque)


def _use_closed_loop(loaded: JudgedCandidate, kind: str) -> None:
    recorded(loaded, _plain_scenario(kind), loaded.controller())


def _use_steady_state(_loaded: JudgedCandidate, kind: str) -> None:
    drive = _plain_scenario(kind).drive.plant()
    DRIVE_KINDS[kind].steady_state()(drive, 100.0, 10.0, 0.5)


def _judge_a_run(loaded: JudgedCandidate, kind: str) -> None:
    judged(recorded(loaded, _plain_scenario(kind), loaded.controller()), DRIVE_KINDS[kind].checks())


def _plain_scenario(kind: str) -> Scenario:
    drive_kind = DRIVE_KINDS[kind]
    return drive_kind.fixed_scenarios(load_drive(drive_kind.default_drive), None)[1]
