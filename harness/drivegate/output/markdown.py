"""The result as Markdown, for the summary that CI servers show beside a job."""

from __future__ import annotations

import re
from pathlib import Path
from shlex import quote
from typing import Any, Final

from drivegate.output.explanations import distinct_faults, in_runs, unjudged_in_words
from drivegate.output.result_file import counterexample_name
from drivegate.output.wording import drive_in_words, printed_margin, runs_in_short
from drivegate.results.result import counted_levels
from drivegate_cases.documents.wording import one_line

SUMMARY_FILE: Final = "summary.md"

_SPECIAL = re.compile(r"([\\`*_\[\]<>|~#&@])")


def write_markdown(result: dict[str, Any], folder: Path) -> Path:
    """Write the summary of a result document into a folder."""
    path = folder / SUMMARY_FILE
    path.write_text(markdown(result), encoding="utf-8")
    return path


def escaped(text: object) -> str:
    """Write any text so that Markdown shows it as it is, on one line."""
    return _SPECIAL.sub(r"\\\1", one_line(str(text)))


def markdown(result: dict[str, Any]) -> str:
    """Make the summary of a result document."""
    candidate = result["candidate"]
    lines = [
        f"# {escaped(candidate['name'])}: {escaped(result['verdict'])}",
        "",
        f"{runs_in_short(result)}{_drive(result)}, effort {escaped(result['effort'])}, "
        f"seed {result['seed']}, drivegate {escaped(result['provenance']['drivegate'])}.",
        *_faults(result),
        *_causes(result),
        *_what_failed(result),
        "",
        "| check | level | verdict | margin | message |",
        "|---|---|---|---:|---|",
    ]
    for check in result["checks"]:
        margin = printed_margin(result, check)
        cells = (check["id"], check["level"], check["verdict"], margin, check["message"])
        lines.append(f"| {' | '.join(map(escaped, cells))} |")
    lines += _comparisons(result["baseline"] or [])
    return "\n".join(lines) + "\n"


def _drive(result: dict[str, Any]) -> str:
    """Name the drive; results of earlier versions do not name it."""
    drive = result.get("drive")
    return "" if drive is None else f" on the drive {escaped(drive_in_words(drive))}"


def _what_failed(result: dict[str, Any]) -> list[str]:
    """Lead with what failed and how to run it again, what counts first."""
    counted = counted_levels(result.get("fail_on"))
    failed = [check for check in result["checks"] if check["counterexample"] is not None]
    failed.sort(key=lambda check: (check["verdict"] == "waived", check["level"] not in counted))
    contested = [check for check in failed if check["verdict"] == "contested"]
    lines = _listed_failures(result, "Contested: no known good controller meets these either", contested)
    lines += _listed_failures(result, "What failed", [check for check in failed if check not in contested])
    if failed:
        lines += ["", "Run one again, in the folder of this report:", "", *_replays(result, failed)]
    return lines


def _listed_failures(result: dict[str, Any], title: str, failed: list[dict[str, Any]]) -> list[str]:
    lines = ["", f"## {title}", ""] if failed else []
    for check in failed:
        file = counterexample_name(check["id"])
        # The message is of the worst run, which need not be the counterexample.
        found = check.get("found")
        lines.append(
            f"- **{escaped(check['id'])}** {escaped(check['verdict'])} ({escaped(check['level'])}), in "
            f"{escaped(check['counterexample']['name'])}: "
            f"{escaped(found['measured'] if found else check['message'])}; [{file}]({file})"
        )
        lines += _account(result, check)
        if found:
            lines.append(f"  Worst run: {escaped(check['message'])}")
    return lines


def _replays(result: dict[str, Any], failed: list[dict[str, Any]]) -> list[str]:
    """Write the commands as indented code, in which nothing has to be escaped."""
    candidate = quote(one_line(result["candidate"]["specification"]))
    return [
        f"    drivegate replay {counterexample_name(check['id'])} --candidate {candidate}" for check in failed
    ]


def _causes(result: dict[str, Any]) -> list[str]:
    if all(check["counterexample"] is None for check in result["checks"]):
        return []
    # It brings the oracle, which a result without failures does not need.
    from drivegate.output.explanations import causes_of

    lines = [f"- {escaped(cause)}" for cause in causes_of(result)]
    return ["", "## Common cause", "", *lines] if lines else []


def _account(result: dict[str, Any], check: dict[str, Any]) -> list[str]:
    # It brings the oracle, which a result without failures does not need.
    from drivegate.output.explanations import account_of

    return [f"  {escaped(sentence)}" for sentence in account_of(result, check)]


def _comparisons(entries: list[dict[str, Any]]) -> list[str]:
    if not entries:
        return []
    lines = ["", "## Against the baseline", "", "| check | level | verdict | message |", "|---|---|---|---|"]
    for entry in entries:
        cells = (entry["check"], entry["level"], entry["verdict"], entry["message"])
        lines.append(f"| {' | '.join(map(escaped, cells))} |")
    return lines


def _faults(result: dict[str, Any]) -> list[str]:
    if not result["faults"]:
        return []
    listed = (
        f"- {escaped(fault['kind'])}{in_runs(count)}: {escaped(fault['message'])}"
        for fault, count in distinct_faults(result["faults"])
    )
    left = unjudged_in_words(result)
    return ["", "## Faults", "", *listed, *(["", escaped(left)] if left else [])]
