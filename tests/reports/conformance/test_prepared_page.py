"""A page that was prepared while its candidate was checked: the same bytes, from what is known already."""

from __future__ import annotations

import gc
from typing import Any

import pytest

from drivegate_reports.conformance import behaviour, drive
from drivegate_reports.conformance.coverage import drive_of
from drivegate_reports.conformance.report import page, prepare
from drivegate_reports.page.style import house_style

KEPT = (drive._drawn, behaviour._trajectories)


@pytest.mark.nightly
def test_what_depends_on_the_drive_alone_is_not_made_again(recorded: Any, duty_result: Any) -> None:
    for document in (recorded, duty_result):
        for kept in KEPT:
            kept.cache_clear()
        unprepared = page(document)
        for kept in KEPT:
            kept.cache_clear()
        prepare(drive_of(document))
        made = [kept.cache_info().misses for kept in KEPT]
        assert page(document) == unprepared
        assert [kept.cache_info().misses for kept in KEPT] == made


def test_drawing_leaves_no_object_out_of_reach_of_the_collector() -> None:
    with pytest.raises(KeyError), house_style():
        raise KeyError
    assert gc.get_freeze_count() == 0
