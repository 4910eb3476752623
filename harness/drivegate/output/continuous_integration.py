"""The result as JUnit XML and as Markdown, which CI servers show."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Collection
from pathlib import Path
from typing import Any, Final

from drivegate.checks.margin import margin_in_words
from drivegate.output.explanations import (
    by_urgency,
    distinct_faults,
    explanations,
    in_runs,
    unjudged_in_words,
)
from drivegate.output.rerun import replay_command
from drivegate.output.result_file import counterexample_name
from drivegate.output.wording import drive_in_words, printed_margin, runs_in_short
from drivegate.results.result import NOT_WITNESSED, STALE_WAIVERS, alteration_of, counted_levels
from drivegate_cases.documents.wording import one_line

JUNIT_FILE: Final = "junit.xml"
SUMMARY_FILE: Final = "summary.md"

_SPECIAL = re.compile(r"([\\`*_\[\]<>|~#&@])")


def write_junit(result: dict[str, Any], folder: Path) -> Path:
    path = folder / JUNIT_FILE
    path.write_bytes(junit_xml(result))
    return path


def junit_xml(result: dict[str, Any]) -> bytes:
    """Make JUnit XML of a result document.

    An advisory check that fails is reported in the output of its case, which passes unless advisory checks count. One
    that is waived is skipped, with its owner and the last day of the waiver, and so is an advisory one that a fault
    kept from being judged; of a required one that is an error, and so is a failure that is not witnessed yet. What
    explains an outcome comes first in its message: the cause that several failures share, or that fault. Faults and
    what failed come first, since servers show a few cases only. A comparison with a baseline has cases of its own. The
    class of a case is the candidate and the family of the check. A run serves many checks, so the time of a check is
    its share of all times that a run was judged.
    """
    name = one_line(result["candidate"]["name"])
    suite = ElementTree.Element("testsuite", name=f"drivegate {name}")
    counted = counted_levels(result.get("fail_on"))
    seconds = result["timing"].get("seconds", 0.0)
    explained = explanations(result)
    if altered := alteration_of(result):
        message = f"the result {altered}"
        ElementTree.SubElement(_case(suite, name, "content hash"), "error", type="altered", message=message)
    for number, (fault, count) in enumerate(distinct_faults(result["faults"]), start=1):
        case = _case(suite, name, f"fault {number}")
        error = ElementTree.SubElement(
            case,
            "error",
            type=one_line(fault["kind"]),
            message=one_line(f"{fault['kind']}{in_runs(count)}: {fault['message']}"),
        )
        error.text = "\n".join(map(one_line, fault["traceback"].splitlines()))
    judged = sum(check["runs"] for check in result["checks"]) or 1
    for check in by_urgency(result["checks"]):
        case = _case(suite, f"{name}.{check['id'].partition('-')[0]}", check["id"])
        case.set("time", f"{seconds * check['runs'] / judged:.3f}")
        if check.get("evidence_for"):
            properties = ElementTree.SubElement(case, "properties")
            for identifier in check["evidence_for"]:
                ElementTree.SubElement(properties, "property", name="requirement", value=one_line(identifier))
        _judge(case, result, check, explained.get(check["id"], ""))
    for entry in result["baseline"] or ():
        _compare(_case(suite, name, f"{entry['check']} against the baseline"), entry, counted)
    cases = suite.findall("testcase")
    suite.set("tests", str(len(cases)))
    for kind, attribute in (("failure", "failures"), ("error", "errors"), ("skipped", "skipped")):
        suite.set(attribute, str(sum(case.find(kind) is not None for case in cases)))
    suite.set("time", f"{seconds:.3f}")
    suites = ElementTree.Element("testsuites")
    suites.append(suite)
    ElementTree.indent(suites)
    text: bytes = ElementTree.tostring(suites, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _case(suite: ElementTree.Element, group: str, name: str) -> ElementTree.Element:
    return ElementTree.SubElement(suite, "testcase", classname=group, name=one_line(name))


def _judge(
    case: ElementTree.Element, result: dict[str, Any], check: dict[str, Any], explanation: str
) -> None:
    verdict = check["verdict"]
    message = one_line(f"{explanation}; {check['message']}" if explanation else check["message"])
    required = check["level"] in counted_levels(result.get("fail_on"))
    unjudged = verdict == "inconclusive" and explanation
    if verdict in ("not applicable", "contested", "waived") or (unjudged and not required):
        # The message of a waived check ends with owner, last day and reason.
        ElementTree.SubElement(case, "skipped", message=message)
    elif verdict in STALE_WAIVERS or (required and verdict == "fail"):
        failure = ElementTree.SubElement(case, "failure", type=verdict, message=message)
        margin = "–" if check["margin"] is None else margin_in_words(check["margin"], 4)
        lines = [f"{check['requirement']} Limit: {check['limit']}. Margin: {margin}."]
        if check["counterexample"] is not None:
            # It brings the oracle, which a result without failures does not need.
            from drivegate.output.causes import account_of

            lines += account_of(result, check)
        failure.text = "\n".join(map(one_line, lines)).rstrip("\n")
    elif required and verdict != "pass":
        ElementTree.SubElement(case, "error", type=one_line(verdict), message=message)
    else:
        output = ElementTree.SubElement(case, "system-out")
        output.text = one_line(f"{check['level']}, {verdict}: {message}")


def _compare(case: ElementTree.Element, entry: dict[str, Any], counted: Collection[str]) -> None:
    message = one_line(entry["message"])
    if entry["level"] in counted and entry["verdict"] == "fail":
        ElementTree.SubElement(case, "failure", type="fail", message=message)
    else:
        ElementTree.SubElement(case, "system-out").text = one_line(f"{entry['verdict']}: {message}")


def write_markdown(result: dict[str, Any], folder: Path) -> Path:
    path = folder / SUMMARY_FILE
    path.write_text(markdown(result), encoding="utf-8")
    return path


def escaped(text: object) -> str:
    """Write any text so that Markdown shows it as it is, on one line."""
    return _SPECIAL.sub(r"\\\1", one_line(str(text)))


def markdown(result: dict[str, Any]) -> str:
    candidate, drive = result["candidate"], result.get("drive")
    # Results of earlier versions do not name the drive.
    on_drive = "" if drive is None else f" on the drive {escaped(drive_in_words(drive))}"
    lines = [
        f"# {escaped(candidate['name'])}: {escaped(result['verdict'])}",
        "",
        f"{runs_in_short(result)}{on_drive}, effort {escaped(result['effort'])}, "
        f"seed {result['seed']}, drivegate {escaped(result['provenance']['drivegate'])}.",
        *(["", f"**This result {altered}.**"] if (altered := alteration_of(result)) else []),
        *_faults(result),
        *_causes(result),
        *_what_failed(result),
        "",
        "| check | level | verdict | margin | message |",
        "|---|---|---|---:|---|",
    ]
    for check in by_urgency(result["checks"]):
        margin = printed_margin(result, check)
        cells = (check["id"], check["level"], check["verdict"], margin, check["message"])
        lines.append(f"| {' | '.join(map(escaped, cells))} |")
    lines += _comparisons(result["baseline"] or [])
    return "\n".join(lines) + "\n"


def _what_failed(result: dict[str, Any]) -> list[str]:
    """Lead with what failed and how to run it again, what counts first."""
    counted = counted_levels(result.get("fail_on"))
    failed = [check for check in result["checks"] if check["counterexample"] is not None]
    failed.sort(key=lambda check: (check["verdict"] == "waived", check["level"] not in counted))
    contested = [check for check in failed if check["verdict"] == "contested"]
    unwitnessed = [check for check in failed if check["verdict"] == NOT_WITNESSED]
    counting = [check for check in failed if check not in (*contested, *unwitnessed)]
    lines = _listed_failures(result, "Contested: no known good controller meets these either", contested)
    lines += _listed_failures(result, "What failed", counting)
    lines += _listed_failures(
        result, "Not yet witnessed: no known good controller was run there", unwitnessed
    )
    if failed:
        # Indented code, in which nothing has to be escaped.
        commands = [f"    {replay_command(result, check['id'])}" for check in failed]
        lines += ["", "Run one again, in the folder of this report:", "", *commands]
    return lines


def _listed_failures(result: dict[str, Any], title: str, failed: list[dict[str, Any]]) -> list[str]:
    if not failed:
        return []
    # It brings the oracle, which a result without failures does not need.
    from drivegate.output.causes import account_of

    lines = ["", f"## {title}", ""]
    for check in failed:
        file = counterexample_name(check["id"])
        # The message is of the worst run, which need not be the counterexample.
        found = check.get("found")
        lines.append(
            f"- **{escaped(check['id'])}** {escaped(check['verdict'])} ({escaped(check['level'])}), in "
            f"{escaped(check['counterexample']['name'])}: "
            f"{escaped(found['measured'] if found else check['message'])}; [{file}]({file})"
        )
        lines += [f"  {escaped(sentence)}" for sentence in account_of(result, check)]
        if found:
            lines.append(f"  Worst run: {escaped(check['message'])}")
    return lines


def _causes(result: dict[str, Any]) -> list[str]:
    if all(check["counterexample"] is None for check in result["checks"]):
        return []
    # It brings the oracle, which a result without failures does not need.
    from drivegate.output.causes import causes_of, likely_causes_of

    lines = [f"- {escaped(cause)}" for cause in (*causes_of(result), *likely_causes_of(result))]
    return ["", "## Causes", "", *lines] if lines else []


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
