"""Which family of drawn scenarios exercises which check."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

EVERY_RUN: Final = ("PWR-1", "DUT-1", "OVC-1")
"""Checks that judge every run of a controller of duty ratios."""
DRAWN: Final[Mapping[str, tuple[str, ...]]] = {
    "torque step": ("ACC-1", "STP-1", "DEC-1", "RIP-4", "DTM-1", "FWK-2", "FWK-3", "MTP-1"),
    "weakening": ("FWK-1", "FWK-2", "FWK-3"),
    "speed step": ("ACC-1", "RIP-4", "FWK-2", "MTP-1"),
    "load step": ("ACC-1", "RIP-4", "FWK-2", "MTP-1"),
    "start": ("STA-1", "ACC-1", "RIP-4", "FWK-2", "MTP-1"),
    "parameter": ("ROB-4",),
    "supply step": ("ACC-1", "FWK-2", "MTP-1"),
    "sensor": ("ROB-5",),
    "failure": ("SAF-1",),
}
"""For each family of drawn scenarios, the checks that it exercises in addition to those of every run."""
