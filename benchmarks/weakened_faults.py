"""The weakened faults of both contracts that searches are compared on."""

from __future__ import annotations

from typing import Final

from weakened_current import CURRENT_FAULTS
from weakened_duty import DUTY_FAULTS_WEAKENED

FAULTS: Final = (*CURRENT_FAULTS, *DUTY_FAULTS_WEAKENED)
"""All of them."""
