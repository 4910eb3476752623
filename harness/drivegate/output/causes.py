"""What failed checks have in common: one cause that shows in the runs of several of them, told once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from drivegate.output.account import lost_at, passes_edge
from drivegate.output.run_signals import RunSignals, signals_of

FEWEST_CHECKS: Final = 2
"""Failed checks from which on something counts as their common cause."""
_TO_BE_MET: Final = ("fail", "waiver expired")
_STANDING: Final = 0.02


@dataclass(frozen=True)
class Cause:
    """What the counterexamples of several checks show.

    Attributes
    ----------
    words : str
        What it is, in one clause.
    checks : tuple of str
        The failed checks whose counterexample shows it, in the order of the catalogue.
    """

    words: str
    checks: tuple[str, ...]

    def __str__(self) -> str:
        """Tell the cause and its checks in one line."""
        return f"{self.words}: in the counterexamples of {', '.join(self.checks)}"


def causes_of(document: Mapping[str, Any]) -> tuple[Cause, ...]:
    """Group the failed checks of a result by what their runs show, the largest group first."""
    groups: dict[str, list[str]] = {}
    for check in document["checks"]:
        signals = None if check["counterexample"] is None else signals_of(document, check)
        words = None if signals is None else _loss(signals)
        if words is not None:
            groups.setdefault(words, []).append(str(check["id"]))
    causes = [Cause(words, tuple(checks)) for words, checks in groups.items() if len(checks) >= FEWEST_CHECKS]
    return tuple(sorted(causes, key=lambda cause: -len(cause.checks)))


def first_to_mend(document: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Choose the failed required check to begin with: of a fault, of the largest cause, else the first one."""
    failed = [
        check
        for check in document["checks"]
        if check["counterexample"] is not None
        and check["level"] == "required"
        and check["verdict"] in _TO_BE_MET
    ]
    unsteady = [check for check in failed if check["id"] == "DET-1"]
    explained = [name for cause in causes_of(document) for name in cause.checks]
    common = [check for name in explained for check in failed if check["id"] == name]
    return next(iter([*unsteady, *common, *failed]), None)


def by_urgency(checks: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Order checks for reading: what fails first, what is met or does not apply last."""
    return sorted(checks, key=_urgency)


def _urgency(check: Mapping[str, Any]) -> int:
    if check["verdict"] in ("pass", "not applicable"):
        return 3
    if check["verdict"] in ("waived", "inconclusive"):
        return 2
    return 0 if check["level"] == "required" else 1


def _loss(signals: RunSignals) -> str | None:
    """Tell how the speed was lost; None where it was held."""
    if lost_at(signals) is None:
        return None
    if abs(signals.speed_rpm[-1]) < _STANDING * float(np.max(np.abs(signals.speed_reference_rpm))):
        return "the motor stalls"
    if passes_edge(signals):
        return "the search takes the angle past the feasible edge, and the speed is lost"
    limit = signals.scenario.drive.rating.current_limit_a
    if signals.speed_error_rpm[-1] < 0.0 and signals.current_reference_a[-1] > 0.999 * limit:
        return f"the speed is lost with the current reference at its limit of {limit:g} A"
    return "the speed leaves its band and stays away"
