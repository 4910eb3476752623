"""The folder of a report is replaced as a whole, and nothing of anybody else is lost."""

import pytest

from drivegate.output.report_folder import MARK, ReportFolder
from drivegate.output.resumed_folder import ResumedFolder
from drivegate_models.errors import InputError


def report(place, **files):
    with ReportFolder(place) as folder:
        for name, text in files.items():
            (folder.staging / name).write_text(text, encoding="utf-8")
        folder.commit()


def content(place):
    return {path.name: path.read_text(encoding="utf-8") for path in place.rglob("*") if path.name != MARK}


def test_a_report_replaces_an_earlier_one_as_a_whole(tmp_path):
    place = tmp_path / "a" / "b"
    report(place, old="1", both="1")
    report(place, both="2", new="2")
    assert content(place) == {"both": "2", "new": "2"}
    assert [path.name for path in place.parent.iterdir()] == ["b"]


def test_what_others_put_into_a_report_is_kept(tmp_path):
    place = tmp_path / "out"
    report(place, ours="1")
    (place / "notes").mkdir()
    (place / "notes" / "mine.txt").write_text("kept", encoding="utf-8")
    report(place, ours="2")
    report(place, ours="3")
    assert (place / "notes" / "mine.txt").read_text(encoding="utf-8") == "kept"
    assert (place / "ours").read_text(encoding="utf-8") == "3"


def test_an_empty_folder_is_taken_and_a_link_stays_a_link(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    report(tmp_path / "link", ours="1")
    assert (tmp_path / "link").is_symlink()
    assert content(tmp_path / "real") == {"ours": "1"}


@pytest.mark.parametrize("mark", [None, "not JSON", "[]", '{"files": 3}'])
def test_a_mark_that_cannot_be_read_owns_nothing(tmp_path, mark):
    place = tmp_path / "out"
    place.mkdir()
    (place / "thesis.txt").write_text("kept", encoding="utf-8")
    if mark is None:
        with pytest.raises(InputError, match="no report of drivegate"):
            ReportFolder(place)
    else:
        (place / MARK).write_text(mark, encoding="utf-8")
        report(place, ours="1")
    assert (place / "thesis.txt").read_text(encoding="utf-8") == "kept"


def test_without_a_commit_nothing_remains(tmp_path):
    with ReportFolder(tmp_path / "a" / "b" / "c") as folder:
        (folder.staging / "x").write_text("x", encoding="utf-8")
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_before_anything_is_written_leaves_no_lock(tmp_path, monkeypatch):
    def interrupted(self):
        raise KeyboardInterrupt

    monkeypatch.setattr(ReportFolder, "_recover", interrupted)
    with pytest.raises(KeyboardInterrupt), ReportFolder(tmp_path / "a" / "out"):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_way_is_refused(tmp_path):
    (tmp_path / "file").write_text("x", encoding="utf-8")
    with pytest.raises(InputError, match="is a file"):
        ReportFolder(tmp_path / "file")
    with pytest.raises(InputError, match="cannot be written"), ReportFolder(tmp_path / "file" / "below"):
        pass


def test_the_folder_that_one_works_in_is_refused(tmp_path, monkeypatch):
    (tmp_path / "inside").mkdir()
    monkeypatch.chdir(tmp_path / "inside")
    for place in (tmp_path, tmp_path / "inside"):
        with pytest.raises(InputError, match="working folder"):
            ReportFolder(place)


def test_what_a_killed_run_has_left_is_removed(tmp_path):
    place = tmp_path / "out (1)"
    report(place, old="1")
    left = tmp_path / f".{place.name}.{'ab' * 6}.partial"
    left.mkdir()
    (left / "half").touch()
    (tmp_path / f".{place.name}.lock").touch()
    others = [tmp_path / f".{place.name}x.{'ab' * 6}.partial", tmp_path / f".{place.name}.mine.partial"]
    for other in others:
        other.mkdir()
    report(place, new="2")
    assert content(place) == {"new": "2"}
    assert sorted(tmp_path.iterdir()) == sorted([place, *others]), "what is not drivegate's must stay"


def test_a_report_that_a_killed_run_had_moved_away_comes_back(tmp_path):
    place = tmp_path / "out"
    report(place, old="1")
    (place / "mine.txt").write_text("kept", encoding="utf-8")
    place.rename(tmp_path / f".out.{'cd' * 6}.former")
    with ReportFolder(place):
        pass
    assert content(place) == {"old": "1", "mine.txt": "kept"}
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_no_page_is_written_through_a_link_in_an_earlier_report(tmp_path):
    place, elsewhere = tmp_path / "out", tmp_path / "elsewhere"
    elsewhere.mkdir()
    report(place, ours="1")
    (place / "runs").symlink_to(elsewhere)
    with ReportFolder(place) as folder:
        folder.commit()
        with folder.adding() as staging:
            (staging / "runs").mkdir()
            (staging / "runs" / "page").write_text("2", encoding="utf-8")
    assert list(elsewhere.iterdir()) == []
    assert (place / "runs" / "page").read_text(encoding="utf-8") == "2"


@pytest.mark.parametrize("link", [".out.lock", "out/state"])
def test_no_lock_or_result_is_written_through_a_link(tmp_path, link):
    class Results(ResumedFolder):
        def claim(self):
            self.write(self.place / "state", "ours")

    place, mine = tmp_path / "out", tmp_path / "mine.txt"
    place.mkdir()
    mine.write_text("kept", encoding="utf-8")
    (tmp_path / link).symlink_to(mine)
    if link == "out/state":
        with pytest.raises(InputError, match="holds a symbolic link, 'state', through which"):
            Results(place, kind="campaign", manifest="state", lock=".lock").__enter__()
    else:
        with pytest.raises(InputError, match="cannot be written"):
            report(place, ours="1")
    assert mine.read_text(encoding="utf-8") == "kept"
