"""From the result document to what the conformance page shows: bounded, printable text and plain numbers."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, Final

from drivegate.isolation.layers import layers_in_words
from drivegate.output.causes import causes_of, first_to_mend, likely_causes_of
from drivegate.output.explanations import by_urgency, unjudged_in_words
from drivegate.output.rerun import PLACES, check_command, replay_command
from drivegate.output.wording import drive_in_words
from drivegate.results.result import (
    NEVER_JUDGED,
    NOT_WITNESSED,
    RESULT_SCHEMA,
    alteration_of,
    counted_levels,
)
from drivegate.results.waivers import DAY_VARIABLE, present_day
from drivegate_reports.page.page import LONGEST_BLOCK, LONGEST_TEXT, clean, require_document

MOST_FAULTS: Final = 20


def printable(section: Mapping[str, Any]) -> dict[str, Any]:
    return {
        key: clean(item, LONGEST_BLOCK if key == "traceback" else LONGEST_TEXT)
        if isinstance(item, str)
        else [clean(name) for name in item]
        if key == "evidence_for"
        else item
        for key, item in section.items()
    }


def page_values(document: Mapping[str, Any]) -> dict[str, Any]:
    """Prepare a result document for the page: its sections with printable texts, and what they mean in sentences."""
    require_document(document, "check", RESULT_SCHEMA, "the result")
    times: Mapping[str, Any] = document.get("timing", {})
    if DAY_VARIABLE in os.environ:
        # Where the date is settled, it alone is shown, so that equal results give equal pages.
        times = {"day": present_day().isoformat()}
    checks = by_urgency([printable(_with_timed_numbers(check, times)) for check in document["checks"]])
    counted = counted_levels(document.get("fail_on"))
    failing = [check["id"] for check in checks if check["verdict"] == "fail" and check["level"] in counted]
    broken = [check for check in checks if check["counterexample"] is not None]
    lists = ("faults", "infeasible", "baseline")
    sections = {key: [printable(entry) for entry in document.get(key) or ()] for key in lists}
    result = (
        printable(document) | {"candidate": printable(document["candidate"]), "checks": checks} | sections
    )
    return {
        "result": result,
        "drive_in_words": clean(drive_in_words(document["drive"]) if document.get("drive") else ""),
        "meaning": " ".join([_meaning(result["verdict"], failing), *_causes(document)]).strip(),
        "alteration": alteration_of(document),
        "failing": failing,
        "rests_on": _rests_on(document, checks),
        "next_step": clean(_next_step(document, failing)),
        "broken": [check for check in broken if check["verdict"] not in ("contested", NOT_WITNESSED)],
        "contested": [check for check in broken if check["verdict"] == "contested"],
        "unwitnessed": [check for check in broken if check["verdict"] == NOT_WITNESSED],
        "met": [
            check for check in checks if check["counterexample"] is None and check["scenario"] is not None
        ],
        "provenance": _provenance(document, times),
        "faults": sections["faults"][:MOST_FAULTS],
        "check_of": {check["id"]: check for check in checks},
    }


def _with_timed_numbers(check: Mapping[str, Any], times: Mapping[str, Any]) -> dict[str, Any]:
    """Take the numbers of a check that depends on the machine from the times."""
    timed = times.get("checks", {}).get(check["id"], {})
    return {**check, **timed} if check["margin"] is None else dict(check)


def _meaning(verdict: str, failing: Sequence[str]) -> str:
    meanings = {
        "pass": "Every required check is met in every run that it applies to.",
        "contested": "Every required check is met, except where no known good controller meets it in the same scenario "
        "either. Such a failure does not count; it may be a fault of drivegate.",
        NOT_WITNESSED: "A check fails, but the check of the candidate ended before known good controllers were run in "
        "the same scenario. Such a failure does not count yet.",
        "waived": "Every required check is met, but for failures that somebody answers for by a waiver.",
        "waiver expired": "A check fails whose waiver has expired.",
        "unexpectedly passes": "A check passes that has a waiver, which is to be removed.",
        "inconclusive": "Not all planned runs were made, so that the required checks could not all be judged.",
        NEVER_JUDGED: "A requirement of your own was judged on no run, so nothing shows that the candidate meets it.",
        "harness fault": "A check of the plant itself failed: the result says nothing about the candidate.",
        "exception": "The candidate raised an exception.",
        "crash": "The candidate's process died.",
        "hang": "The candidate did not answer in time.",
        "invalid output": "The candidate answered with what is no command.",
        "foreign memory": "The candidate wrote into memory that is not its own.",
        "non-deterministic": "The candidate answered the same scenario in two ways, so that the runs which are "
        "drawn here need not be those which were judged.",
    }
    if verdict == "fail" and not failing:
        return "The margin of a required check has fallen against the baseline."
    if verdict == "fail":
        return f"{'A required check fails' if len(failing) == 1 else 'Required checks fail'}: {', '.join(failing)}."
    return meanings.get(verdict, "")


def _causes(document: Mapping[str, Any]) -> list[str]:
    known = (*map(str, causes_of(document)), *likely_causes_of(document), unjudged_in_words(document))
    clauses = [clean(clause) for clause in known]
    return [f"{clause[0].upper()}{clause[1:]}." for clause in clauses if clause]


def _rests_on(document: Mapping[str, Any], checks: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    sentences = []
    for level in ("required", "advisory"):
        of_level = [check["verdict"] for check in checks if check["level"] == level]
        counts = Counter(of_level)
        listed = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
        sentences.append(f"{len(of_level)} {level} checks: {listed or 'none'}.")
    if document.get("incomplete"):
        sentences.append(f"Incomplete ({document['incomplete']}): not all that was planned was done.")
    fixed, corpus = len(document.get("fixed") or ()), int(document.get("corpus_runs") or 0)
    sentences.append(
        f"{document['runs']} runs: {fixed} fixed scenarios, {corpus} of the corpus, the others drawn with the seed "
        f"{document['seed']}."
    )
    if document.get("judged_by") == "playback":
        sentences.append(
            "Half of the shards mix the seed with the hash of the candidate's sources. Whoever knows both can make the "
            "same runs beforehand; a seed that becomes known after the controller prevents that."
        )
    sentences.append(
        f"{document['set_aside']} drawn scenarios were set aside: no controller can do what they require."
    )
    if document.get("judged_by") == "playback":
        sentences.append(
            "Judged by playback: the candidate's process gave commands and nothing else, and every margin comes from "
            "giving them to the plant again in a process that never loaded the candidate."
        )
    if document.get("isolation") is not None:
        isolated = layers_in_words(document["isolation"])
        sentences.append(f"The candidate's process was {isolated}.")
    if document["faults"]:
        sentences.append(f"{len(document['faults'])} faults of the candidate, which no waiver covers.")
    waived = [check["id"] for check in checks if check.get("waiver")]
    if waived:
        sentences.append(f"Waivers for {', '.join(waived)}.")
    return tuple(map(clean, sentences))


def _next_step(document: Mapping[str, Any], failing: Sequence[str]) -> str:
    checked_again = check_command(document)
    if failing:
        begin = first_to_mend(document)
        first = failing[0] if begin is None else clean(begin["id"])
        return replay_command(document, first, plot=True)
    if document["verdict"] == "pass" and document["effort"] != "nightly":
        return f"{checked_again} --effort nightly"
    return f"{checked_again} --effort {document['effort']} --seed {document['seed']}"


def _provenance(document: Mapping[str, Any], times: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    candidate = document["candidate"]
    entries: list[tuple[str, object]] = [
        ("candidate", candidate["name"]),
        ("specification", candidate["specification"]),
        ("kind", candidate["kind"]),
        ("hash of its sources", candidate["hash"]),
        *(
            (f"declares {key}", json.dumps(value, default=str))
            for key, value in candidate["declaration"].items()
        ),
    ]
    drive = document.get("drive") or {}
    entries += [(f"drive's {key}", value) for key, value in drive.items() if isinstance(value, str)]
    for section in (
        document.get("provenance", {}),
        {key: times[key] for key in times if key not in ("checks", PLACES)},
    ):
        for key, value in section.items():
            items = value.items() if isinstance(value, Mapping) else [("", value)]
            entries += [(f"{key} {name}".strip().replace("_", " "), item) for name, item in items]
    return tuple((clean(name), clean(value)) for name, value in entries)
