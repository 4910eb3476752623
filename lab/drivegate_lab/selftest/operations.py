"""The kinds of operation that are rarely tried: the fixed runs of each, and the faulty controllers that prove them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from drivegate.contracts.current.scenarios.rare import RARE as RARE_OF_CURRENT
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.beyond import backward_beyond_scenarios, beyond_scenarios
from drivegate.contracts.duty.scenarios.fixed import turned_scenario
from drivegate.contracts.duty.scenarios.rare import RARE, RARE_BACKWARD, RareRuns
from drivegate.contracts.duty.scenarios.released import free_shaft_scenarios
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS
from drivegate_lab.candidates.faults.catalogue import MUTATIONS
from drivegate_lab.candidates.faults.seeded_fault import SeededFault
from drivegate_lab.candidates.field_faults import FIELD_FAULTS

_PROOFS_OF_CURRENT: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "clocks": ("milliseconds-overflow", "timer-always-due"),
        "short control period": (
            "integral-of-eight-bits",
            "step-count-in-a-byte",
            "period-taken-for-1-millisecond",
        ),
        "minutes": ("milliseconds-overflow", "derates-after-a-minute", "derating-chatters"),
        "lost samples again and again": ("lost-current-trips", "lost-speeds-add-up"),
        "supply above its nominal voltage": ("swell-trips",),
        "standstill": ("standstill-latches",),
    }
)

_FURTHER: Final[Mapping[str, tuple[RareRuns, tuple[str, ...]]]] = MappingProxyType(
    {
        "beyond the highest speed": (
            lambda drive: [*beyond_scenarios(drive), *backward_beyond_scenarios(drive)],
            ("braking-ends-at-highest-speed", "overspeed-taken-early", "lowering-refused"),
        ),
        "shafts that come free": (
            free_shaft_scenarios,
            ("speed-taken-for-constant", "torque-ramped-after-stall"),
        ),
        "many turns before the run": (
            lambda drive: [turned_scenario(drive)],
            ("turns-summed-in-single-precision", "edges-summed-in-single-precision"),
        ),
    }
)
"""Kinds of duty ratios that other families have too, with names of faulty controllers."""


@dataclass(frozen=True)
class Operation:
    """One kind of operation on a drive."""

    kind: str
    runs: tuple[Scenario, ...]
    """Its fixed runs."""
    faults: tuple[SeededFault, ...]
    """The faulty controllers that one of these runs shows."""


def operations(drive: DriveDocument) -> tuple[Operation, ...]:
    """List the kinds of operation of a drive's contract."""
    if drive.contract == "duty":
        document = duty_document(drive)
        rare = (
            Operation(
                kind,
                tuple(runs(document)),
                tuple(fault for fault in FIELD_FAULTS.values() if fault.kind == kind),
            )
            for kind, runs in {**RARE, **RARE_BACKWARD}.items()
        )
        further = (
            Operation(kind, tuple(runs(document)), tuple(DUTY_FAULTS[name] for name in names))
            for kind, (runs, names) in _FURTHER.items()
        )
        return (*rare, *further)
    return tuple(
        Operation(kind, tuple(runs(drive)), tuple(MUTATIONS[name] for name in _PROOFS_OF_CURRENT[kind]))
        for kind, runs in RARE_OF_CURRENT.items()
    )


def proofs(drive: DriveDocument) -> tuple[str, ...]:
    """Return the names of the faulty controllers of all kinds."""
    return tuple(dict.fromkeys(fault.name for each in operations(drive) for fault in each.faults))
