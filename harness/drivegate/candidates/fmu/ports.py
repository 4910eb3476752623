"""The names by which variables of an FMU carry what a controller is given and answers, for each contract."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, get_type_hints

from drivegate.candidates.contract import ContractName
from drivegate_models.contract.current.signals import Nameplate, Sense
from drivegate_models.contract.duty.signals import DutyNameplate, DutySense

DUTY_RATIOS: Final = "duty_ratios"
"""The output, an array or three of them, by which an FMU answers with duty ratios."""
LEGS: Final = 3
"""Values of a variable that has one for each leg."""


@dataclass(frozen=True, kw_only=True)
class Ports:
    """The variables of a controller of one contract."""

    contract: ContractName
    """The contract."""
    fields: tuple[str, ...]
    """Fields of its Sense, in order."""
    inputs: tuple[str, ...]
    more_inputs: tuple[str, ...]
    """Inputs of one value each that a controller must have, and that it may have."""
    input_arrays: tuple[str, ...]
    """Inputs that it may have, of one value for each phase: an array, or one input for each."""
    outputs: tuple[str, ...] = ()
    more_outputs: tuple[str, ...] = ()
    """Outputs that are one value each, likewise."""
    arrays: tuple[str, ...] = ()
    more_arrays: tuple[str, ...] = ()
    """Outputs of one value for each leg, likewise."""
    parameters: Mapping[str, str]
    """Field of the nameplate that each parameter receives."""
    whole: tuple[str, ...]
    """Those of the fields that are whole numbers."""


def _arrays(sense: type) -> tuple[str, ...]:
    """Return the fields of a Sense that have several values."""
    return tuple(name for name, kind in get_type_hints(sense).items() if kind not in (float, int))


def _parameters(fields: tuple[str, ...], renamed: str) -> dict[str, str]:
    """Name each parameter like its field; one has a longer name, for an input has the short one."""
    return {f"nominal_{field}" if field == renamed else field: field for field in fields}


CURRENT: Final = Ports(
    contract="current",
    fields=Sense._fields,
    inputs=("speed_reference", "speed", "current_magnitude_sum", "half_supply_voltage"),
    more_inputs=("time",),
    input_arrays=_arrays(Sense),
    outputs=("current_reference", "advance_angle"),
    more_outputs=("input_power",),
    parameters=_parameters(Nameplate._fields, "half_supply_voltage"),
    whole=("phases", "pole_pairs", "kind"),
)
"""Those of a controller that answers with a current reference and an advance angle."""

DUTY: Final = Ports(
    contract="duty",
    fields=DutySense._fields,
    inputs=("reference",),
    more_inputs=tuple(name for name in DutySense._fields if name not in ("reference", *_arrays(DutySense))),
    input_arrays=_arrays(DutySense),
    # The estimates of angle and speed have the names of inputs.
    more_outputs=("next_period", "torque", "input_power", "fault"),
    arrays=(DUTY_RATIOS,),
    more_arrays=("legs",),
    parameters=_parameters(DutyNameplate._fields, "supply_voltage"),
    whole=("kind", "reference_kind", "pole_pairs", "updates", "update_delay", "control_every"),
)
"""Those of a controller that answers with duty ratios."""

PORTS: Final = {ports.contract: ports for ports in (CURRENT, DUTY)}
"""Those of each contract."""
