"""What the tests of the reports share: result documents of a candidate that passes and of one that fails."""

from __future__ import annotations

import copy
import fcntl
import json
import os
import pickle
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, TypeVar

import pytest
from playwright.sync_api import Browser, sync_playwright
from tests.harness.made import with_hash
from tests.reports.page_names import PAGE_NAMES

from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.comparison import ComparisonRequest, PlannedRun
from drivegate.contracts.current.comparison.plan import planned_runs
from drivegate.contracts.current.figures import recorded_signals
from drivegate.contracts.duty.comparison.declaration import planned_duty_runs
from drivegate.contracts.duty.scenarios.building import torque_of, torque_scenario
from drivegate.contracts.recorded_trace import thinned
from drivegate.drives.envelope_document import envelope_of
from drivegate.drives.running import run_scenario
from drivegate.gate.recording import BehaviourPlan, RecordPlan, run_behaviour, run_recorded
from drivegate.output.result_reports import report_formats, write_result
from drivegate.results.result import finite
from drivegate.studies.campaign.folder import MANIFEST
from drivegate.studies.campaign.row import JUDGED_CHECKS
from drivegate.studies.campaign.summary import SUMMARY
from drivegate.studies.compare.compare import COMPARISON_FILE, drive_labels, write_comparison, write_tables
from drivegate.studies.compare.compared_drive import ComparedDrive
from drivegate.studies.compare.document import comparison_document
from drivegate.studies.compare.drive_comparison import drive_comparison_document
from drivegate.studies.compare.engine import Compared, labelled
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.drive_cycle import load_drive_cycle
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.controllers.current.builtin import SEARCHES
from drivegate_models.errors import InputError
from drivegate_reports.campaign import report as campaign
from drivegate_reports.comparison import drive_report
from drivegate_reports.comparison import report as comparison
from drivegate_reports.conformance.report import page

Document = dict[str, Any]
MadeT = TypeVar("MadeT")
BROWSER_OPTIONS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
DRIVE, CYCLE = load_drive("paper-5-phase"), load_drive_cycle("ece-15")
FAN = load_drive("fan-3-phase")


def _check(identifier: str, **changes: Any) -> Document:
    scenario = load_scenario("fig5-search").to_mapping()
    check = {
        "id": identifier,
        "requirement": f"The requirement of {identifier}.",
        "source": "P6",
        "subject": "candidate",
        "level": "required",
        "limit": "k1 = 5 rpm",
        "verdict": "pass",
        "margin": 0.4,
        "measured": "speed error 3 rpm",
        "runs": 12,
        "message": "speed error 3 rpm; met in all 12 runs",
        "scenario": scenario,
        "counterexample": scenario if changes.get("verdict") == "fail" else None,
    }
    return check | changes


def _document(**changes: Any) -> Document:
    document = {
        "schema": 1,
        "kind": "check",
        "candidate": {
            "name": "golden section",
            "kind": "python",
            "specification": "golden.py:Golden Section",
            "hash": "0123abcd",
            "declaration": {"profile": "outcome", "estimates_power": True},
        },
        "drive": {"name": "paper-5-phase", "kind": "half-bridge", "hash": "5eed"},
        "verdict": "pass",
        "exit_code": 0,
        "seed": 7,
        "effort": "default",
        "checks": [
            _check("PWR-1", subject="plant", source="P4"),
            _check("ADV-1", margin=1.0, source="P5"),
            _check("CNV-1"),
            _check("FLO-1", verdict="not applicable", margin=None, measured="", runs=0, scenario=None),
        ],
        "faults": [],
        "runs": 131,
        "set_aside": 4,
        "provenance": {"drivegate": "0.1.0", "packages": {"numpy": "2.0"}},
        "timing": {"started_utc": "2030-01-01T00:00:00+00:00", "seconds": 12.5, "workers": 2},
    }
    return with_hash(document | changes)


@pytest.fixture
def make_document() -> Callable[..., Document]:
    """Return the factory of result documents; keywords replace keys."""
    return _document


@pytest.fixture
def make_check() -> Callable[..., Document]:
    """Return the factory of outcomes of a check; keywords replace keys."""
    return _check


@pytest.fixture(scope="session")
def passing() -> Document:
    """Return the result of a candidate that passes."""
    return _document()


