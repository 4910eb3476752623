"""Correct candidates of other designs than the reference, and what they declare of themselves.

The harness tests itself with them: no check may accuse a correct controller, whatever its design.
"""

from types import MappingProxyType
from typing import Final

from drivegate.candidates.declaration import Declaration
from drivegate_cases.documents.wording import nearest, one_line
from drivegate_models.errors import InputError

DESIGN_PREFIX: Final = "design:"
"""What the name of a controller of another design begins with."""

_DESIGNS = ("golden-section", "quadratic-interpolation", "angle-table", "sweep")

DESIGN_CANDIDATES: Final = MappingProxyType(
    {f"{DESIGN_PREFIX}{design}": Declaration(estimates_power=True) for design in _DESIGNS}
)
"""Declarations by the name of the candidate, the prefix included."""


def design_declaration(name: str) -> Declaration:
    """Find what a correct candidate of another design declares of itself."""
    if name in DESIGN_CANDIDATES:
        return DESIGN_CANDIDATES[name]
    raise InputError(
        f"the candidate '{one_line(name)}' is unknown, the nearest known one is "
        f"'{nearest(name, list(DESIGN_CANDIDATES))}'; known are {', '.join(DESIGN_CANDIDATES)}"
    )
