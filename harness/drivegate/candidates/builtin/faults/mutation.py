"""A faulty controller: a built-in one with one known fault, and the check that must catch it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from drivegate_models.half_bridge.faults import state as faults


@dataclass(frozen=True)
class Mutation:
    """One faulty controller.

    Attributes
    ----------
    name : str
        Its name; as a candidate it is named ``faulty:`` and this.
    kind : str
        What kind of fault it is; the self-test counts by kind.
    sentence : str
        What is wrong with it.
    check : str
        Identifier of the check that must catch it; empty for a controller that is right.
    base : {"reference", "published"}
        The built-in controller that it is made from.
    factors : tuple of (str, float)
        Constants of `CONTROLLER_STATE` that are multiplied after every reset.
    believes : tuple of (str, float)
        Keys of the nameplate that it takes for a constant, with that constant.
    fault : int
        What its steps do wrong, from `drivegate_models.half_bridge.faults.state`.
    size : float
        How large the fault is, in the units that the fault has.
    keeps : tuple of str
        What a reset leaves in `CONTROLLER_STATE`, or of the fault's own memory in `FAULTY_STATE`.
    shares : bool
        Whether a new instance begins with what the last one has left of `keeps`.
    shown_by : str
        What a scenario must have to show the fault; empty where loaded steady runs do.
    """

    name: str
    kind: str
    sentence: str
    check: str
    base: Literal["reference", "published"] = "reference"
    factors: tuple[tuple[str, float], ...] = ()
    believes: tuple[tuple[str, float], ...] = ()
    fault: int = faults.NO_FAULT
    size: float = 0.0
    keeps: tuple[str, ...] = ()
    shares: bool = False
    shown_by: str = ""
