"""`drivegate man`: pages that man understands, of every command and option."""

import subprocess

import click
import pytest

from drivegate.commands.command_line import command_line


def test_every_command_has_a_page_with_its_options(command, tmp_path):
    ended = command("man", "pages", "--json")
    assert ended.code == 0
    context = click.Context(command_line, info_name="drivegate")
    names = command_line.list_commands(context)
    assert {"drivegate.1", *(f"drivegate-{name}.1" for name in names)} >= set(ended.document["files"])
    assert set(ended.document["files"]) == {path.name for path in (tmp_path / "pages").iterdir()}
    page = (tmp_path / "pages" / "drivegate-check.1").read_text(encoding="utf-8").replace("\\-", "-")
    check = command_line.get_command(context, "check")
    for option in check.params:
        if isinstance(option, click.Option):
            assert all(word in page for word in option.opts), option.name
    for line in page.splitlines():
        assert line[:3] in (".TH", ".SH", ".PP", ".TP", ".B ", ".nh", ".ad") or not line.startswith(
            (".", "'")
        ), line


@pytest.mark.needs("man")
def test_man_shows_a_page_without_a_warning(command, tmp_path):
    command("man", "pages")
    for page in ("drivegate.1", "drivegate-check.1", "drivegate-new.1"):
        ended = subprocess.run(
            ["man", "--warnings", "-l", str(tmp_path / "pages" / page)],
            capture_output=True,
            text=True,
            check=True,
            env={"PATH": "/usr/bin:/bin", "MANWIDTH": "100", "LANG": "C.UTF-8", "MAN_KEEP_FORMATTING": ""},
        )
        assert ended.stderr == ""
        assert "--help" in ended.stdout


def test_a_folder_that_cannot_be_made_is_refused(command, tmp_path):
    (tmp_path / "file").touch()
    ended = command("man", "file/pages")
    assert ended.code == 2
    assert "name another" in ended.err
