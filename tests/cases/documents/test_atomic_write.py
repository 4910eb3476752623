from collections.abc import Callable
from pathlib import Path

import pytest

from drivegate_cases.documents.atomic_write import write_atomically


@pytest.mark.parametrize(
    ("content", "expected"),
    [("9.8 N·m\n", "9.8 N·m\n".encode()), (b"\x00\r\n\xff", b"\x00\r\n\xff"), ("", b"")],
)
def test_text_and_bytes_arrive_unchanged(tmp_path: Path, content: str | bytes, expected: bytes) -> None:
    path = tmp_path / "result.json"
    write_atomically(path, content)
    assert path.read_bytes() == expected
    assert list(tmp_path.iterdir()) == [path], "something was left beside the file"


def test_an_existing_file_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    path.write_text("a much longer old content")
    write_atomically(str(path), "new")
    assert path.read_text() == "new"


def test_a_new_file_has_the_permissions_of_any_other(tmp_path: Path) -> None:
    write_atomically(tmp_path / "ours", "x")
    (tmp_path / "theirs").write_text("x")
    assert (tmp_path / "ours").stat().st_mode == (tmp_path / "theirs").stat().st_mode


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "target").write_text("old")
    (tmp_path / "link").symlink_to("target")
    write_atomically(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_text() == "new"


def test_a_failure_leaves_the_old_file_and_nothing_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "result.json"
    path.write_text("old")

    def fail(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", fail)
    with pytest.raises(OSError, match="No space"):
        write_atomically(path, "new")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path], "a partial file was left behind"


@pytest.mark.parametrize(
    "place", ["missing/result.json", "file/result.json", "folder", "nul\0l", "new\nline/x"]
)
def test_a_wrong_place_is_named(tmp_path: Path, refusal: Callable[..., str], place: str) -> None:
    (tmp_path / "file").write_text("x")
    (tmp_path / "folder").mkdir()
    before = sorted(tmp_path.iterdir())
    message = refusal(write_atomically, tmp_path / place, "content")
    assert str(tmp_path) in message
    assert "existing, writable folder" in message
    assert sorted(tmp_path.iterdir()) == before, "something was left behind"
