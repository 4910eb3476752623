"""A motor inside another document: a whole one, or just the name or the file of one."""

from typing import Annotated, Any

from pydantic import BeforeValidator, ValidationInfo

from drivegate_cases.motor.motor import Motor, load_motor
from drivegate_models.errors import InputError


def _motor_by_name(value: Any, info: ValidationInfo) -> Any:
    """Take a motor from the package or a file where a document only names it."""
    if not isinstance(value, str):
        return value
    try:
        return load_motor(value, beside=(info.context or {}).get("folder"))
    except InputError as error:
        raise ValueError(str(error)) from error


MotorReference = Annotated[Motor, BeforeValidator(_motor_by_name)]
"""A table of a motor's keys, the bare name of a motor, or the path of its file."""
