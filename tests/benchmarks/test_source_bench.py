"""What is measured in the sources alone, and how it is reported."""

import json
import sys

import pytest

import duty_rates
import duty_yardstick
import example_rates
import source_bench
import speed_tables
import yardstick_ratio
from drivegate.commands.conduct import conducted
from drivegate_lab.bench.plan import planned
from drivegate_lab.bench.workbench import NotMeasured, Workbench
from in_turns import table, turn

ROWS = source_bench.source_rows(quick=False)


@pytest.fixture
def workbench(tmp_path):
    return Workbench(tmp_path, quick=True)


def test_rows_and_bars_are_those_of_the_design():
    assert {one.name: one.bar for one in ROWS} == {
        **{
            f"yardstick.{name}.{rpm}": 1.2
            for name in ("initial", "reference")
            for rpm in range(500, 2001, 500)
        },
        "yardstick.foc": 1.2,
        **{f"example.{language}": 1.3 for language in ("c", "numba", "rust")},
        "example.python": 50.0,
        "duty.foc.ideal": 120.0,
        "duty.foc.dead-time": 100.0,
        "peer.export.ideal": 7.0,
        "peer.export.dead-time": 7.0,
        "peer.motulator": 2000.0,
        "peer.same": None,
    }
    assert not {one.name for one in ROWS} & {one.name for one in planned(quick=False, cold=True)}
    quick = {one.name: one.setting for one in source_bench.source_rows(quick=True)}
    assert all(quick[one.name] != one.setting for one in ROWS)


def test_a_yardstick_out_of_step_is_no_measure(workbench, monkeypatch):
    monkeypatch.setattr(yardstick_ratio, "SIMULATED", 2.0)
    assert yardstick_ratio.yardstick_ratio(workbench, "initial", 1500).correctness.valid
    monkeypatch.setattr(yardstick_ratio, "LOCK_STEP_TOLERANCE", 0.0)
    assert not yardstick_ratio.yardstick_ratio(workbench, "initial", 1500).correctness.valid


def test_the_yardstick_of_duty_ratios_is_in_step(workbench, monkeypatch):
    monkeypatch.setattr(duty_yardstick, "SIMULATED", 1.0)
    value = duty_yardstick.yardstick_ratio(workbench)
    assert value.correctness.valid, value.correctness.measured
    monkeypatch.setattr(duty_yardstick, "LOCK_STEP_TOLERANCE", 0.0)
    with pytest.raises(NotMeasured, match="misses"):
        duty_yardstick.yardstick_ratio(workbench)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("language", ["c", "numba", pytest.param("rust", marks=pytest.mark.needs("rustc"))])
def test_compiled_examples_are_measured_beside_the_reference(workbench, monkeypatch, language):
    monkeypatch.setattr(example_rates, "SIMULATED", 1.0)
    value = example_rates.example_ratio(workbench, language)
    assert value.correctness.valid, value.correctness.measured
    assert 0.1 < value.value < 10.0


@pytest.mark.parametrize("name", ["peer.export.ideal", "peer.motulator", "peer.same"])
def test_a_peer_that_is_not_installed_is_said_to_be_missing(workbench, monkeypatch, name):
    for package in ("motulator", "motulator_export"):
        monkeypatch.setitem(sys.modules, package, None)
    row = next(one for one in ROWS if one.name == name).row(workbench)
    assert row.value is None
    assert "is not installed in this Python" in row.check


def test_the_example_in_python_is_measured(workbench, monkeypatch):
    monkeypatch.setattr(example_rates, "SIMULATED", 1.0)
    value = example_rates.python_example_rate(workbench)
    assert value.correctness.valid, value.correctness.measured
    assert value.value >= value.median > 0.0


@pytest.mark.parametrize("bridge", ["ideal", "dead-time"])
def test_the_loop_of_duty_ratios_is_measured(workbench, monkeypatch, bridge):
    monkeypatch.setattr(duty_rates, "SIMULATED", 1.0)
    value = duty_rates.duty_rate(workbench, bridge)
    assert value.correctness.valid, value.correctness.measured
    assert value.value >= value.median > 0.0


