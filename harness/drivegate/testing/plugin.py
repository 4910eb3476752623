"""The pytest plugin: the options, the items and the fixture of `drivegate.conformance_tests`.

pytest imports this module in every run, so nothing heavy is imported before a test requires it.
"""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Final
from urllib.parse import quote

import pytest

from drivegate.testing.conformance import CANDIDATE_ITEM, MARKER, Conformance, Judged

if TYPE_CHECKING:
    from drivegate.candidates.candidate import Candidate
    from drivegate.gate.events import Event
    from drivegate_cases.drive.drive_document import DriveDocument

FIXTURE: Final = "conformance"


@dataclass(frozen=True)
class _Request:
    """What is checked; the key under which a session keeps its results."""

    candidate: str
    drive: str | None
    effort: str
    seed: int
    corpus: Path | None
    waivers: Path | None


_JUDGED: Final = pytest.StashKey[dict[_Request, Judged]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options, which win over the arguments of the decorator."""
    group = parser.getgroup("drivegate", "conformance of a drive's controller")
    group.addoption(
        "--drivegate-candidate", metavar="CANDIDATE", help="candidate, as `drivegate check` has it"
    )
    group.addoption(
        "--drivegate-drive",
        metavar="NAME|FILE",
        help="drive that it is judged on, as `drivegate check` has it",
    )
    group.addoption("--drivegate-effort", metavar="EFFORT", help="quick, default or nightly")
    group.addoption("--drivegate-seed", metavar="N", type=int, help="seed of the search")
    group.addoption(
        "--drivegate-output",
        metavar="DIR",
        type=Path,
        help="folder of results and counterexamples; by default in pytest's cache",
    )


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers", f"{MARKER}: one item for each of drivegate's checks; set by its decorator"
    )
    config.stash[_JUDGED] = {}
    from drivegate.output.streams import guard_log

    guard_log()


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Keep what a manifest, a drive or its path says out of the commands of a CI server."""
    report = yield
    _make_harmless(report)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Keep what a candidate says out of the commands of a CI server."""
    report = yield
    if item.get_closest_marker(MARKER) is not None:
        _make_harmless(report)
    return report


def _make_harmless(report: pytest.CollectReport | pytest.TestReport) -> None:
    """Replace the texts of a report in which a terminal or a CI server would obey something."""
    from drivegate.output.streams import harmless

    if isinstance(report.longrepr, tuple):
        path, line, reason = report.longrepr
        report.longrepr = (path, line, harmless(reason))
    elif report.longrepr is not None:
        text = str(report.longrepr)
        # Otherwise pytest shows it in colours.
        if harmless(text) != text:
            report.longrepr = harmless(text)
    report.sections = [(title, harmless(text)) for title, text in report.sections]


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Make one item for the candidate and one for each check."""
    marker = metafunc.definition.get_closest_marker(MARKER)
    if marker is None:
        return
    if FIXTURE not in metafunc.fixturenames:
        raise _refused(
            f"{metafunc.function.__name__} must take the argument '{FIXTURE}' and call its verify()"
        )
    from drivegate.contracts.catalogue import checks_of
    from drivegate.drives.kinds import drive_for
    from drivegate_models.errors import InputError

    try:
        requested = _requested(metafunc.config, marker, metafunc.definition.path.parent)
        candidate, _ = _planned(requested)
        drive = drive_for(candidate, _named_drive(requested))
        checks = checks_of(drive, candidate.declaration)
    except InputError as error:
        raise _refused(str(error)) from error
    metafunc.parametrize(FIXTURE, [CANDIDATE_ITEM, *(check.id for check in checks)], indirect=True)


@pytest.fixture
def conformance(request: pytest.FixtureRequest) -> Conformance:
    """Return one check of the candidate; see `drivegate.conformance_tests`."""
    marker = request.node.get_closest_marker(MARKER)
    if marker is None:
        pytest.fail(
            "the fixture 'conformance' needs the decorator drivegate.conformance_tests", pytrace=False
        )
    requested = _requested(request.config, marker, request.node.path.parent)
    judged = request.config.stash[_JUDGED]
    if requested not in judged:
        taken = {earlier.folder for earlier in judged.values()}
        judged[requested] = _judge(requested, _output(request), taken)
    return Conformance(request.param, judged[requested])


def _requested(config: pytest.Config, marker: pytest.Mark, folder: Path) -> _Request:
    """Put options over arguments."""
    given = dict(marker.kwargs)
    for name in ("corpus", "waivers"):
        given[name] = None if given[name] is None else folder / given[name]
    for name in ("candidate", "drive"):
        if given[name] is not None:
            given[name] = _from_folder(given[name], folder)
    for name in ("candidate", "drive", "effort", "seed"):
        option = config.getoption(f"--drivegate-{name}")
        given[name] = given[name] if option is None else option
    if given["candidate"] is None:
        raise _refused(
            "conformance_tests() names no candidate; give it one, or call pytest with "
            "--drivegate-candidate CANDIDATE"
        )
    return _Request(**given)


def _from_folder(candidate: str, folder: Path) -> str:
    """Let a file's path start from a folder."""
    from drivegate.candidates.kinds import WHOLE_FILE_SUFFIXES

    source, _, attribute = candidate.rpartition(":")
    if source.endswith(".py"):
        return f"{folder / source}:{attribute}"
    is_file = candidate.endswith((*WHOLE_FILE_SUFFIXES, ".json"))
    return str(folder / candidate) if is_file else candidate


def _named_drive(requested: _Request) -> DriveDocument | None:
    from drivegate_cases.drive.drive_document import load_drive

    return None if requested.drive is None else load_drive(requested.drive)


def _planned(requested: _Request) -> tuple[Candidate, Iterator[Event]]:
    """Plan a check; bad input is refused, none of the candidate's code runs."""
    from drivegate.candidates.resolution import resolve_candidate
    from drivegate.gate.engine import check_candidate
    from drivegate.gate.options import CheckOptions
    from drivegate.results.counterexample import read_corpus
    from drivegate.results.waivers import read_waivers

    candidate = resolve_candidate(requested.candidate)
    options = CheckOptions(
        drive=_named_drive(requested),
        drive_named=requested.drive,
        effort=requested.effort,
        seed=requested.seed,
        corpus=() if requested.corpus is None else read_corpus(requested.corpus),
        waivers=() if requested.waivers is None else read_waivers(requested.waivers, [candidate.name]),
    )
    events = check_candidate(candidate, options)
    # The engine refuses its options before it reports that it has started, and works only afterwards.
    return candidate, chain([next(events)], events)


def _refused(sentence: str) -> Exception:
    return pytest.Collector.CollectError(f"drivegate: {sentence}")


def _output(request: pytest.FixtureRequest) -> Path:
    """Choose the folder of all results, one for each process of pytest-xdist."""
    config = request.config
    given: Path | None = config.getoption("--drivegate-output")
    if given is not None:
        folder = config.invocation_params.dir / given
    elif config.pluginmanager.has_plugin("cacheprovider"):
        folder = config.cache.mkdir("drivegate")
    else:
        folder = request.getfixturevalue("tmp_path_factory").mktemp("drivegate")
    return folder / os.environ.get("PYTEST_XDIST_WORKER", "")


def _free_folder(output: Path, candidate: Candidate, requested: _Request, taken: set[Path]) -> Path:
    """Choose the folder of one result; the same one in the next session."""
    name = quote(candidate.name, safe=":")[:80]
    places = (
        output / f"{name}-{requested.effort}-{requested.seed}{suffix}"
        for suffix in ("", *(f"-{number}" for number in range(2, len(taken) + 2)))
    )
    return next(place for place in places if place not in taken)


def _judge(requested: _Request, output: Path, taken: set[Path]) -> Judged:
    """Check the candidate, and keep its result and counterexamples."""
    from drivegate.output.event_loop import finished
    from drivegate.output.failure import complain, failure_of
    from drivegate.output.progress import Display
    from drivegate.output.report_folder import ReportFolder
    from drivegate.output.result_reports import write_result

    try:
        candidate, events = _planned(requested)
        place = _free_folder(output, candidate, requested, taken)
        with ReportFolder(place) as folder:
            document = finished(events, Display()).written()
            write_result(document, folder.staging, {})
            folder.commit()
    except Exception as error:
        # Every item reports it, and none tries again.
        failure = failure_of(error)
        complain(failure, error)
        return Judged(requested.candidate, None, output, failure.message)
    return Judged(requested.candidate, document, place)
