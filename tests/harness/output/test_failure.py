"""Every error message is one line of a bounded length, whoever raised it."""

from __future__ import annotations

import click
import pytest

from drivegate.output.failure import failure_of
from drivegate_cases.documents.wording import LONGEST_MESSAGE
from drivegate_models.errors import HarnessFault, InputError

LONG = "x" * 3000


@pytest.mark.parametrize(
    "error",
    [
        InputError(f"drive.toml: the key 'name' is {LONG}; shorten it"),
        click.UsageError(f"drive.toml: the option {LONG} is unknown; shorten it"),
        HarnessFault(f"drive.toml: {LONG}; shorten it"),
        ValueError(f"drive.toml: {LONG}; shorten it"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_a_long_message_is_shortened_between_place_and_remedy(error: BaseException) -> None:
    failure = failure_of(error).about(f"{LONG}.py:Mine")
    assert len(failure.message) == len(failure.document()["error"]["message"]) == LONGEST_MESSAGE
    assert "….py:Mine" not in failure.message
    assert ".py:Mine: " in failure.message
    assert "drive.toml" in failure.message
    assert failure.message.endswith(("shorten it", "prints where"))