@pytest.fixture(scope="session")
def failing() -> Document:
    """Return the result of a candidate that fails two checks, one of them advisory, and has a fault."""
    failed = {
        "verdict": "fail",
        "margin": -3.2,
        "measured": "speed error 21 rpm",
        "message": "lost at 1500 rpm",
    }
    fault = {
        "kind": "exception",
        "message": "ZeroDivisionError: division by zero",
        "phase": "step",
        "error": "ZeroDivisionError",
        "traceback": "line 12, in step\n    angle = 1 / 0\n",
        "step": 2400,
        "time_s": 1.2,
        "sense": {"speed": 157.0, "phase_currents": [1.0, -1.0]},
    }
    checks = [_check("CNV-1", **failed), _check("CUR-1", **failed, level="advisory"), _check("ADV-1")]
    return _document(verdict="exception", exit_code=1, checks=checks, faults=[fault])


@pytest.fixture(scope="session")
def lock_up() -> dict[str, list[float]]:
    """Return the signals of the controller `published` in the scenario in which it locks up."""
    run = run_scenario(load_scenario("lock-up"), BuiltinController(SEARCHES["published"]), trace_every=1)
    return thinned(recorded_signals(run))


@pytest.fixture(scope="session")
def recorded(lock_up: dict[str, list[float]]) -> Document:
    """Return a result of schema 2 with margins and recordings: one check fails, another is met in the same run."""
    scenario, drive = load_scenario("lock-up").to_mapping(), load_drive("paper-5-phase")
    recording = {"trace": 0, "start_s": 6.2, "end_s": scenario["duration_s"]}
    shared = {"scenario": scenario, "recording": recording, "waiver": None}
    failed = _check(
        "CNV-1",
        **shared,
        verdict="fail",
        margin=-46.3,
        measured="speed error 236 rpm",
        message="speed error 236 rpm; fails in 2 of 4 runs",
        margins=[-46.3, -3.0, 0.1, 0.9],
        found={"margin": -46.3, "measured": "speed error 236 rpm", "size": 3, "runs": 11},
    )
    failed["counterexample"] = scenario
    met = _check("CMD-1", **shared, margin=0.0, margins=[0.0, 0.0, 1.0], found=None)
    waiver = {"reason": "a known weakness", "owner": "drives", "expires": "2030-01-01", "margin": -60.0}
    waived = _check("CNV-3", verdict="waived", margin=-2.0, margins=[-2.0], found=None, waiver=waiver)
    return _document(
        schema=2,
        verdict="fail",
        exit_code=1,
        checks=[failed, met, waived],
        traces=[lock_up],
        drive={**drive.identity(), "specification": None, "document": drive.to_mapping()},
        envelope=finite(envelope_of(drive)),
        corpus_runs=0,
        fixed=[],
        baseline=None,
    )


@pytest.fixture(scope="session")
def recorded_page(recorded: Document) -> str:
    """Return the page of the result with recordings."""
    return page(recorded)


@pytest.fixture(scope="session")
def passing_page(passing: Document) -> str:
    """Return the page of the candidate that passes."""
    return page(passing)


@pytest.fixture(scope="session")
def failing_page(failing: Document) -> str:
    """Return the page of the candidate that fails."""
    return page(copy.deepcopy(failing))


