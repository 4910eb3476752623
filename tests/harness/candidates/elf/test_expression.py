"""Arithmetic in a manifest: what is no arithmetic is refused, and nothing is evaluated as Python."""

from __future__ import annotations

import pytest

from drivegate.candidates.elf.expression import Place, parsed, parsed_place
from drivegate.candidates.fault import bounded_line
from drivegate_models.errors import InputError


def test_operands_come_before_what_is_done_with_them() -> None:
    assert parsed("2048 + 12.4 * phase_currents[0]") == (
        2048.0,
        12.4,
        Place("phase_currents", None, (0,)),
        "*",
        "+",
    )
    # Words of Python are names like any other.
    assert parsed("in.is % 1e3") == (Place("in", None, ("is",)), 1000.0, "%")
    assert parsed("-min(a.b, 1, 0x10)") == (Place("a", None, ("b",)), 1.0, "min", 16.0, "min", "negated")
    # Operators bind as in C.
    assert parsed("~a >> 8 & b | c << 1 + d ^ e") == (
        *(Place("a", None, ()), "~", 8.0, ">>", Place("b", None, ()), "&"),
        *(Place("c", None, ()), 1.0, Place("d", None, ()), "+", "<<", Place("e", None, ()), "^", "|"),
    )
    assert parsed("hadc1.Instance->DR") == (Place("hadc1", None, ("Instance", "DR")),)
    assert parsed("floor(TIM(0x40010000).CCR[2] % 3)") == (
        Place("TIM", 0x40010000, ("CCR", 2)),
        3.0,
        "%",
        "floor",
    )


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "is no expression: "),
        ("1 +", "is no expression: "),
        ("a; b", "is no expression: "),
        ("1" * 501, "is no expression: it has more than 500 characters"),
        ("(" * 240 + "1" + ")" * 240, "is no expression: "),
        ("+".join("(1" for _ in range(40)) + ")" * 40, "is nested too deeply"),
        ("1e999 ** 2", "is not allowed; an expression has numbers, names, "),
        ("9" * 400, "is too large for a number"),
        ("__import__('os').system('true')", "is not allowed"),
        ("[1][0]", "is not allowed"),
        ("'text'", "is not allowed"),
        ("a[-1]", "is not allowed"),
        ("a if b else c", "is no expression: "),
        ("sin(a)", r"'sin\(a\)' is no call of a known function; there are numbers"),
        ("min(a, b=1)", "is not allowed"),
        ("min(a)", "is no call of a known function"),
        ("abs(a, b)", "is no call of a known function"),
        ("(lambda: 1)()", "is no expression: "),
    ],
)
def test_everything_else_is_refused(text: str, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        parsed(text)


def test_a_place_is_no_expression() -> None:
    assert parsed_place("ADC_Value[0]").text == "ADC_Value[0]"
    assert bounded_line(parsed_place("TIM(0x4001_0000)").text) == "TIM(0x4001_0000)", "it stays in reports"
    assert parsed_place("TIM(1073807360)").text == "TIM(0x4001_0000)"
    with pytest.raises(InputError, match="'1 \\+ a' is no variable; write one such as 'ADC_Value"):
        parsed_place("1 + a")
