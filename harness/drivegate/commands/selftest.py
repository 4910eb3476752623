"""``drivegate selftest``: the checks checked, on controllers with known faults and on correct ones."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from drivegate.commands.conduct import ExitCode, Outcome
from drivegate.commands.options import json_option

if TYPE_CHECKING:
    from drivegate.candidates.builtin.faults import Mutation
    from drivegate.studies.selftest.matrix import DesignRow, FaultRow
    from drivegate.studies.selftest.run import SelftestEffort

ALL_SEEDS = 1000


@click.command("selftest")
@click.option(
    "--fault",
    "faults",
    metavar="NAME",
    multiple=True,
    help="Only this faulty controller, and no correct designs; may be given again.",
)
@click.option(
    "--seeds",
    type=click.IntRange(1, ALL_SEEDS),
    default=1,
    show_default=True,
    help="Number of seeds of the search, from 0 on.",
)
@click.option(
    "--effort",
    type=click.Choice(["quick", "default", "nightly"]),
    default="default",
    show_default=True,
    help="Number of scenarios that are drawn.",
)
@click.option(
    "--search/--no-search",
    default=True,
    show_default=True,
    help="Climb toward small margins, or draw scenarios at random.",
)
@click.option(
    "--drawn-only",
    is_flag=True,
    help="Leave the fixed scenarios out, and the correct designs: what would drawing alone have caught?",
)
@click.option(
    "--workers", type=click.IntRange(1, 1024), help="Processes; by default as many as there are processors."
)
@json_option
def command(
    faults: tuple[str, ...], seeds: int, effort: str, search: bool, drawn_only: bool, workers: int | None
) -> Outcome:
    """Check the checks: faulty controllers must be caught, correct designs must pass.

    Each faulty controller has one known fault, and one check that is named for it; any of them is also a
    candidate of its own, as faulty:NAME. The exit code is 1 when a check misses its fault or a correct design
    is accused.
    """
    mutations = _chosen(faults)

    from drivegate.checks.catalogue import CHECKS
    from drivegate.studies.selftest.display import show_matrix
    from drivegate.studies.selftest.matrix import Matrix
    from drivegate.studies.selftest.run import SelftestEffort

    amount = SelftestEffort(effort, seeds, workers, search, drawn_only)
    rows = _tried(mutations, amount)
    designs = () if faults or drawn_only else _judged(amount)
    matrix = Matrix(tuple(check.id for check in CHECKS), rows, designs)
    code = ExitCode.PASSED if matrix.passed else ExitCode.FAILED
    return Outcome(matrix.document(), lambda console: show_matrix(console, matrix), code)


def _chosen(names: Sequence[str]) -> tuple[Mutation, ...]:
    from drivegate.candidates.builtin.faults import MUTATIONS, find_mutation
    from drivegate.candidates.kinds import FAULTY_PREFIX

    if not names:
        return tuple(MUTATIONS.values())
    return tuple(find_mutation(name.removeprefix(FAULTY_PREFIX)) for name in dict.fromkeys(names))


def _tried(mutations: Sequence[Mutation], effort: SelftestEffort) -> tuple[FaultRow, ...]:
    from drivegate.studies.selftest.run import try_faults
    from drivegate.studies.selftest.trial_progress import trial_progress_on

    rows = []
    with trial_progress_on(sys.stderr, len(mutations)) as tell:
        for row in try_faults(mutations, effort):
            tell(row)
            rows.append(row)
    return tuple(rows)


def _judged(effort: SelftestEffort) -> tuple[DesignRow, ...]:
    from drivegate.output.progress import progress_on
    from drivegate.output.subscription import publish
    from drivegate.studies.selftest.correct_designs import correct_designs
    from drivegate.studies.selftest.run import design_check, judged_design

    rows = []
    for design in correct_designs():
        for seed in range(effort.seeds):
            with progress_on(sys.stderr) as progress:
                result = publish(design_check(design, seed, effort), (progress,))
            rows.append(judged_design(design, result))
    return tuple(rows)
