"""The page with a candidate's sources: what never ran is marked, with what would reach it."""

from pathlib import Path

from drivegate_reports.code_coverage.report import write

DOCUMENT = {
    "kind": "code coverage",
    "candidate": "<mine>",
    "drive": "pm-ac-servo",
    "runs": 12,
    "message": "the runs reached 2 of 3 lines (66.6 %) and 1 of 2 branches (50 %)",
    "files": [
        {
            "name": "mine.c",
            "lines": [
                {"text": "/* <b> */", "count": None, "branches": [], "hint": ""},
                {"text": "if (off)", "count": 7, "branches": [7, 0], "hint": "enable: restarts_s"},
                {"text": "stop();", "count": 0, "branches": [], "hint": ""},
                {"text": "switch (a)", "count": 3, "branches": [3, 0, 0], "hint": ""},
                {"text": "go();", "count": 7, "branches": [], "hint": ""},
            ],
        }
    ],
}


def test_lines_and_branches_that_no_run_reached_are_marked(tmp_path: Path) -> None:
    page = write(DOCUMENT, tmp_path).read_text(encoding="utf-8")
    assert '<tr class="caution" id="file-1-line-2">' in page
    assert "only one way out of the condition was taken; what moves it: enable: restarts_s" in page
    assert '<tr class="fail" id="file-1-line-3">' in page
    assert "of 3 ways out of the condition, these were not taken: 2, 3" in page
    assert '<tr class="pass" id="file-1-line-5">' in page
    assert "1 line never ran; 2 more lines ran with a branch not taken." in page
    assert "&lt;b&gt;" in page
    assert "<b>" not in page
    assert "<mine>" not in page
