"""Shared pieces of the tests of the reference cases."""

from collections.abc import Callable
from typing import Any

import pytest

from drivegate_models.errors import InputError

Refusal = Callable[..., str]


@pytest.fixture(scope="session")
def refusal() -> Refusal:
    """Call something that has to be refused, and return the one sentence that says why."""

    def call(function: Callable[..., Any], *arguments: Any, **options: Any) -> str:
        __tracebackhide__ = True
        with pytest.raises(InputError) as caught:
            function(*arguments, **options)
        message = str(caught.value)
        assert message.isprintable(), f"the message does not fit on one line: {message!r}"
        assert not message.endswith("."), f"the message is not one sentence of the usual form: {message!r}"
        assert message, "the message is empty"
        message.encode("utf-8")
        return message

    return call


@pytest.fixture
def scenario_mapping() -> dict[str, Any]:
    """Return the plain data of a small valid scenario."""
    return {
        "schema": 1,
        "name": "small",
        "drive": "paper-5-phase",
        "duration_s": 1.0,
        "speed_rpm": [[0.0, 1500.0]],
        "load": {"kind": "constant_torque", "torque_nm": 9.8, "factor": [[0.0, 0.0], [0.2, 1.0]]},
    }
