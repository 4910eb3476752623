"""Runs of joint changes, drawn and made inside a worker process."""

from __future__ import annotations

from dataclasses import dataclass

from drivegate.checks.judging import ShardOutcome
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate_cases.drive.drive_document import DriveDocument


@dataclass(frozen=True)
class JointRuns:
    """A part of the runs of joint changes."""

    drive: DriveDocument
    """The drive."""
    seed: int
    """Seed of what the covering array leaves open."""
    part: int
    parts: int
    """Which part of them, from 0, and how many parts there are."""
    only: tuple[str, ...] = ()
    """Checks that are judged; empty for all."""


def run_joint(loaded: JudgedCandidate, plan: JointRuns) -> ShardOutcome:
    """Draw a part of the joint changes and run them as they are."""
    declaration = loaded.candidate.declaration
    scenarios = contract_of(plan.drive).joint_scenarios(
        plan.drive, declaration, plan.seed, plan.part, plan.parts
    )
    return run_fixed(loaded, FixedRuns(scenarios, only=plan.only))
