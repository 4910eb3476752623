"""The controllers of the laboratory as candidates: what the entry points of their prefixes name."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES, DUTY_CANDIDATES
from drivegate.candidates.builtin.prefixed import PrefixedControllers
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.kinds import DESIGN_PREFIX, NEAR_PREFIX
from drivegate_cases.documents.wording import nearest, one_line
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.contract import ContractName
    from drivegate.candidates.controller import Controller

DESIGN_NAMES: Final = ("golden-section", "quadratic-interpolation", "angle-table", "sweep")
"""Names of the correct designs, without their prefix."""
SENSORLESS_DESIGN_NAMES: Final = ("start-by-observer", "slower-observer")
"""Names of those for drives without a position sensor."""


class FaultyControllers(PrefixedControllers):
    """Controllers with one known fault each; they declare what the controller does that they are a variation of."""

    def contract(self, name: str) -> ContractName:
        """Return the contract of a faulty controller."""
        from drivegate_lab.candidates.duty_faults import DUTY_FAULTS
        from drivegate_lab.candidates.field_faults import FIELD_FAULTS
        from drivegate_lab.candidates.sensorless_faults import SENSORLESS_FAULTS

        of_duty = name in DUTY_FAULTS or name in FIELD_FAULTS or name in SENSORLESS_FAULTS
        return "duty" if of_duty else "current"

    def declaration(self, name: str) -> Declaration:
        """Return what the correct controller declares."""
        if self.contract(name) == "duty":
            from drivegate_lab.candidates.sensorless_faults import SENSORLESS_FAULTS

            return DUTY_CANDIDATES["foc-sensorless" if name in SENSORLESS_FAULTS else "foc"]
        from drivegate_lab.candidates.faults.catalogue import MUTATIONS, find_fault

        return BUILTIN_CANDIDATES[find_fault(name, MUTATIONS).base]

    def load_controller(self, name: str) -> Controller:
        """Make a new instance of a faulty controller."""
        if self.contract(name) == "duty":
            from drivegate_lab.candidates.faulty_duty_controller import load_faulty_duty_controller

            return load_faulty_duty_controller(name)
        from drivegate_lab.candidates.faulty_controller import load_faulty_controller

        return load_faulty_controller(name)


class NearDesigns(PrefixedControllers):
    """Correct controllers that are near a limit."""

    def contract(self, name: str) -> ContractName:  # noqa: ARG002  (the interface of all families)
        """Return the one contract that has any."""
        return "current"

    def declaration(self, name: str) -> Declaration:
        """Return what the controller declares that a design is a variation of."""
        from drivegate_lab.candidates.faults.tolerances import NEAR_DESIGNS

        return BUILTIN_CANDIDATES[NEAR_DESIGNS[_known(NEAR_PREFIX, name, NEAR_DESIGNS)].base]

    def load_controller(self, name: str) -> Controller:
        """Make a new instance of a design near a limit."""
        from drivegate_lab.candidates.faulty_controller import load_near_design

        return load_near_design(name)


class CorrectDesigns(PrefixedControllers):
    """Correct controllers of other designs than the reference controller, and than `foc-sensorless`."""

    def contract(self, name: str) -> ContractName:
        """Return the contract of a design."""
        return "duty" if name in SENSORLESS_DESIGN_NAMES else "current"

    def declaration(self, name: str) -> Declaration:
        """Return what a design declares."""
        _known(DESIGN_PREFIX, name, (*DESIGN_NAMES, *SENSORLESS_DESIGN_NAMES))
        if self.contract(name) == "duty":
            return DUTY_CANDIDATES["foc-sensorless"]
        return Declaration(estimates_power=True)

    def load_controller(self, name: str) -> Controller:
        """Make a new instance of a design."""
        if self.contract(name) == "duty":
            from drivegate_lab.candidates.sensorless_controller import SensorlessController
            from drivegate_lab.candidates.sensorless_designs import SENSORLESS_DESIGNS

            return SensorlessController(SENSORLESS_DESIGNS[name])
        from drivegate_lab.candidates.designs import DesignController

        return DesignController(name)


FAULTY: Final = FaultyControllers()
NEAR: Final = NearDesigns()
DESIGN: Final = CorrectDesigns()


def _known(prefix: str, name: str, names: Iterable[str]) -> str:
    known = [f"{prefix}{each}" for each in names]
    if prefix + name in known:
        return name
    raise InputError(
        f"the candidate '{one_line(prefix + name)}' is unknown, the nearest known one is "
        f"'{nearest(prefix + name, known)}'; known are {', '.join(known)}"
    )
