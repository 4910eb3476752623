from collections.abc import Callable

import pytest

from drivegate_cases.documents.reading import parse_overrides

KNOWN = ("inductance_h", "phases", "emf_shape", "emf_table")


@pytest.mark.parametrize(
    ("pair", "value"),
    [
        ("inductance_h=2e-3", 2e-3),
        (" inductance_h = .5 ", 0.5),
        ("phases=3", 3),
        ("emf_shape=sine", "sine"),
        ('emf_shape="sine"', "sine"),
        ("emf_shape=a=b", "a=b"),
        ("emf_table=[[0, 0], [90, 1]]", [[0, 0], [90, 1]]),
        ("emf_table=" + "[" * 100_000, "[" * 100_000),
    ],
)
def test_a_pair_gives_a_value(pair: str, value: object) -> None:
    (read,) = parse_overrides([pair], KNOWN).values()
    assert read == value
    assert type(read) is type(value)


def test_the_last_of_several_values_counts() -> None:
    assert parse_overrides(["phases=3", "phases=5"], KNOWN) == {"phases": 5}


@pytest.mark.parametrize("pair", ["phases", "phases=", "=5", "", "=", "line\nbreak"])
def test_what_is_no_pair_is_refused(refusal: Callable[..., str], pair: str) -> None:
    assert "KEY=VALUE" in refusal(parse_overrides, [pair], KNOWN)


@pytest.mark.parametrize("pair", ["indutance_h=1", "Inductance_H=1", "inductance\n=1"])
def test_an_unknown_key_is_named_with_the_nearest(refusal: Callable[..., str], pair: str) -> None:
    message = refusal(parse_overrides, [pair], KNOWN)
    assert "is unknown, the nearest known key is 'inductance_h'" in message


def test_a_value_nested_too_deeply_is_refused(refusal: Callable[..., str]) -> None:
    message = refusal(parse_overrides, ["emf_table=" + "[" * 900 + "]" * 900], KNOWN)
    assert "--set emf_table: the value is nested too deeply" in message