def _figures_of(planned: PlannedRun, extra_w: float, held: bool) -> dict[str, Any]:
    """What a candidate might have been measured as; seeds add the same noise to all candidates."""
    if planned.group == "cycle":
        times = [0.0, 60.0, 120.0, 194.0]
        return {
            "energy_wh": 15.0 + extra_w / 10.0,
            "distance_km": 1.0,
            "energy_wh_per_km": 15.0 + extra_w / 10.0 + 0.01 * (planned.seed or 0),
            "shaft_energy_wh": 14.0,
            "energy_wh_by_phase": {"accelerating": 8.0, "cruising": 6.5, "slowing": 0.1, "standing": 0.4},
            "current_sum_mean_a": 11.0,
            "tracking_error_rms_km_h": 0.1,
            "tracking_error_worst_km_h": 0.2 if held else -9.0,
            "outside_tolerance_s": 0.0 if held else 14.0,
            "samples": {
                "time_s": times,
                "speed_reference_km_h": [0.0, 15.0, 35.0, 0.0],
                "speed_km_h": [0.0, 15.0, 35.0 if held else 26.0, 0.0],
                "input_power_w": [0.0, 100.0, 900.0, 0.0],
                "energy_wh": [0.0, 3.0 + extra_w / 40.0, 8.0 + extra_w / 20.0, 15.0 + extra_w / 10.0],
            },
        }
    power = 1000.0 + 0.1 * (planned.seed or 0) * (1.0 + 0.01 * extra_w)
    common = {
        "held": held,
        "speed_error_rpm": 1.0 if held else 200.0,
        "speed_mean_rpm": 1000.0,
        "torque_mean_nm": 5.0,
        "input_power_w": power + extra_w,
        "current_sum_a": 30.0 + extra_w / 10.0,
        "ripple_percent": 12.0,
        "advance_deg": 40.0 + extra_w,
        "current_peak_a": 20.0,
    }
    if planned.group != "disturbances":
        return common | {"converged_after_s": 2.0}
    curve = {"time_s": [9.5, 10.0, 12.0], "speed_error_rpm": [0.0, -20.0, 0.0]}
    curve |= {"advance_deg": [40.0, 50.0, 45.0], "current_sum_a": [20.0, 40.0, 30.0]}
    recovery = {"held_before": True, "worst_error_rpm": 20.0, "recovery_s": 0.2 if held else None}
    return common | recovery | {"trajectory": curve}


def _made_up_comparison(
    names: Sequence[str] = ("thrifty", "wasteful", "loses"), *, faulted: bool = False
) -> Document:
    document = _made_up_drive(DRIVE, names, faulted=faulted).document
    assert document is not None, "there are candidates"
    return document


def _made_up_drives(
    names: Sequence[str] = ("thrifty", "wasteful", "loses"),
    *,
    drives: Sequence[DriveDocument] = (DRIVE, FAN),
    faulted: bool = False,
) -> Document:
    made = [_made_up_drive(drive, names, faulted=faulted) for drive in drives]
    timing = {"started_utc": "2030-01-01", "seconds": 1.0}
    return drive_comparison_document(drive_labels(drives), made, timing=timing)


def _made_up_drive(drive: DriveDocument, names: Sequence[str], *, faulted: bool) -> ComparedDrive:
    request = ComparisonRequest(drive, "quick", 0, CYCLE)
    plan = planned_runs(request)
    everybody = []
    for place, name in enumerate(names):
        made = Compared(name, name, resolve_candidate("initial"))
        for index, planned in enumerate(plan):
            loses = place == 2 and (planned.share == 1.0 or planned.group == "cycle")
            made.figures[index] = _figures_of(planned, 20.0 * (place == 1), not loses)
        made.timing = {"step_us": 0.1, "share_of_period_percent": 0.02, "state_bytes": 320}
        everybody.append(made)
    if faulted:
        fault = Fault(FaultKind.EXCEPTION, "ValueError: <b>no</b>", "step", traceback="line 1 <script>")
        broken = Compared("broken", "broken", resolve_candidate("initial"), faults=[fault], complete=False)
        everybody += [broken, Compared("gone", "gone", error=InputError("gone does not exist"))]
    point = {
        "feasible": True,
        "torques_nm": [4.0, 6.0],
        "edges_deg": [35.0, 35.0],
        "least_current_sums_a": [20.0, 30.0],
        "least_input_powers_w": [900.0, 1000.0],
    }
    speeds = dict.fromkeys(run.speed_rpm for run in plan if run.group == "points" and run.speed_rpm)
    best = {("point", index): point for index, planned in enumerate(plan) if planned.group == "points"}
    best |= {("envelope", speed): 1e4 / speed for speed in speeds}
    document = comparison_document(
        everybody,
        plan,
        best,
        request,
        checks=False,
        timing={"started_utc": "2030-01-01", "seconds": 1.0},
    )
    return ComparedDrive(request, plan, everybody, document)


