"""The table of what the gate reaches of templates, examples and firmwares."""

from __future__ import annotations

import pytest
from reached_code import WHY, is_whole, measured_rows

from code_coverage import count_of_functions_that_ran

ROWS = measured_rows()
LISTED = """SF:/home/me/adapter.c
FN:1,drivegate_duty_step
FNDA:9,drivegate_duty_step
DA:2,9
end_of_record
SF:/home/me/foc.c
FN:10,ran
FNDA:9,ran
FN:20,never
FNDA:0,never
BRDA:11,0,0,9
BRDA:11,0,1,-
BRDA:21,0,0,-
DA:1,1
DA:11,9
DA:12,0
DA:21,0
end_of_record
"""


def test_of_a_firmware_the_functions_that_ran_are_counted() -> None:
    assert count_of_functions_that_ran(LISTED, "adapter.c") == {
        "lines": {"reached": 1, "total": 2},
        "branches": {"reached": 1, "total": 2},
    }


@pytest.mark.parametrize("name", [name for name in ROWS if name.startswith("template ")])
def test_a_template_is_reached_or_explained(name: str) -> None:
    lines, branches = ROWS[name]["lines"], ROWS[name]["branches"]
    is_reached = lines["reached"] == lines["total"] and branches["reached"] >= 0.95 * branches["total"]
    assert is_reached or name in WHY


def test_only_what_is_open_is_explained() -> None:
    assert set(WHY) == {name for name, row in ROWS.items() if not is_whole(row)}
