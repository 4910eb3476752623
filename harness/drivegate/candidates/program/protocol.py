"""What the harness and a program send each other: one JSON object a line, each message answered by one.

Floats are written with as many digits as it takes to read back the same 64-bit number.
"""

import json
from collections.abc import Sequence
from typing import Any, Final

from drivegate.candidates.contract import AnyNameplate
from drivegate_cases.documents.wording import nearest, one_line, shown
from drivegate_models.contract.current.signals import Command, Sense
from drivegate_models.contract.duty.signals import DutyCommand, DutySense
from drivegate_models.errors import InputError

PROTOCOL_VERSION: Final = 1
"""Version of the protocol; a program of another one is refused."""
LONGEST_LINE: Final = 65536
"""Bytes of an answer at most, its line end included."""
HELLO: Final = f'{{"drivegate":{PROTOCOL_VERSION},"message":"hello"}}\n'.encode()

_LONGEST_SHOWN = 200
_DUTY_KEYS: Final = tuple(f'"{name}":' for name in DutySense._fields)


class WrongAnswer(Exception):
    """An answer that the protocol does not allow; its text is a sentence."""


def reset_message(nameplate: AnyNameplate) -> bytes:
    return json.dumps({"reset": nameplate._asdict()}, separators=(",", ":")).encode() + b"\n"


def sense_message(sense: Sense) -> bytes:
    """Write the message of one control period; this is done in every step, hence not by `json`."""
    time, speed_reference, speed, currents, magnitude_sum, voltage = sense
    return (
        f'{{"sense":{{"time":{time!r},"speed_reference":{speed_reference!r},"speed":{speed!r},'
        f'"phase_currents":{list(currents)!r},"current_magnitude_sum":{magnitude_sum!r},'
        f'"half_supply_voltage":{voltage!r}}}}}\n'
    ).encode()


def duty_sense_message(sense: DutySense) -> bytes:
    """Write the message of one control period to a controller of duty ratios; what is not known is left out."""
    known = [
        f"{key}{list(value) if type(value) is tuple else value!r}"
        for key, value in zip(_DUTY_KEYS, sense, strict=True)
        # Of three values all are known or none. Tuples of the same NaN are equal.
        if (value[0] == value[0] if type(value) is tuple else value == value)
    ]
    return f'{{"sense":{{{",".join(known)}}}}}\n'.encode()


def check_hello(line: bytes) -> None:
    answer = _object(line, required=("drivegate",), optional=("name",))
    version = answer["drivegate"]
    if type(version) is not int:
        raise WrongAnswer(f"'drivegate' is {shown(version)}, but must be the protocol's version, an integer")
    if version != PROTOCOL_VERSION:
        raise InputError(
            f"the program speaks version {shown(version)} of the protocol, but must speak version {PROTOCOL_VERSION}"
        )
    if "name" in answer and not isinstance(answer["name"], str):
        raise WrongAnswer(f"'name' is {shown(answer['name'])}, but must be a text")


def check_ready(line: bytes) -> None:
    ready = _object(line, required=("ready",))["ready"]
    if ready is not True:
        raise WrongAnswer(f"'ready' is {shown(ready)}, but must be true")


def command_of(line: bytes) -> Command:
    answer = _object(line, required=("current_reference", "advance_angle"), optional=("input_power",))
    # An estimate of null is none.
    names = Command._fields if answer.get("input_power") is not None else Command._fields[:2]
    return Command(*[_number(name, answer[name]) for name in names])


def duty_command_of(line: bytes) -> DutyCommand:
    """Read the answer to a Sense of a controller of duty ratios; its values are checked where every answer is."""
    answer = _object(line, required=("duty_ratios",), optional=DutyCommand._fields[1:])
    for name in ("duty_ratios", "legs"):
        if name in answer and not isinstance(answer[name], list):
            raise WrongAnswer(f"'{name}' is {shown(answer[name])}, but must be a list of three numbers")
    numbers: dict[str, Any] = {
        name: _number(name, value)
        for name, value in answer.items()
        if name not in ("duty_ratios", "legs", "fault")
    }
    ratios = tuple(_number("duty_ratios", value) for value in answer["duty_ratios"])
    others: dict[str, Any] = {name: answer[name] for name in ("legs", "fault") if name in answer}
    given: Any = ratios
    return DutyCommand(given, **others, **numbers)


def _object(line: bytes, *, required: Sequence[str], optional: Sequence[str] = ()) -> dict[str, Any]:
    try:
        answer: object = _DECODER.decode(line.decode())
    except UnicodeDecodeError as error:
        raise WrongAnswer(
            f"the answer {_shown_line(line)} is not UTF-8 at byte {error.start + 1}, but must be JSON"
        ) from None
    except (ValueError, RecursionError) as error:
        reason = str(error) if isinstance(error, _NotANumber) else "is not JSON"
        raise WrongAnswer(f"the answer {_shown_line(line)} {reason}; it must be one JSON object") from None
    if not isinstance(answer, dict):
        raise WrongAnswer(f"the answer {_shown_line(line)} is not a JSON object, but must be one")
    for key in required:
        if key not in answer:
            raise WrongAnswer(f"the answer {_shown_line(line)} has no key '{key}'")
    if len(answer) > len(required):
        known = (*required, *optional)
        for key in answer:
            if key not in known:
                raise WrongAnswer(
                    f"the answer has the unknown key {shown(key)}; the nearest known one is '{nearest(key, known)}'"
                )
    return answer


def _number(name: str, value: object) -> float:
    if type(value) is not float and type(value) is not int:
        raise WrongAnswer(f"'{name}' is {shown(value)}, but must be a number")
    try:
        return float(value)
    except OverflowError:
        raise WrongAnswer(f"'{name}' is {shown(value)}, which is too large for a 64-bit float") from None


def _shown_line(line: bytes) -> str:
    text = line[: _LONGEST_SHOWN + 1].rstrip(b"\r\n").decode(errors="backslashreplace")
    return f"'{one_line(text)}'" if len(text) <= _LONGEST_SHOWN else f"'{one_line(text[:_LONGEST_SHOWN])}…'"


class _NotANumber(ValueError):
    pass


def _refuse(constant: str) -> float:
    raise _NotANumber(f"holds {constant}, which JSON does not have")


_DECODER = json.JSONDecoder(parse_constant=_refuse)
