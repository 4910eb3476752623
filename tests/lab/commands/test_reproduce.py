"""``drivegate reproduce``: a folder with the page, and a table for people."""

from pathlib import Path
from typing import Any

import pytest


def test_what_is_reproduced_is_written_and_counted(
    command: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def reproduce(folder: Path) -> dict[str, Any]:
        (folder / "page.html").write_text("a page", encoding="utf-8")
        row = dict.fromkeys(
            ("fact", "quantity", "published", "ours", "residual", "tolerance", "verdict"), "x"
        )
        return {"schema": 1, "page": "page.html", "paper": "a paper", "numbers": [row], "verdicts": {"x": 1}}

    monkeypatch.setattr("drivegate_lab.paper.report.reproduce", reproduce)
    ended = command("reproduce", "--output", str(tmp_path / "made"))
    assert ended.code == 0, ended.err
    assert (tmp_path / "made" / "page.html").read_text(encoding="utf-8") == "a page"
    assert "a paper: 1 x" in ended.out
