"""The figures of the read-me: complete files, the same bytes every time."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
from readme_figures import README_FIGURES, main, write_readme_figures


def test_the_command_lists_what_it_wrote_and_files_are_the_same_every_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(tmp_path / "a" / "images")]) == 0
    first = [Path(line) for line in capsys.readouterr().out.splitlines()]
    second = write_readme_figures(tmp_path / "b")
    assert first == [tmp_path / "a" / "images" / f"{name}.svg" for name in README_FIGURES]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes(), f"{one.name} differs from run to run"
        assert ElementTree.parse(one).getroot().tag.endswith("svg")
        assert b"<dc:date>" not in one.read_bytes(), "the file has a date"
        assert one.stat().st_size < 300_000


@pytest.mark.parametrize("arguments", [[], ["a", "b"]])
def test_bad_usage_is_reported(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    assert capsys.readouterr().err.startswith("usage:")


def test_a_place_that_cannot_be_a_folder_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path / "file"
    place.write_text("")
    assert main([str(place)]) == 2
    assert "cannot be made" in capsys.readouterr().err
