"""Count the runs until a named check first fails, over the families that drivegate draws from: its search and another.

    python benchmarks/search_on_families.py paper-5-phase --fault NAME --fault NAME:SHARD --seeds 20

The faulty controllers are those of the self-test, without its fixed runs. With the number of a shard, from 1 on, only
that one of a check's shards is run, whose families show the fault. The other search is what Hypothesis does by itself:
draws, and its target phase in the second half of a shard. A failure counts where the controller without the fault
passes. Default effort shows how often a fault is found; nightly effort, with far more runs than most faults need, also
after how many. What is finished is kept in the result file, so that starting again makes what is missing.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from itertools import product
from pathlib import Path
from statistics import fmean
from types import MappingProxyType
from typing import Any, Final, TypeAlias
from unittest import mock

from hypothesis import HealthCheck, Phase, assume, given, seed, settings, target
from hypothesis import strategies as st
from hypothesis.errors import Unsatisfiable

from drivegate.candidates.fault import CandidateFault
from drivegate.candidates.kinds import FAULTY_PREFIX
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import Check, JudgedRun, ShardOutcome, judged
from drivegate.checks.margin import Margin
from drivegate.containment.judge import own_candidate
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.gate import shard
from drivegate.gate.plan import EXAMPLES, shard_seeds
from drivegate.scenarios.choices import Enough
from drivegate.scenarios.isolation import from_the_seed_alone
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.selftest.subjects import FAULTS_OF
from measured_text import SEARCHING, write_measured

HERE: Final = Path(__file__).resolve().parent
RESULT: Final = HERE / "search_on_families.json"
SAMPLE: Final = (
    "blind-spot:3",
    "falling-load-ignored:3",
    "gain-tenfold:4",
    "lost-current-trips:6",
    "standstill-latches:7",
    "swell-trips:5",
    "catches-up-with-the-clock:5",
    "corner-without-limit:4",
    "searches-in-seven-runs:5",
)
"""Faults of `paper-5-phase` that few fixed runs show, or none, each with a shard whose families do."""
_TICKETS: Final = 2**48

Search: TypeAlias = Callable[[JudgedCandidate, shard.DrawnRuns], ShardOutcome]


def climb(loaded: JudgedCandidate, plan: shard.DrawnRuns) -> ShardOutcome:
    """Draw with Hypothesis, and climb toward the least margin of each family of checks in the second half.

    Hypothesis likes to vary what it has drawn, and a variation keeps its ticket: so the first half is held to unrelated
    draws.
    """
    collector = shard._Collector(loaded, plan)
    drawn = contract_of(plan.drive).drawn_scenarios(plan.drive, loaded.candidate.declaration, plan.seed)
    tickets: set[int] = set()
    answers: dict[tuple[int, str], tuple[Margin, ...] | None] = {}
    examples = 0

    def margins(ticket: int, scenario: Scenario) -> tuple[Margin, ...] | None:
        nonlocal examples
        key = (ticket, shard.content_key(scenario.to_mapping()))
        if key not in answers:
            is_varied = ticket in tickets
            tickets.add(ticket)
            is_early = examples < plan.examples // 2
            answers[key] = None if is_varied and is_early else collector.margins(scenario)
        examples += answers[key] is not None
        return answers[key]

    @seed(plan.seed)
    @settings(
        max_examples=plan.examples,
        database=None,
        deadline=None,
        phases=(Phase.generate, Phase.target),
        suppress_health_check=list(HealthCheck),
    )
    @given(st.integers(0, _TICKETS), drawn)
    def explore(ticket: int, scenario: Scenario) -> None:
        found = margins(ticket, scenario)
        if collector.fault is not None:
            raise Enough
        # What shows nothing new does not count as an example.
        assume(found is not None)
        least: dict[str, float] = {}
        for check, margin in shard._scores(found or (), collector.searched).items():
            family = check.partition("-")[0]
            least[family] = min(least.get(family, 1.0), margin)
        for family, margin in least.items():
            target(-max(margin, -1e6), label=family)

    with from_the_seed_alone(), suppress(Enough, Unsatisfiable):
        explore()
    return ShardOutcome(tuple(collector.runs), tuple(collector.infeasible))


SEARCHES: Final[Mapping[str, Search]] = MappingProxyType({"climbing": climb, "shard": shard.run_drawn})
"""The searches that are compared, by their names in the result file."""
_NAMES: Final = ("Hypothesis", "drivegate")
EFFORTS: Final = ("default", "nightly")


class Trial:
    """The runs of one faulty controller until its check fails where the controller without the fault passes.

    `named` is the fault, or the fault and the number of the only shard.
    """

    def __init__(self, drive: DriveDocument, named: str) -> None:
        name, _, only = named.partition(":")
        fault = FAULTS_OF[drive.contract][name]
        self._shards = slice(int(only) - 1, int(only)) if only else slice(None)
        self._drive = drive
        self._check = fault.check_on(drive)
        self._faulty = own_candidate(resolve_candidate(FAULTY_PREFIX + name))
        self._base = own_candidate(resolve_candidate(fault.base))
        self.runs = 0
        self.found = False

    def runs_to_failure(self, search: Search, number: int, effort: str = "default") -> int | None:
        """Search shard after shard; return the number of the first run that shows the fault."""
        self.runs, self.found = 0, False
        for shard_seed in shard_seeds(number)[self._shards]:
            with mock.patch("drivegate.gate.shard.judged", self._watched), suppress(CandidateFault):
                search(self._faulty, shard.DrawnRuns(self._drive, shard_seed, EXAMPLES[effort]))
            if self.found:
                return self.runs
        return None

    def _watched(self, record: Any, checks: Iterable[Check]) -> JudgedRun:
        """Judge a run, and end the search with the first one that shows the fault."""
        outcome = judged(record, checks)
        self.runs += 1
        if self._fails(outcome) and not self._base_fails(outcome.scenario):
            self.found = True
            raise Enough
        return outcome

    def _fails(self, run: JudgedRun) -> bool:
        return any(
            margin.check == self._check and not margin.met and not margin.advisory for margin in run.margins
        )

    def _base_fails(self, scenario: Mapping[str, Any]) -> bool:
        run = parse_document(scenario, Scenario, "the scenario")
        with mock.patch("drivegate.gate.shard.judged", judged):
            return any(map(self._fails, shard.run_fixed(self._base, shard.FixedRuns((run,))).runs))


def allowance(named: str, effort: str = "default") -> int:
    """Return the runs of a trial at most: those of a check, or of a shard."""
    return EXAMPLES[effort] * (1 if ":" in named else len(shard_seeds(0)))


def rows(trials: Mapping[str, int | None], seeds: int) -> Iterator[str]:
    """Write a row of the table for each fault of which all trials are there."""
    means: list[tuple[float, ...]] = []
    for drive, named in dict.fromkeys((key.split("/")[0], key.split("/")[1]) for key in trials):
        of_each = {
            (effort, search): [
                trials.get(f"{drive}/{named}/{effort}/{search}/{number}", 0) for number in range(seeds)
            ]
            for effort, search in product(EFFORTS, SEARCHES)
        }
        if any(0 in runs for runs in of_each.values()):
            continue
        name, _, only = named.partition(":")
        check = FAULTS_OF[load_drive(drive).contract][name].check_on(load_drive(drive))
        found = [
            f"{sum(run is not None for run in of_each[effort, search])} of {seeds}"
            for effort, search in product(EFFORTS, SEARCHES)
        ]
        most = allowance(named, EFFORTS[-1])
        means.append(tuple(fmean(run or most for run in of_each[EFFORTS[-1], search]) for search in SEARCHES))
        figures = " | ".join((*found, *(f"{mean:.0f}" for mean in means[-1])))
        yield f"| `{name}` | `{check}` | {only or 'all'} | {figures} |"
    if means:
        yield f"| *all* | | | | | | | {' | '.join(f'{fmean(column):.0f}' for column in zip(*means, strict=True))} |"


def table(document: Mapping[str, Any], seeds: int) -> str:
    """Write the table, with what it took to make it."""
    lines = [
        f"With {seeds} seeds, in {document['processor_seconds'] / 60.0:.0f} minutes of processor time: faults found "
        + " and ".join(f"in {EXAMPLES[effort]} runs of a shard ({effort} effort)" for effort in EFFORTS)
        + ", by Hypothesis, target, and by drivegate; then the mean of the runs until then, where what was not found "
        "counts with all of them. The aim was two thirds of the other mean.",
        "",
        "| fault | check | shard |"
        + "".join(f" {search}, {EXAMPLES[effort]} |" for effort in EFFORTS for search in _NAMES)
        + "".join(f" {search}, mean |" for search in _NAMES),
        "|---|---|---:|" + 3 * len(_NAMES) * "---:|",
        *rows(document["trials"], seeds),
    ]
    return "\n".join(lines)


def main() -> None:
    """Make the trials that are missing, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("drive")
    parser.add_argument("--fault", action="append", default=[])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--result", type=Path, default=RESULT)
    parser.add_argument("--page", type=Path, default=SEARCHING, help="page whose table is written again")
    options = parser.parse_args()
    document: dict[str, Any] = {"trials": {}, "processor_seconds": 0.0}
    if options.result.exists():
        document = json.loads(options.result.read_text(encoding="utf-8"))
    drive = load_drive(options.drive)
    trials = {fault: Trial(drive, fault) for fault in options.fault or SAMPLE}
    # The first seeds of all faults say more than all seeds of the first.
    for number, (fault, trial), effort, (name, search) in product(
        range(options.seeds), trials.items(), EFFORTS, SEARCHES.items()
    ):
        key = f"{options.drive}/{fault}/{effort}/{name}/{number}"
        if key in document["trials"]:
            continue
        begun = time.process_time()
        document["trials"][key] = trial.runs_to_failure(search, number, effort)
        document["processor_seconds"] += time.process_time() - begun
        write_atomically(options.result, json.dumps(document, indent=1, sort_keys=True) + "\n")
        sys.stdout.write(f"{key}: {document['trials'][key]}\n")
        sys.stdout.flush()
    write_measured(options.page, "search on families", table(document, options.seeds))


if __name__ == "__main__":
    main()