def _made_once(
    factory: pytest.TempPathFactory, name: str, make: Callable[[Path], MadeT]
) -> tuple[Path, MadeT]:
    """Return a folder and what filling it has returned; the workers of pytest-xdist share it, and one makes it."""
    own = factory.getbasetemp()
    place = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    folder, kept = place / name, place / f"{name}.pickle"
    with (place / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not kept.exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            kept.write_bytes(pickle.dumps(make(folder)))
    return folder, pickle.loads(kept.read_bytes())


@pytest.fixture(scope="session")
def reproduction(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Document]:
    """Return the folder of a reproduction of the paper, and its document."""
    from drivegate_lab.paper.report import reproduce

    return _made_once(tmp_path_factory, "reproduction", reproduce)


@pytest.fixture(scope="session")
def made_up() -> Callable[..., Document]:
    """Return the factory of comparison documents; it takes the candidates' names."""
    return _made_up_comparison


@pytest.fixture(scope="session")
def made_up_drives() -> Callable[..., Document]:
    """Return the factory of comparisons of drives; it takes the candidates' names, and the drives."""
    return _made_up_drives


def _campaign_check(identifier: str, *, violated: bool, **changes: Any) -> Document:
    margins = [-44.0, -1.5, -0.2, 0.1] if violated else [0.0, 0.25, 0.5, 1.0]
    counted = 3 if violated else 0
    return {
        "id": identifier,
        "level": "required",
        "subject": "candidate",
        "requirement": f"The requirement of {identifier}, with half to twice the resistance.",
        "limit": "k1 = 5 rpm",
        "violations": counted,
        "runs": 4,
        "probability": counted / 4,
        "interval": [0.194, 0.994] if violated else [0.0, 0.602],
        "advisory_runs": 0,
        "margin_quantiles": [margins[0], margins[0], margins[0], margins[0], margins[1]],
        "margins": margins,
        "worst_run": 3,
        "worst_margin": margins[0],
        "counterexample": f"counterexamples/mine/{identifier}.json" if violated else None,
        "worst_scenario": None if violated else "worst/run-000003.json",
        "worst_case": "fig5-search",
        "worst_parameters": {"load_share": 0.5, "resistance": 1.01013, "friction_added_n_m": 0.178147},
        "worst_measured": "CNV-1: speed error 225.2 rpm at 1500 rpm" if violated else "",
    } | changes


def _campaign_candidate(name: str, *, fails: bool, **changes: Any) -> Document:
    violated = {"violations": 3, "runs": 4, "probability": 0.75, "interval": [0.194, 0.994]}
    met = {"violations": 0, "runs": 4, "probability": 0.0, "interval": [0.0, 0.602]}
    return {
        "name": name,
        "kind": "python",
        "hash": "0123abcd",
        "verdicts": {"fail": 3, "pass": 1} if fails else {"pass": 4},
        "set_aside": 0,
        "not_passed": violated if fails else met,
        "checks": [
            _campaign_check(check, violated=fails and check == "ROB-1") for check in JUDGED_CHECKS["current"]
        ],
        "first_faults": [],
    } | changes


def _made_up_campaign() -> Document:
    return {
        "schema": 1,
        "kind": "campaign summary",
        "campaign": "spread of a batch",
        "seed": 7,
        "runs": 8,
        "confidence": 0.95,
        "quantiles": [0.0, 0.01, 0.05, 0.25, 0.5],
        "candidates": [
            _campaign_candidate("mine", fails=True),
            _campaign_candidate("reference", fails=False),
        ],
        "specifications": ["/home/mine/my drives/mine.py:Mine", "reference"],
    }


@pytest.fixture
def campaign_document() -> Document:
    """Return the summary of a campaign in which one candidate fails and another does not."""
    return _made_up_campaign()


@pytest.fixture(scope="session")
def duty_result() -> Document:
    """Return the result of field-oriented control on a PM AC drive, with one check, its run, and how it behaves."""
    drive = load_drive("pm-ac-surface").replaced(settling_s=0.3)
    assert isinstance(drive, PmAcDocument)
    loaded = own_candidate(resolve_candidate("foc"))
    scenario = torque_scenario(drive, 165.0, [torque_of(drive, 165.0, share) for share in (0.0, 0.5, 0.3)])
    kept = run_recorded(loaded, RecordPlan(scenario.to_mapping(), ("STP-1",)))
    window = dict(zip(("start_s", "end_s"), kept.windows["STP-1"], strict=True))
    step = {
        "source": "the contract",
        "measured": "overshoot 7 %",
        "scenario": scenario.to_mapping(),
        "recording": {"trace": 0, **window},
    }
    document: Document = json.loads(
        json.dumps(
            _document(
                candidate=_document()["candidate"]
                | {"name": "foc", "kind": "builtin", "specification": "foc"},
                drive=drive.identity() | {"specification": "pm-ac-surface", "document": drive.to_mapping()},
                envelope=None,
                checks=[_check("STP-1", **step)],
                traces=[kept.columns],
                behaviour=finite(run_behaviour(loaded, BehaviourPlan(drive, scenario.to_mapping()))),
            )
        )
    )
    return document


def _made_up_duty_comparison() -> Document:
    """Make a comparison of controllers of duty ratios from figures that nobody measured."""
    drive = load_drive("pm-ac-surface")
    assert isinstance(drive, PmAcDocument)
    request = ComparisonRequest(drive, "quick", 0, CYCLE)
    plan, made = planned_duty_runs(request), labelled(("foc", "foc-mtpa"), ("foc", "foc-mtpa"))
    for number, one in enumerate(made):
        one.candidate = resolve_candidate(one.specification)
        for index, planned in enumerate(plan):
            speed = planned.scenario.speed_rpm[0][1]
            rows = [_made_up_duty_row(speed, torque, number) for torque in (1.0, 2.0)]
            one.figures[index] = {planned.group: rows}
    document: Document = json.loads(
        json.dumps(comparison_document(made, plan, {}, request, checks=False, timing={"seconds": 1.0}))
    )
    return document


def _made_up_duty_row(speed: float, torque: float, number: int) -> Document:
    return {
        "speed_rpm": speed,
        "reference_nm": torque,
        "torque_nm": torque,
        "held": number == 0 or speed < 600.0,
        "direct_current_a": -1.0,
        "quadrature_current_a": 2.0,
        "current_above_least_percent": 1.0 + number,
        "input_power_w": 130.0,
        "loss_w": 10.0,
        "least_loss_w": 9.0,
        "loss_above_least_percent": 11.1,
        "efficiency_percent": 90.0,
        "voltage_percent": 50.0,
        "ripple_percent": 1.5,
        "before_nm": 0.0,
        "after_nm": torque,
        "overshoot_percent": 7.0,
        "rise_ms": None if number else 0.9,
        "allowed_ms": 1.2,
    }


@pytest.fixture(scope="session")
def duty_comparison() -> Document:
    """Return the document of a comparison of controllers of duty ratios."""
    return _made_up_duty_comparison()


@pytest.fixture(scope="session")
def browser(browser_path: str) -> Iterator[Browser]:
    """Open a browser."""
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=browser_path, args=BROWSER_OPTIONS)
        yield opened
        opened.close()


