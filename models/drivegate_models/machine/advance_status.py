"""Status of a plant's advance, for every kind of drive."""

from __future__ import annotations

from typing import Final

COMPLETED: Final = 0
"""The advance reached its end."""
TOO_MANY_EVENTS: Final = 1
"""The phases switched more often than the plant's limit allows. This is a fault of the harness, not of a candidate."""
