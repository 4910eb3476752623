"""What the self-test came to: which check caught which fault, and which correct design was accused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

from drivegate.studies.selftest.trial import Catch

SELFTEST_SCHEMA: Final = 1
"""Version of the document."""


@dataclass(frozen=True)
class FaultRow:
    """What has become of one faulty controller.

    Attributes
    ----------
    name, sentence, check : str
        As in `drivegate.candidates.builtin.faults.mutation.Mutation`.
    catches : dict
        For each seed the catch, or None where the check missed the fault.
    failing : tuple of str
        Identifiers of all checks that failed where the controller without the fault passes.
    runs : int
        Number of runs made.
    faults : tuple of str
        What the controller did beside the contract.
    unconvincing : int
        Number of failures of the named check where the controller without the fault fails too.
    """

    name: str
    sentence: str
    check: str
    catches: Mapping[int, Catch | None]
    failing: tuple[str, ...]
    runs: int
    faults: tuple[str, ...] = ()
    unconvincing: int = 0

    @property
    def missed_seeds(self) -> tuple[int, ...]:
        """Seeds with which the check missed the fault."""
        return tuple(seed for seed, catch in self.catches.items() if catch is None)

    @property
    def caught(self) -> bool:
        """Whether the named check caught the fault with every seed."""
        return not self.missed_seeds

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
class DesignRow:
    """What has become of one correct design with one seed.

    Attributes
    ----------
    name : str
        The candidate.
    seed : int
        Seed of the search.
    verdict : str
        Verdict on the candidate, or on those checks that it must pass.
    accused_by : dict
        Message of each failed check that it must pass, by identifier.
    acquitted : bool
        Whether it passes everything required of it.
    advised_by : tuple of str
        Identifiers of advisory checks that it fails, which accuse nobody.
    """

    name: str
    seed: int
    verdict: str
    accused_by: Mapping[str, str]
    acquitted: bool
    advised_by: tuple[str, ...] = ()


@dataclass(frozen=True)
class Matrix:
    """The whole self-test.

    Attributes
    ----------
    checks : tuple of str
        Identifiers of all checks.
    faults : tuple of FaultRow
        The faulty controllers.
    designs : tuple of DesignRow
        The correct designs, one row for each seed.
    """

    checks: tuple[str, ...]
    faults: tuple[FaultRow, ...]
    designs: tuple[DesignRow, ...]

    def problems(self) -> list[str]:
        """Tell every miss and every false alarm."""
        return [*self._misses(), *self._false_alarms()]

    @property
    def passed(self) -> bool:
        """Whether every fault was caught and no correct design accused."""
        return not self.problems()

    def _misses(self) -> list[str]:
        return [_miss(row) for row in self.faults if not row.caught]

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
            "checks": list(self.checks),
            "faults": [_fault_document(row) for row in self.faults],
            "designs": _designs_document(self.designs),
        }


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
        "sentence": row.sentence,
        "named_check": row.check,
        "caught": row.caught,
        "runs_to_first": None if slowest is None else slowest.runs,
        "size": None if slowest is None else slowest.size,
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
            "seeds": [
                {
                    "seed": row.seed,
                    "verdict": row.verdict,
                    "acquitted": row.acquitted,
                    "accused_by": dict(row.accused_by),
                    "advised_by": list(row.advised_by),
                }
                for row in rows
                if row.name == name
            ],
        }
        for name in names
    ]
