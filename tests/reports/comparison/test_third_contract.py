"""A contract that nobody knows but its own declaration is ranked, tabulated, printed and drawn like any other."""

from __future__ import annotations

import io
import json
from typing import Any

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.comparison import (
    DRIVE_POINT,
    HELD,
    POINTS,
    RANKING,
    Comparison,
    ComparisonRequest,
    Figure,
    PlannedRun,
    Ranking,
    RunTable,
    Section,
    mean_of,
    name_of,
)
from drivegate.contracts.drawings import MarkPanel, RowMarks
from drivegate.contracts.duty.contract import DUTY
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.output.console import console_for
from drivegate.studies.compare.compared_drive import ComparedDrive
from drivegate.studies.compare.display import show_comparison
from drivegate.studies.compare.document import comparison_document
from drivegate.studies.compare.drive_comparison import drive_comparison_document
from drivegate.studies.compare.engine import labelled
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.drive_cycle import load_drive_cycle
from drivegate_reports.comparison import drive_report
from drivegate_reports.comparison.report import page

NOISE = Figure("noise_db", "noise", "dB", 1, above="noise_above_{}_db")


def point_of(row: dict[str, Any], speed_rpm: float) -> dict[str, Any]:
    values = (1.0, 50.0, speed_rpm, 1.0, row["held"], speed_rpm, 1.0, 100.0, 5.0, 2.0)
    return dict(zip(DRIVE_POINT, values, strict=True))


TOY = Comparison(
    kind="toy-comparison",
    plan=lambda request: (),
    measure=lambda planned, record: {},
    tables=(
        RunTable(
            name=POINTS,
            groups=("points",),
            rows=lambda planned, figures, best: [{"speed_rpm": planned.speed_rpm, "load_nm": 1.0} | figures],
            columns=(name_of("candidate"), Figure("speed_rpm", "speed", "rpm", 0), HELD, NOISE),
        ),
    ),
    curves={},
    ranking=Ranking(
        rule="most points held, then least noise.",
        decides="noise_db",
        place=("speed_rpm", "load_nm"),
        count="points",
        summaries={POINTS: {"noise_mean_db": ("noise_db", mean_of)}},
        costs=(NOISE,),
        columns=(Figure("noise_mean_db", "mean noise", "dB", 1),),
        caption=lambda first: f"Noise next to that of {first}.",
        standing=lambda row: [f"makes {row['noise_mean_db']:.0f} dB"],
    ),
    facts=lambda request, plan: {"drive": {}, "size": {}},
    supply_voltage_v=lambda drive: 48.0,
    drive_points=lambda request, plan, figures: (
        point_of(row, plan[index].speed_rpm or 0.0) for index, row in figures.items()
    ),
    sections=(
        RANKING,
        Section(
            name="noise",
            title="Noise",
            table=POINTS,
            drawings=(
                RowMarks(
                    name="noise",
                    title="Noise by speed",
                    caption="Less is better.",
                    table=POINTS,
                    load="load_nm",
                    load_label="load (N·m)",
                    panels=(MarkPanel("noise (dB)", "noise_db"),),
                ),
            ),
        ),
    ),
    method=lambda document: ("A microphone at 1 m.",),
    shown_facts=lambda document: (("room", "anechoic"),),
)


def compared(name: str) -> ComparedDrive:
    drive = load_drive(name)
    assert isinstance(drive, PmAcDocument)
    request = ComparisonRequest(drive, "quick", 0, load_drive_cycle("ece-15"))
    plan = tuple(
        PlannedRun("points", f"{speed:g} rpm", torque_scenario(drive, speed, (0.0, 1.0)), speed_rpm=speed)
        for speed in (100.0, 200.0)
    )
    made = labelled(("loud", "calm"), ("loud", "calm"))
    for place, one in enumerate(made):
        one.candidate = resolve_candidate("foc")
        one.figures = {index: {"held": True, "noise_db": 60.0 - 20.0 * place} for index in range(2)}
    document = comparison_document(made, plan, {}, request, checks=False, timing={"seconds": 1.0})
    return ComparedDrive(request, plan, made, document)


@pytest.fixture(autouse=True)
def toy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the drives of duty ratios take controllers that are compared by their noise."""
    monkeypatch.setattr(type(DUTY), "comparison", lambda _self: TOY)


def test_it_is_ranked_and_shown_by_its_own_figures() -> None:
    document = json.loads(json.dumps(compared("pm-ac-surface").document))
    assert document["kind"] == "toy-comparison"
    ranking = document["tables"]["ranking"]
    assert [(row["candidate"], row["rank"], row["noise_mean_db"]) for row in ranking] == [
        ("calm", 1, 40.0),
        ("loud", 2, 60.0),
    ]
    assert ranking[1]["noise_above_first_db"] == 20.0
    stream = io.StringIO()
    show_comparison(console_for(stream), document, ())
    assert "mean noise (dB)" in stream.getvalue()
    text = page(document)
    assert "holds all 2 operating points and makes 40 dB." in text
    assert "takes 20.0 dB more noise (+50.0 %) over the 2 points that both hold." in text
    assert '<figure class="card" id="figure-noise"' in text
    for words in ("Noise next to that of calm.", "A microphone at 1 m.", "anechoic"):
        assert words in text


def test_its_drives_are_put_side_by_side() -> None:
    made = [compared(name) for name in ("pm-ac-surface", "pm-ac-interior")]
    document = drive_comparison_document(("surface", "interior"), made, timing={"seconds": 1.0})
    assert [row["supply_voltage_v"] for row in document["tables"]["drives"]] == [48.0, 48.0]
    assert [row["points_shared"] for row in document["tables"]["summary"]] == [2] * 4
    assert "surface and interior under the same controllers" in drive_report.page(document)
