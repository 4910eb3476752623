"""What runs of every contract do about a candidate in a process of its own: its commands are played back here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import CandidateFault
from drivegate.containment.contained_controller import ContainedController, PlayedCommands
from drivegate.containment.messages import AnyController
from drivegate.containment.protocol import CloseLoop

Wrap: TypeAlias = Callable[[Controller], Controller]
"""Puts something between the closed loop and a controller, which passes every step on."""


def stepped_here(controller: AnyController, order: CloseLoop, steps: int) -> Controller:
    """Return what a plant here steps: a controller that is included, or the commands of one that is contained."""
    return controller.run(order, steps) if isinstance(controller, ContainedController) else controller


def require_same_plant(controller: Controller, records: Any) -> None:
    """Raise a fault where played commands end in another state of the plant than in the candidate's process."""
    if isinstance(controller, PlayedCommands) and (fault := controller.disturbed(records)) is not None:
        raise CandidateFault(fault)
