"""What has become of the faulty controllers, one by one and by kind of fault."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median

from drivegate.studies.selftest.trial import Catch


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
    counted = [_counted(kind, [row for row in rows if row.kind == kind]) for kind in kinds]
    return [*counted, _counted("all", rows)] if len(counted) > 1 else counted


def _counted(kind: str, rows: Sequence[FaultRow]) -> KindRow:
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
