"""The result as JUnit XML, which CI servers show: one test case for each check, one for each fault."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Collection
from pathlib import Path
from typing import Any, Final

from drivegate.checks.margin import margin_in_words
from drivegate.output.explanations import distinct_faults, explanations, in_runs
from drivegate.results.result import STALE_WAIVERS, counted_levels
from drivegate_cases.documents.wording import one_line

JUNIT_FILE: Final = "junit.xml"


def write_junit(result: dict[str, Any], folder: Path) -> Path:
    """Write JUnit XML of a result document into a folder."""
    path = folder / JUNIT_FILE
    path.write_bytes(junit_xml(result))
    return path


def junit_xml(result: dict[str, Any]) -> bytes:
    """Make JUnit XML of a result document.

    An advisory check that fails is reported in the output of its case, which passes unless advisory checks count. One
    that is waived is skipped, with its owner and the last day of the waiver, and so is an advisory one that a fault
    kept from being judged; of a required one that is an error. What explains an outcome comes first in its message:
    the cause that several failures share, or that fault. A comparison with a baseline has cases of its own. The class
    of a case is the candidate and the family of the check. A run serves many checks, so the time of a check is its
    share of all times that a run was judged.
    """
    name = one_line(result["candidate"]["name"])
    suite = ElementTree.Element("testsuite", name=f"drivegate {name}")
    counted = counted_levels(result.get("fail_on"))
    seconds = result["timing"].get("seconds", 0.0)
    explained = explanations(result)
    judged = sum(check["runs"] for check in result["checks"]) or 1
    for check in result["checks"]:
        case = _case(suite, f"{name}.{check['id'].partition('-')[0]}", check["id"])
        case.set("time", f"{seconds * check['runs'] / judged:.3f}")
        _judge(case, check, counted, explained.get(check["id"], ""))
        _write_outcome(case, result, check)
    for entry in result["baseline"] or ():
        _compare(_case(suite, name, f"{entry['check']} against the baseline"), entry, counted)
    for number, (fault, count) in enumerate(distinct_faults(result["faults"]), start=1):
        case = _case(suite, name, f"fault {number}")
        error = ElementTree.SubElement(
            case,
            "error",
            type=one_line(fault["kind"]),
            message=one_line(f"{fault['kind']}{in_runs(count)}: {fault['message']}"),
        )
        error.text = "\n".join(map(one_line, fault["traceback"].splitlines()))
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
    case: ElementTree.Element, check: dict[str, Any], counted: Collection[str], explanation: str
) -> None:
    verdict = check["verdict"]
    message = one_line(f"{explanation}; {check['message']}" if explanation else check["message"])
    required = check["level"] in counted
    unjudged = verdict == "inconclusive" and explanation
    if verdict in ("not applicable", "contested", "waived") or (unjudged and not required):
        # The message of a waived check ends with owner, last day and reason.
        ElementTree.SubElement(case, "skipped", message=message)
    elif verdict in STALE_WAIVERS or (required and verdict == "fail"):
        failure = ElementTree.SubElement(case, "failure", type=verdict, message=message)
        margin = "–" if check["margin"] is None else margin_in_words(check["margin"], 4)
        failure.text = one_line(f"{check['requirement']} Limit: {check['limit']}. Margin: {margin}.")
    elif required and verdict != "pass":
        ElementTree.SubElement(case, "error", type=one_line(verdict), message=message)
    else:
        output = ElementTree.SubElement(case, "system-out")
        output.text = one_line(f"{check['level']}, {verdict}: {message}")


def _write_outcome(case: ElementTree.Element, result: dict[str, Any], check: dict[str, Any]) -> None:
    """Add the account of the counterexample to a failure."""
    failure = case.find("failure")
    if failure is None or check["counterexample"] is None:
        return
    # It brings the oracle, which a result without failures does not need.
    from drivegate.output.explanations import account_of

    failure.text = "\n".join([failure.text or "", *map(one_line, account_of(result, check))]).rstrip("\n")


def _compare(case: ElementTree.Element, entry: dict[str, Any], counted: Collection[str]) -> None:
    message = one_line(entry["message"])
    if entry["level"] in counted and entry["verdict"] == "fail":
        ElementTree.SubElement(case, "failure", type="fail", message=message)
    else:
        ElementTree.SubElement(case, "system-out").text = one_line(f"{entry['verdict']}: {message}")
