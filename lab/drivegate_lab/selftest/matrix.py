"""The result of the self-test: which check caught which fault, and which correct design was accused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any, Final

from drivegate_lab.selftest.trial import Catch

NEAR: Final = 0.1
"""Least margin of a correct design below which it is looked into, unless it is near by design."""

SELFTEST_SCHEMA: Final = 1
"""Version of the document."""


@dataclass(frozen=True)
class FaultRow:
    """What has become of one faulty controller."""

    name: str
    kind: str
    sentence: str
    check: str
    """As in `SeededFault` and `FaultOnDrive`."""
    catches: Mapping[int, Catch | None]
    """For each seed the catch, or None where the check missed the fault."""
    failing: tuple[str, ...]
    """Identifiers of all checks that failed where the controller without the fault passes."""
    runs: int
    """Number of runs made."""
    faults: tuple[str, ...] = ()
    """What the controller did beside the contract."""
    unconvincing: int = 0
    """Number of failures of the named check where the controller without the fault fails too."""
    shown_by: str = ""
    """What a scenario must have to show the fault; empty where loaded steady runs do."""
    idle_because: str | None = None
    """Why the fault does nothing on the drive, and was not tried; None for one that was."""

    @property
    def applies(self) -> bool:
        """Whether the fault does something on the drive."""
        return self.idle_because is None

    @property
    def missed_seeds(self) -> tuple[int, ...]:
        """Seeds with which the check missed the fault."""
        return tuple(seed for seed, catch in self.catches.items() if catch is None)

    @property
    def caught(self) -> bool:
        """Whether the named check caught the fault with every seed."""
        return self.applies and not self.missed_seeds

    @property
    def slowest(self) -> Catch | None:
        """The catch that took the most runs; None where a seed missed the fault."""
        catches = [catch for catch in self.catches.values() if catch is not None]
        return max(catches, key=lambda catch: catch.runs) if self.caught else None

    @property
    def also_failing(self) -> tuple[str, ...]:
        """Identifiers of the other checks that failed."""
        return tuple(check for check in self.failing if check != self.check)


@dataclass(frozen=True)
class KindRow:
    """How well the faults of one kind are detected."""

    kind: str
    """The kind."""
    faults: int
    caught: int
    """Number of its faults that do something on the drive, and of those that their checks caught with every
    seed."""
    runs_median: float | None
    runs_greatest: int | None
    """Runs to the first counterexample, of those caught with their slowest seed; None where none was."""
    facts_median: float | None
    facts_greatest: int | None
    """Facts of the counterexamples when made simpler."""


def detection_by_kind(rows: Sequence[FaultRow]) -> list[KindRow]:
    """Count what was caught, by kind of fault, with all of them at the end."""
    kinds = dict.fromkeys(row.kind for row in rows)
    counted = [_kind_row(kind, [row for row in rows if row.kind == kind]) for kind in kinds]
    return [*counted, _kind_row("all", rows)] if len(counted) > 1 else counted


def _kind_row(kind: str, rows: Sequence[FaultRow]) -> KindRow:
    catches = [catch for row in rows if (catch := row.slowest) is not None]
    runs = [catch.runs for catch in catches]
    facts = [len(catch.facts) for catch in catches]
    return KindRow(
        kind=kind,
        faults=sum(row.applies for row in rows),
        caught=len(catches),
        runs_median=median(runs) if runs else None,
        runs_greatest=max(runs, default=None),
        facts_median=median(facts) if facts else None,
        facts_greatest=max(facts, default=None),
    )


@dataclass(frozen=True)
class LeastMargin:
    """How near a controller comes to failing."""

    check: str
    """Identifier of the check."""
    margin: float
    """Its margin."""
    measured: str
    """What was measured there."""


@dataclass(frozen=True)
class DesignRow:
    """What has become of one correct design with one seed."""

    name: str
    """The candidate."""
    seed: int
    """Seed of the search."""
    verdict: str
    """Verdict on the candidate, or on those checks that it must pass."""
    accused_by: Mapping[str, str]
    """Message of each failed check that it must pass, by identifier."""
    acquitted: bool
    """Whether it passes everything required of it."""
    advised_by: tuple[str, ...] = ()
    """Identifiers of advisory checks that it fails, which accuse nobody."""
    near: bool = False
    """Whether it is near a limit by design."""
    least: LeastMargin | None = None
    """The least margin of the required checks; None where none was judged."""


@dataclass(frozen=True)
class InnocentsRow:
    """How many correct controllers of a kind are accused, and how near they come."""

    kind: str
    """Correct designs, or those near a limit by design."""
    designs: int
    accused: int
    """Number of controllers, and of those accused with any seed."""
    least: LeastMargin | None
    """The least margin of them all, over all seeds."""


@dataclass(frozen=True)
class Matrix:
    """The whole self-test."""

    checks: tuple[str, ...]
    """Identifiers of all checks."""
    faults: tuple[FaultRow, ...]
    """The faulty controllers."""
    designs: tuple[DesignRow, ...]
    """The correct designs, one row for each seed."""

    def problems(self) -> list[str]:
        """State every miss and every false alarm."""
        return [*self._misses(), *self._false_alarms()]

    @property
    def passed(self) -> bool:
        """Whether every fault was caught and no correct design accused."""
        return not self.problems()

    def remarks(self) -> list[str]:
        """State which correct designs come near a limit that they are not made for; each is to be looked into."""
        return [
            f"the correct design '{row.name}' meets {row.least.check} by {row.least.margin:.3g} alone with seed "
            f"{row.seed}: {row.least.measured}"
            for row in self.designs
            if row.acquitted and not row.near and row.least is not None and row.least.margin < NEAR
        ]

    def innocents(self) -> list[InnocentsRow]:
        """Count who is accused, among ordinary designs and among those near a limit."""
        kinds = {"correct designs": False, "near a limit by design": True}
        counted = (
            _innocents_row(kind, [row for row in self.designs if row.near is near])
            for kind, near in kinds.items()
        )
        return [row for row in counted if row.designs]

    def _misses(self) -> list[str]:
        return [_miss(row) for row in self.faults if row.applies and not row.caught]

    def _false_alarms(self) -> list[str]:
        return [
            f"the correct design '{row.name}' is accused with seed {row.seed}: {row.verdict}{_accusations(row)}"
            for row in self.designs
            if not row.acquitted
        ]

    def document(self) -> dict[str, Any]:
        """Write the self-test as plain data."""
        return {
            "schema": SELFTEST_SCHEMA,
            "kind": "selftest",
            "passed": self.passed,
            "exit_code": 0 if self.passed else 1,
            "problems": self.problems(),
            "remarks": self.remarks(),
            "kinds": [asdict(row) for row in detection_by_kind(self.faults)],
            "innocents": [asdict(row) for row in self.innocents()],
            "checks": list(self.checks),
            "faults": [_fault_document(row) for row in self.faults],
            "designs": _designs_document(self.designs),
        }


def _innocents_row(kind: str, rows: Sequence[DesignRow]) -> InnocentsRow:
    margins = [row.least for row in rows if row.least is not None]
    return InnocentsRow(
        kind=kind,
        designs=len({row.name for row in rows}),
        accused=len({row.name for row in rows if not row.acquitted}),
        least=min(margins, key=lambda least: least.margin, default=None),
    )


def _accusations(row: DesignRow) -> str:
    return "".join(f"; {check}: {message}" for check, message in row.accused_by.items())


def _miss(row: FaultRow) -> str:
    seeds = ", ".join(map(str, row.missed_seeds))
    outcome = (
        f"it fails {', '.join(row.also_failing)} instead" if row.also_failing else "no other check fails"
    )
    if row.unconvincing:
        outcome += f", and {row.check} only where the controller without the fault fails it too"
    if row.faults:
        outcome += f"; it ended with: {'; '.join(row.faults)}"
    return f"{row.check} misses the fault '{row.name}' with seed {seeds} in {row.runs} runs: {outcome}"


def _fault_document(row: FaultRow) -> dict[str, Any]:
    slowest = row.slowest
    return {
        "name": row.name,
        "kind": row.kind,
        "sentence": row.sentence,
        "shown_by": row.shown_by,
        "named_check": row.check,
        "does_not_apply": row.idle_because,
        "caught": row.caught,
        "runs_to_first": None if slowest is None else slowest.runs,
        "size": None if slowest is None else slowest.size,
        "facts": None if slowest is None else list(slowest.facts),
        "also_failing": list(row.also_failing),
        "runs": row.runs,
        "seeds": [
            {"seed": seed, "caught": catch is not None, **({} if catch is None else asdict(catch))}
            for seed, catch in row.catches.items()
        ],
        "unconvincing": row.unconvincing,
        "faults": list(row.faults),
    }


def _designs_document(rows: Sequence[DesignRow]) -> list[dict[str, Any]]:
    names = dict.fromkeys(row.name for row in rows)
    return [
        {
            "name": name,
            "near_by_design": any(row.near for row in rows if row.name == name),
            "seeds": [
                {
                    "seed": row.seed,
                    "verdict": row.verdict,
                    "acquitted": row.acquitted,
                    "accused_by": dict(row.accused_by),
                    "advised_by": list(row.advised_by),
                    "least_margin": None if row.least is None else asdict(row.least),
                }
                for row in rows
                if row.name == name
            ],
        }
        for name in names
    ]
