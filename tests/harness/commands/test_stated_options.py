"""`drivegate check` without an argument checks the manifest here, by the options that it states."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from drivegate.gate.options import CheckOptions
from drivegate_cases.drive.drive_document import load_drive

CONTROLLER = """
class Controller:
    def reset(self, nameplate): pass
    def step(self, sense): raise NotImplementedError
"""
MANIFEST = (
    'schema = 1\nname = "mine"\nkind = "python"\nentry = "controller.py:Controller"\ncontract = "duty"\n'
)
STATED = (
    '[check]\neffort = "quick"\nseed = 7\noutput = "out"\nfail_on = "advisory"\ncontested = "fail"\n'
    'drive = "pm-ac-surface"\nwaivers = "waivers.toml"\n'
)
WAIVER = (
    'schema = 1\n[[waiver]]\ncheck = "STP-1"\ncandidate = "mine"\ndrive = "pm-ac-surface"\nreason = "r"\nowner = "o"\n'
    "expires = 2100-01-01\nmargin = -1.0\n"
)


@pytest.fixture
def written(tmp_path):
    """Write a manifest with its controller into the folder that commands run in, or into another one."""

    def write(table: str, folder: str = ".") -> None:
        place = tmp_path / folder
        place.mkdir(exist_ok=True)
        (place / "controller.py").write_text(CONTROLLER, encoding="utf-8")
        (place / "candidate.toml").write_text(MANIFEST + table, encoding="utf-8")
        (place / "waivers.toml").write_text(WAIVER, encoding="utf-8")

    return write


def next_line(text: str) -> str:
    return next(line for line in text.splitlines() if line.startswith("next: "))


def test_without_arguments_it_is_the_manifest_with_all_that_it_states(command, engine, written, tmp_path):
    written(STATED)
    ended = command("check", "--only", "STP-1")
    assert ended.code == 0, ended.err
    options = engine.options
    assert options is not None
    given = replace(
        options, on_slow=None, is_ended=CheckOptions().is_ended, waivers=(), focus=CheckOptions().focus
    )
    assert given == CheckOptions(
        drive=load_drive("pm-ac-surface"), effort="quick", seed=7, fail_on="advisory", contested="fail"
    )
    assert [waiver.check for waiver in options.waivers] == ["STP-1"]
    assert json.loads((tmp_path / "out" / "result.json").read_text())["candidate"]["name"] == "mine"
    assert "report: out/report.html" in ended.out


def test_next_lines_keep_what_the_command_line_stated_and_leave_out_the_rest(command, engine, written):
    written(STATED)
    engine.focus = {"only": ["STP-1"], "stopped_at_first": True}
    assert (
        next_line(command("check", "--only", "STP-1", "-x").out) == "next: the whole check: drivegate check"
    )
    words = ("check", "candidate.toml", "--effort", "nightly", "--no-search", "--only", "STP-1")
    assert next_line(command(*words).out) == (
        "next: the whole check: drivegate check candidate.toml --effort nightly --no-search"
    )
    # Without a manifest's table, all of it is repeated.
    words = (
        "check",
        "foc",
        "--drive",
        "pm-ac-2kw",
        "--output",
        "my report",
        "--seed",
        "3",
        "--only",
        "STP-1",
    )
    assert next_line(command(*words).out) == (
        "next: the whole check: drivegate check foc --output 'my report' --drive pm-ac-2kw --seed 3"
    )


def test_the_command_line_wins(command, engine, written):
    written(STATED)
    assert command("check", "--effort", "default", "--drive", "pm-ac-2kw", "--contested", "pass").code == 0
    options = engine.options
    assert options is not None
    assert options.drive is not None
    assert (options.effort, options.drive.name, options.contested) == ("default", "pm-ac-2kw", "pass")
    assert options.seed == 7


def test_paths_start_from_the_manifest(command, engine, written, tmp_path):
    written(STATED, "sub")
    assert command("check", "sub/candidate.toml").code == 0
    assert (tmp_path / "sub" / "out" / "result.json").is_file()


def test_several_candidates_take_nothing_from_a_manifest(command, engine, written):
    written(STATED)
    command("check", "candidate.toml", "foc", "--drive", "pm-ac-2kw")
    assert engine.options is not None
    assert (engine.options.effort, engine.options.seed) == ("default", 0)


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ('[check]\noutput = "../out"\n', "leads out of the manifest's folder"),
        ('[check]\nbaseline = "/etc/hostname"\n', "leads out of the manifest's folder"),
        ('[check]\ndrive = "../drive.toml"\n', "leads out of the manifest's folder"),
        ('[check]\neffort = "quik"\n', "check.effort"),
        ('[check]\noutptu = "out"\n', "nearest known key is 'output'"),
        ("[check]\nseed = -1\n", "check.seed"),
        (
            '[check]\nwaivers = "missing.toml"\n',
            "the key 'waivers' of [check] names missing.toml, which does not",
        ),
        ('[check]\ncorpus = "none"\n', "the key 'corpus' of [check] names none, which does not exist"),
        (
            '[check]\ncorpus = "candidate.toml"\n',
            "'corpus' of [check] names candidate.toml, a file; name a folder",
        ),
        (
            '[check]\noutput = "candidate.toml"\n',
            "'output' of [check] names candidate.toml, a file; name a folder",
        ),
        ('[check]\nwaivers = "."\n', "a folder; name a file in it"),
        (
            '[check]\ndrive = "pm-ac-interor"\n',
            "no drive is called 'pm-ac-interor', the nearest is 'pm-ac-interior'",
        ),
    ],
)
def test_what_a_manifest_may_not_state_is_refused(refused, engine, written, table, sentence):
    written(table)
    assert sentence in refused("check")


def test_a_link_does_not_lead_out_either(refused, engine, written, tmp_path):
    written('[check]\noutput = "out"\n')
    (tmp_path / "out").symlink_to("/tmp", target_is_directory=True)
    assert "leads out" in refused("check")


def test_without_a_manifest_a_candidate_must_be_named(refused):
    assert "there is no candidate.toml in this folder" in refused("check")


def test_help_needs_no_manifest(command):
    assert "Without a CANDIDATE" in command("check", "--help").out
