"""A full disk and two runs into one folder: a sentence, the exit code of its kind, and nothing lost."""

import errno
import fcntl
import os

import pytest

from drivegate.output.report_folder import ReportFolder
from drivegate.output.result_reports import OWN_FORMATS
from drivegate_models.errors import InputError


@pytest.fixture
def full_disk(monkeypatch):
    """A disk on which no result can be written."""

    def fails(*given):
        raise OSError(28, "No space left on device", "result.json")

    monkeypatch.setattr("drivegate.studies.check.storing.write_result_files", fails)


def test_a_full_disk_takes_the_report_and_not_the_verdict(command, failing, full_disk, tmp_path):
    ended = command("check", "reference")
    assert ended.code == 2, "a full disk is neither the candidate's fault nor drivegate's"
    assert "drivegate-report cannot be written: No space left on device" in ended.err
    assert "no report was kept, so make room or name a folder on another disk" in ended.err
    assert "CNV-1 fails (required)" in ended.out, "the table is reported although nothing was written"
    assert ended.out.splitlines()[-1].endswith("report: none")
    assert "counterexamples/CNV-1.json" not in ended.out, "a file that is not there must not be named"
    assert command("check", "reference", "--json").document["checks"], "nor is the document lost"
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_fills_in_the_last_moment_takes_no_verdict_either(command, engine, monkeypatch):
    def fails(self):
        raise InputError("--output out cannot be written: No space left on device; name another")

    monkeypatch.setattr(ReportFolder, "commit", fails)
    ended = command("check", "reference", "initial", "--output", "out")
    assert ended.code == 2
    assert ended.out.splitlines()[-1] == "reference: pass; initial: pass, 2 s, report: none"


def test_an_earlier_report_outlives_a_full_disk(command, engine, monkeypatch, tmp_path):
    command("check", "reference")
    before = (tmp_path / "drivegate-report" / "result.json").read_bytes()
    monkeypatch.setattr(
        "drivegate.studies.check.storing.write_result_files",
        lambda *given: (_ for _ in ()).throw(OSError(28, "No space left on device")),
    )
    assert command("check", "reference").code == 2
    assert (tmp_path / "drivegate-report" / "result.json").read_bytes() == before


FULL = [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG]


@pytest.mark.parametrize("number", FULL)
@pytest.mark.parametrize("place", ["report.html", "junit.xml"])
def test_a_disk_that_fills_while_a_page_is_written_is_named_and_the_result_kept(
    command, failing, monkeypatch, tmp_path, number, place
):
    """Also where a page wraps the failure, or has written a part of itself; an earlier page does not stay."""

    def fails(document, folder):
        (folder / place).write_text("a part", encoding="utf-8")
        try:
            raise OSError(number, os.strerror(number))
        except OSError as error:
            raise RuntimeError("the figure could not be drawn") from error

    if place == "junit.xml":
        monkeypatch.setitem(OWN_FORMATS, "junit", fails)
    else:
        monkeypatch.setattr("tests.harness.commands.conftest.OnePage.load", lambda self: fails)
    ended = command("check", "reference")
    assert ended.code == 2, "the disk is the cause, not drivegate"
    assert (
        f"--output drivegate-report cannot be written: {os.strerror(number)}; the result is kept" in ended.err
    )
    folder = tmp_path / "drivegate-report"
    assert command("verify", folder / "result.json").code == 0
    assert not (folder / place).exists()
    assert command("report", folder / "result.json", "--output", "again").code == 2
    assert not (tmp_path / "again").exists()


def test_a_report_that_fails_by_itself_takes_no_result_with_it(command, failing, monkeypatch, tmp_path):
    def fails(document, folder):
        raise LookupError("a key of a result that it does not know")

    monkeypatch.setitem(OWN_FORMATS, "junit", fails)
    ended = command("check", "reference")
    assert ended.code == 3
    assert "the report 'junit' could not be written" in ended.err
    assert (tmp_path / "drivegate-report" / "result.json").is_file()


def test_two_runs_into_one_folder_are_refused_before_any_work(command, engine, tmp_path):
    with ReportFolder(tmp_path / "out"):
        ended = command("check", "reference", "--output", "out")
        assert ended.code == 2
        assert "--output out is being written by another drivegate; wait for its end" in ended.err
        assert engine.options is None, "the check must not have begun"
        assert command("check", "reference", "--output", "elsewhere").code == 0
    assert command("check", "reference", "--output", "out").code == 0, "the lock ends with its holder"
    assert not list(tmp_path.glob(".*")), "no lock stays behind"


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP])
def test_a_file_system_without_locks_is_used_and_named(
    command, engine, monkeypatch, caplog, tmp_path, number
):
    def fails(descriptor, operation):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(fcntl, "flock", fails)
    ended = command("check", "reference", "--output", "out")
    assert ended.code == 0, ended.err
    assert f"has no file locks ({os.strerror(number)})" in caplog.text
    assert (tmp_path / "out" / "result.json").is_file()
    assert not list(tmp_path.glob(".*")), "no lock stays behind"
