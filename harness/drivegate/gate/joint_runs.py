"""Runs of joint changes, drawn and made inside a worker process."""

from __future__ import annotations

from dataclasses import dataclass

from drivegate.checks.judging import ShardOutcome
from drivegate.containment.messages import JudgedCandidate
from drivegate.drives.kinds import kind_of
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate_cases.motor.motor import load_motor


@dataclass(frozen=True)
class JointRuns:
    """A part of the runs of joint changes.

    Attributes
    ----------
    motor : str
        Name of the motor.
    seed : int
        Seed of what the covering array leaves open.
    part, parts : int
        Which part of them, from 0, and how many parts there are.
    """

    motor: str
    seed: int
    part: int
    parts: int


def run_joint(loaded: JudgedCandidate, plan: JointRuns) -> ShardOutcome:
    """Draw a part of the joint changes and run them as they are."""
    motor = load_motor(plan.motor)
    speeds = loaded.candidate.declaration.speed_range_rpm
    scenarios = kind_of(motor).joint_scenarios(motor, speeds, plan.seed, plan.part, plan.parts)
    return run_fixed(loaded, FixedRuns(scenarios))
