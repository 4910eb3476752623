"""`drivegate check` that looks into a candidate: its options, its files and what it prints."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from tests.harness.candidates.native.duty_sources import duty_source

from drivegate.commands.check import command

CHECK = ("--effort", "quick", "--workers", "1", "--only", "DUT-1", "--no-search", "-q")


def checked(folder: Path, source: str, *options: str) -> tuple[int, str, dict[str, object]]:
    file, output = folder / "mine.c", folder / "report"
    file.write_text(source, encoding="utf-8")
    words = [str(file), "--drive", "pm-ac-interior", "--output", str(output), *CHECK, *options]
    ended = CliRunner().invoke(command, words)
    assert (output / "result.json").is_file(), (ended.output, ended.exception)
    result = json.loads((output / "result.json").read_text(encoding="utf-8"))
    return result["exit_code"], ended.output, result


@pytest.mark.nightly
def test_what_is_reached_is_printed_stored_and_required(tmp_path: Path) -> None:
    rare = "if (sense->supply_voltage < 1.0) command->duty_ratios[0] = 0.5;"
    code, printed, result = checked(tmp_path, duty_source(fifth_step=rare), "--coverage-at-least", "100")
    section = result["code_coverage"]
    assert isinstance(section, dict)
    assert section["lines"]["reached"] <= section["lines"]["total"]
    assert section["branches"]["reached"] < section["branches"]["total"]
    assert f"coverage: {section['message']}" in printed.replace("\n", " ")
    assert code in (0, 1)
    folder = tmp_path / "report" / "coverage"
    assert {path.name for path in folder.iterdir()} == {"coverage.info", "coverage.xml", "index.html"}
    assert "supply_voltage: link_voltage_v" in (folder / "index.html").read_text(encoding="utf-8")


@pytest.mark.nightly
def test_a_report_of_a_sanitizer_is_stored_with_the_simplest_scenario(tmp_path: Path) -> None:
    shift = "int many = 27 + (int)self->steps; command->torque = 1 << many;"
    code, printed, result = checked(tmp_path, duty_source(fifth_step=shift), "--sanitize", "undefined")
    assert (code, result["verdict"], result["sanitizers"]) == (1, "sanitizer report", ["undefined"])
    (fault,) = result["faults"]
    assert "mine.c, line 23: shift exponent 32 is too large" in fault["message"]
    assert "sanitizer report" in printed
    stored = json.loads((tmp_path / "report" / "faults" / "1.json").read_text(encoding="utf-8"))
    assert stored == fault["scenario"]
