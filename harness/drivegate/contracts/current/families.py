"""Which family of drawn scenarios exercises which check."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

EVERY_RUN: Final = ("PWR-1", "PWR-2", "NEU-1", "ADV-2", "CMD-1", "CUR-1")
"""Checks that judge every run in the closed loop."""
DRAWN: Final[Mapping[str, tuple[str, ...]]] = {
    "steady": ("CNV-1", "CNV-2", "RIP-3", "TRQ-1"),
    "constant power": ("CNV-1", "CNV-2", "CPW-1", "RIP-2", "RIP-3", "TRQ-1"),
    "required point": ("CNV-1", "CNV-2", "CNV-3", "RIP-1", "RIP-3", "TRQ-1"),
    "parameter": ("ROB-1",),
    "load step": ("CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "load course": ("CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "sensor": ("ROB-2",),
    "phase": ("ROB-2", "ROB-3"),
    "supply": ("CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "beginning": ("CNV-1", "CNV-2", "RIP-3", "TRQ-1"),
    "fault": ("ROB-3",),
    "restart": ("CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "speed step": ("CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "standstill": ("ADV-1", "CNV-2", "CNV-3", "RIP-3", "TRQ-1"),
    "base speed": ("ADV-1",),
    "overspeed": ("CNV-1", "CNV-2", "CPW-2", "RIP-3", "TRQ-1"),
    "vehicle": ("CNV-2", "CNV-3", "RIP-3"),
}
"""For each family of drawn scenarios, the checks that it exercises in addition to those of every run."""
