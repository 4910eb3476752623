"""A scenario of one's own, written as a file to be edited."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from drivegate.output.new_file import refuse_new_file
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.document import Section
from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.drive_file import toml_value
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.scenario.control_periods import on_whole_periods
from drivegate_cases.scenario.load import ConstantTorqueLoad, DynamometerLoad
from drivegate_cases.scenario.scenario import LONGEST_CONTROL_PERIOD_S, Scenario

_WIDTH: Final = 56
_SETTLED: Final = 1.5
"""Time of each reference over the time to settle (1)."""
_FROM_THE_START: Final = ("name", "description", "drive", "duration_s", "speed_rpm")


def write_scenario(file: Path, drive: DriveDocument, named: str) -> None:
    """Write a scenario of a step on a drive, which the file calls `named`; nothing is ever overwritten."""
    refuse_new_file(file, "a scenario's")
    write_atomically(file, scenario_toml(file.stem, drive, named))


def scenario_toml(name: str, drive: DriveDocument, named: str) -> str:
    """Write a scenario as TOML: a step of torque or load, and every other key as a comment."""
    hold = _short(_SETTLED * limits_of(drive).settling_s)
    period = drive.control_period_s or LONGEST_CONTROL_PERIOD_S
    values: dict[str, Any] = {
        "name": name,
        "description": "What the run shows.",
        "drive": named,
        "duration_s": on_whole_periods(_short(3.0 * hold), period),
    }
    # A drive that may be on a dynamometer gets a torque reference.
    rating, is_held = drive.rating, drive.may_be_held
    values["speed_rpm"] = _short((0.5 if is_held else 1.2) * rating.base_speed_rpm)
    torque = _short(0.5 * rating.rated_torque_nm)
    model: type[Section] = DynamometerLoad if is_held else ConstantTorqueLoad
    load: dict[str, Any] = {"kind": "dynamometer" if is_held else "constant_torque"}
    if is_held:
        steps = [[0.0, 0.0], [hold, torque], [_short(2.0 * hold), _short(0.5 * torque)]]
        load["torque_reference_nm"] = {"steps": steps}
    else:
        load |= {
            "torque_nm": torque,
            "factor": {"steps": [[0.0, 0.0], [hold, 1.0], [_short(2.0 * hold), 0.5]]},
        }
    lines = [
        "# A scenario for drivegate, which is one run. A course over time is a number, a list of [seconds, value], or",
        "# {steps = [[seconds, value from then on], ...]}. Keys that begin with # may stay left out.",
        "schema = 2",
        *(_line(Scenario, key, values[key]) for key in _FROM_THE_START),
        *_others(drive),
        "",
        "[load]",
        *(_line(model, key, value) for key, value in load.items()),
        *(_line(model, key, None) for key in model.model_fields if key not in load),
    ]
    return "\n".join(lines) + "\n"


def _others(drive: DriveDocument) -> Iterator[str]:
    """Write the keys that may be left out, but for those that the drive cannot have."""
    excluded = {"schema_version", "load", *_FROM_THE_START, *drive.excluded}
    excluded |= {"link_voltage_v"} if drive.has_split_supply else {"imbalance", "supply_v"}
    if drive.control_period_s is not None:
        excluded.add("control_period_s")
    for key in Scenario.model_fields:
        if key not in excluded:
            yield _line(Scenario, key, None)


def _short(value: float) -> float:
    return significant(value, 3)


def _line(model: type[Section], key: str, value: Any) -> str:
    description = model.model_fields[key].description
    if value is None:
        return f"# {f'{key} =':<{_WIDTH}}# {description}"
    return f"{f'{key} = {toml_value(value)}':<{_WIDTH}}  # {description}"
