"""The binary records of the contract of duty ratios are the same ones in `drivegate_duty.h` as in Python."""

from __future__ import annotations

import subprocess
from pathlib import Path

from tests.models.contract.test_contract import HEADER, compile_and_run, sizes_stated

from drivegate_models.contract.current.signals import PM_AC
from drivegate_models.contract.duty import records, signals

DUTY_HEADER = HEADER.with_name("drivegate_duty.h")
RECORDS = {
    "duty_nameplate": records.DUTY_NAMEPLATE,
    "duty_sense": records.DUTY_SENSE,
    "duty_command": records.DUTY_COMMAND,
}
# Three of a kind are an array in C.
TRIPLES = {"duty": "duty_ratios", "leg": "legs"}
NUMBERS = {"first": 0, "second": 1, "third": 2}


def in_c(field: str) -> str:
    """Give the name that a field of a record has in C."""
    number, _, thing = field.partition("_")
    return f"{TRIPLES[thing]}[{NUMBERS[number]}]" if number in NUMBERS and thing in TRIPLES else field


def test_records_have_the_layout_of_the_header(tmp_path: Path) -> None:
    lines = []
    for record, dtype in RECORDS.items():
        lines.append(f'printf("{record} %zu\\n", sizeof(drivegate_{record}));')
        for field in dtype.names or ():
            place = f"(size_t)((char *)&{record}.{in_c(field)} - (char *)&{record})"
            lines.append(f'printf("{record}.{field} %zu\\n", {place});')
    declared = "\n".join(f"static drivegate_{record} {record};" for record in RECORDS)
    body = "\n".join(lines)
    source = f'#include "{DUTY_HEADER.name}"\n#include <stdio.h>\n{declared}\nint main(void) {{\n{body}\nreturn 0; }}\n'
    printed = {
        name: int(value) for name, value in map(str.split, compile_and_run(source, tmp_path).splitlines())
    }
    expected = {}
    for record, dtype in RECORDS.items():
        expected[record] = dtype.itemsize
        expected |= {f"{record}.{field}": place for field, (_, place) in (dtype.fields or {}).items()}
    assert printed == expected


def test_the_header_states_the_size_of_every_record() -> None:
    assert sizes_stated(DUTY_HEADER) == {record: dtype.itemsize for record, dtype in RECORDS.items()}


def test_numbers_with_a_name_are_the_same(tmp_path: Path) -> None:
    named = {
        "DRIVEGATE_LEG_OFF": signals.LEG_OFF,
        "DRIVEGATE_LEG_PWM": signals.LEG_PWM,
        "DRIVEGATE_LEG_HIGH": signals.LEG_HIGH,
        "DRIVEGATE_LEG_LOW": signals.LEG_LOW,
        "DRIVEGATE_SPEED_REFERENCE": signals.SPEED_REFERENCE,
        "DRIVEGATE_TORQUE_REFERENCE": signals.TORQUE_REFERENCE,
        "DRIVEGATE_CURRENT_REFERENCE": signals.CURRENT_REFERENCE,
        "DRIVEGATE_PM_AC": PM_AC,
    }
    body = "\n".join(f'printf("%d\\n", {name});' for name in named)
    source = f'#include "{DUTY_HEADER.name}"\n#include <stdio.h>\nint main(void) {{\n{body}\nreturn 0;\n}}\n'
    assert compile_and_run(source, tmp_path).split() == [str(value) for value in named.values()]


def test_the_example_in_the_header_compiles(tmp_path: Path) -> None:
    text = DUTY_HEADER.read_text(encoding="utf-8")
    start, end = text.index(' *     #include "drivegate_duty.h"'), text.index(" * All quantities")
    lines = text[start:end].splitlines()
    example = "\n".join(line.removeprefix(" *     ").removeprefix(" *") for line in lines)
    program = example + "\nint main(void) { return drivegate_state_size() == 8 ? 0 : 1; }\n"
    # Its mathematics is linked behind it.
    file = tmp_path / "example.c"
    file.write_text(program, encoding="utf-8")
    command = ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", f"-I{DUTY_HEADER.parent}", str(file)]
    subprocess.run([*command, "-o", str(tmp_path / "example"), "-lm"], check=True)
    assert subprocess.run([str(tmp_path / "example")], check=False).returncode == 0
