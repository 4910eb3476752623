"""What shows angle and speed of a shaft to controllers."""

from typing import Literal, TypeAlias

Position: TypeAlias = Literal["exact", "encoder", "hall"]
"""The plant's own angle without error, an encoder, or three Hall switches."""