def test_an_example_whose_compiler_is_missing_says_so(workbench, monkeypatch):
    monkeypatch.setenv("PATH", "/usr/bin:/bin")
    monkeypatch.setattr(example_rates, "FOLDER", workbench.scratch)
    (workbench.scratch / "rust").mkdir()
    build = workbench.scratch / "rust" / "build.sh"
    build.write_text("#!/bin/sh\necho 'there is no rustc' >&2\nexit 1\n")
    build.chmod(0o755)
    with pytest.raises(NotMeasured, match="there is no rustc"):
        example_rates.example_ratio(workbench, "rust")


def test_a_missing_compiler_is_reported_and_fails_nothing(capsys, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    words = ["--quick", "--only", "yardstick", "--only", "example.c", "--json"]
    code = conducted(lambda: source_bench.command.main(words, standalone_mode=False), as_json=True)
    assert code == 0
    document = json.loads(capsys.readouterr().out)
    assert len(document["rows"]) == 10
    assert document["command"].startswith("python benchmarks/source_bench.py --quick --only yardstick")
    for row in document["rows"]:
        assert (row["value"], row["valid"]) == (None, None)
        assert "no-such-compiler" in row["check"]


def test_two_installations_are_compared_turn_by_turn(tmp_path):
    """The programs take a turn each; the second is given what the first one wrote."""
    program = tmp_path / "drivegate"
    program.write_text(
        f"#!{sys.executable}\n"
        "import json, sys\n"
        "from pathlib import Path\n"
        "words = sys.argv[1:]\n"
        "assert words[:3] == ['bench', '--only', 'loop']\n"
        "earlier = '--compare' in words\n"
        "assert not earlier or Path(words[words.index('--compare') + 1]).is_file()\n"
        "rows = [{'name': 'loop', 'times_as_good': 1.5}, {'name': 'other', 'times_as_good': None}]\n"
        "Path(words[words.index('--output') + 1]).write_text(json.dumps({'rows': rows if earlier else []}))\n"
    )
    program.chmod(0o755)
    assert turn([str(program), str(program)], ["--only", "loop"], tmp_path) == {"loop": 1.5}
    program.write_text("#!/bin/sh\nexit 2\n")
    with pytest.raises(SystemExit, match="nothing is compared"):
        turn([str(program), str(program)], [], tmp_path)


def test_the_median_and_the_range_of_all_turns_are_reported():
    lines = table([{"a": 1.0, "b": 2.0}, {"a": 3.0}, {"a": 2.5, "b": 1.0}]).splitlines()
    assert [line.split() for line in lines[1:]] == [["a", "2.500", "1.000", "3.000"]]


def test_tables_are_made_of_all_rows():
    rows = {
        one.name: {
            "title": one.title,
            "setting": one.setting,
            "unit": one.unit,
            "better": one.better,
            "bar": one.bar,
            "value": 2.0,
            "check": "right",
        }
        for one in (*planned(quick=False, cold=True), *ROWS)
    }
    loops, others = speed_tables.loop_table(rows), speed_tables.other_table(rows)
    assert sum("| 2.00 | 2.00 | 2.00 | 2.00 |" in line for line in loops) == 10
    assert sum("| 2.00 " in line for line in others) == len(rows) - 40
    name = next(name for name in rows if not name.startswith("loop."))
    without = speed_tables.other_table(rows | {name: rows[name] | {"value": None}})
    assert len(without) == len(others) - 1, "what cannot be measured has no row"
    peers = [
        {"peer": "one", "reason": "not installed"},
        {
            "peer": "two",
            "version": "1",
            "job": "job",
            "times_real_time": 0.5,
            "valid": True,
            "check": "right",
        },
        {
            "peer": "three",
            "version": "1",
            "job": "job",
            "times_real_time": 0.5,
            "valid": False,
            "check": "off",
        },
    ]
    table = "\n".join(speed_tables.peer_table(peers, 2.0))
    assert "| one | not installed |" in table
    assert "| two 1 | job | 0.500 | 4.00 |" in table
    assert "| three 1 | WRONG: off | – | – |" in table
