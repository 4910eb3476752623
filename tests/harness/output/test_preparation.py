"""Preparing reports while the runs of a check go on: once for each drive, and never in the way of a check."""

import sys
from types import ModuleType

import pytest

from drivegate.gate.events import CheckPlan, CheckStarted, Compiling, RunDone
from drivegate.output.report_writers import Preparation
from drivegate_cases.drive.drive_document import load_drive

RUN = RunDone(1, 2, "a scenario", "")


def plan_on(drive):
    return CheckPlan(drive, "user", "quick", 0, 1)


@pytest.fixture
def report(monkeypatch):
    """A module of a report that notes what it prepares."""
    module = ModuleType("a_report")
    exec("def write(document, folder): pass", vars(module))
    module.seen = []
    module.prepare = module.seen.append
    monkeypatch.setitem(sys.modules, module.__name__, module)
    module.write.__module__ = module.__name__
    return module


def test_a_report_is_prepared_once_for_a_drive_from_its_first_run_on(report):
    preparation = Preparation({"page": lambda: report.write})
    drive = load_drive("paper-5-phase")
    events = [CheckStarted("mine", 2, plan_on(drive)), Compiling(()), RUN, RUN]
    passed = preparation.following(events)
    assert [next(passed), next(passed)] == events[:2]
    preparation.wait()
    assert report.seen == [], "kernels must be compiled before anything else uses them"
    assert list(passed) == events[2:]
    list(preparation.following(events))
    preparation.wait()
    assert report.seen == [drive]


@pytest.mark.parametrize("broken", ["load", "prepare"])
def test_a_preparation_that_fails_is_left_to_the_report(report, broken):
    def fails(*given):
        raise ImportError("no such module")

    report.prepare = fails
    preparation = Preparation({"page": fails if broken == "load" else lambda: report.write})
    assert list(preparation.following([CheckStarted("mine", 2, plan_on(load_drive("paper-5-phase"))), RUN]))
    preparation.wait()
