"""The binary records in Python and in C are the same ones."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from drivegate_models import contract as contracts
from drivegate_models.contract.current import records as contract
from drivegate_models.contract.current.signals import Command, Nameplate, Sense

HEADER = Path(contracts.__file__).with_name("include") / "drivegate.h"
RECORDS = {"nameplate": contract.NAMEPLATE, "sense": contract.SENSE, "command": contract.COMMAND}
SIGNALS = {"nameplate": Nameplate, "sense": Sense, "command": Command}


def compile_and_run(source: str, folder: Path, *flags: str) -> str:
    file = folder / "layout.c"
    file.write_text(source, encoding="utf-8")
    program = folder / "layout"
    command = ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic", f"-I{HEADER.parent}", *flags]
    subprocess.run([*command, str(file), "-o", str(program)], check=True)
    return subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout


def offset(record: str, field: str) -> str:
    return f"offsetof(drivegate_{record}, {field})"


def layout_in_c(folder: Path) -> dict[str, int]:
    lines = ['printf("version %d\\n", DRIVEGATE_ABI_VERSION);']
    for record, dtype in RECORDS.items():
        lines.append(f'printf("{record} %zu\\n", sizeof(drivegate_{record}));')
        lines += [f'printf("{record}.{field} %zu\\n", {offset(record, field)});' for field in dtype.names]
    body = "\n".join(lines)
    source = f'#include "drivegate.h"\n#include <stdio.h>\nint main(void) {{\n{body}\nreturn 0;\n}}\n'
    output = compile_and_run(source, folder)
    return {name: int(value) for name, value in (line.split() for line in output.splitlines())}


def layout_in_numpy() -> dict[str, int]:
    layout = {"version": contract.ABI_VERSION}
    for record, dtype in RECORDS.items():
        layout[record] = dtype.itemsize
        layout |= {f"{record}.{field}": dtype.fields[field][1] for field in dtype.names}
    return layout


def test_records_have_the_layout_of_the_header(tmp_path):
    assert layout_in_c(tmp_path) == layout_in_numpy()


def sizes_stated(header: Path) -> dict[str, int]:
    stated = re.findall(r"sizeof\(drivegate_(\w+)\) == (\d+)", header.read_text(encoding="utf-8"))
    return {record: int(size) for record, size in stated}


def test_the_header_states_the_size_of_every_record():
    """A wrong size compiles nowhere; this names the right one."""
    assert sizes_stated(HEADER) == {record: dtype.itemsize for record, dtype in RECORDS.items()}


def test_the_example_in_the_header_compiles(tmp_path):
    text = HEADER.read_text(encoding="utf-8")
    start, end = text.index(' *     #include "drivegate.h"'), text.index(" * All quantities")
    example = "\n".join(
        line.removeprefix(" *     ").removeprefix(" *") for line in text[start:end].splitlines()
    )
    program = example + "\nint main(void) { return drivegate_state_size() == 8 ? 0 : 1; }\n"
    assert compile_and_run(program, tmp_path) == ""


@pytest.mark.parametrize("record", RECORDS)
def test_records_are_not_padded(record):
    dtype = RECORDS[record]
    assert dtype.itemsize == 8 * len(dtype.names), f"{record} has padding between or after its fields"


@pytest.mark.parametrize("record", RECORDS)
def test_records_start_with_their_size_and_hold_the_signals_in_order(record):
    size, *fields = RECORDS[record].names
    assert size == "struct_size"
    assert [field for field in fields if field != "phase_count"] == list(SIGNALS[record]._fields)


def test_a_sense_record_points_to_its_phase_currents():
    currents = np.zeros(3)
    sense = Sense(0.5, 10.0, 9.0, (1.0, -2.0, 3.0), 6.0, 48.0)
    record = contract.sense_record(sense, currents)[0]
    assert record["struct_size"] == contract.SENSE.itemsize
    assert record["phase_count"] == 3
    assert record["phase_currents"] == currents.ctypes.data
    assert currents.tolist() == [1.0, -2.0, 3.0]
    assert (record["time"], record["speed"], record["half_supply_voltage"]) == (0.5, 9.0, 48.0)


def test_a_nameplate_record_holds_the_nameplate():
    nameplate = Nameplate(
        5, 11, *(float(number) for number in range(10)), 1, *(float(number) for number in range(5))
    )
    record = contract.nameplate_record(nameplate)[0]
    assert record["struct_size"] == contract.NAMEPLATE.itemsize
    assert tuple(record[name] for name in Nameplate._fields) == nameplate


def test_a_fresh_command_record_holds_no_answer():
    record = contract.command_record()[0]
    assert record["struct_size"] == contract.COMMAND.itemsize
    assert all(np.isnan(record[name]) for name in Command._fields)


def test_a_command_estimates_no_power_by_default():
    assert np.isnan(Command(1.0, 0.5).input_power)


def test_the_public_names_come_without_numpy():
    script = "import sys; from drivegate import Command, Nameplate, Sense; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0, (
        "importing the contract's names loads numpy, which every start of the command line would pay for"
    )