@pytest.fixture(scope="session")
def pages(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> dict[str, Path]:
    """Return each page that is written."""
    _, written = _made_once(tmp_path_factory, "pages", lambda folder: _write_pages(folder, request))
    return written


def _write_pages(folder: Path, request: pytest.FixtureRequest) -> dict[str, Path]:
    conformance = folder / "conformance"
    conformance.mkdir()
    recorded, duty_result = (request.getfixturevalue(name) for name in ("recorded", "duty_result"))
    page = write_result(recorded, conformance, report_formats(["conformance"])).pages["conformance"]
    duty, ratios = folder / "duty", folder / "ratios"
    duty.mkdir()
    ratios.mkdir()
    write_comparison(_made_up_duty_comparison(), ratios).require_all()
    document = json.loads(json.dumps(_made_up_comparison(faulted=True)))
    write_tables(document, folder)
    (folder / COMPARISON_FILE).write_text(json.dumps(document), encoding="utf-8")
    across = json.loads(json.dumps(_made_up_drives(faulted=True)))
    drives = folder / "drives"
    drives.mkdir()
    write_comparison(across, drives).require_all()
    summary = _made_up_campaign()
    for name in (SUMMARY, MANIFEST):
        (folder / name).write_text(json.dumps(summary), encoding="utf-8")
    pages = {
        "conformance": conformance / page,
        "duty": duty / write_result(duty_result, duty, report_formats(["conformance"])).pages["conformance"],
        "ratios": ratios / comparison.REPORT_FILE,
        "comparison": comparison.write(document, folder),
        "drives": drives / drive_report.REPORT_FILE,
        "campaign": campaign.write(summary, folder),
    }
    if "reproduction" in PAGE_NAMES:
        reproduced, document = request.getfixturevalue("reproduction")
        pages["reproduction"] = reproduced / document["page"]
    return pages
