"""The gallery of faults: ``python docs/gallery.py`` runs its counterexamples; with ``--search`` it finds them first.

Each fault changes a few lines of the template ``embedded-coder``, or is a faulty controller that is included. The page
has the lines, the measured value and the figure of one run of the counterexample in ``docs/gallery``.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import unified_diff
from pathlib import Path
from shutil import copyfile, copytree
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

import numpy as np

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.margin import Mark, Moment
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import check_of, contract_of
from drivegate.contracts.drawings import TIME
from drivegate.contracts.recorded_trace import deciding_moment
from drivegate.drives.running import recorded
from drivegate.output.panels import MomentTime, draw_moment
from drivegate.results.counterexample import read_counterexample
from drivegate.scenarios.facts import facts_in_short
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS
from drivegate_lab.candidates.sensorless_faults import SENSORLESS_FAULTS
from drivegate_reports.page.style import house_style, new_figure, svg_document

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drivegate.checks.check import Record
    from drivegate.contracts.contract import Columns

DOCS: Final = Path(__file__).parent
PAGE: Final = DOCS / "gallery.md"
TEMPLATE: Final = DOCS.parent / "harness" / "drivegate" / "templates" / "new" / "embedded-coder"
MODEL: Final = Path("model") / "controller.c"
INCLUDED: Final = {**DUTY_FAULTS, **SENSORLESS_FAULTS}
"""Faulty controllers that are included."""
BEGIN, END = "<!-- gallery: begin -->", "<!-- gallery: end -->"


@dataclass(frozen=True)
class Fault:
    """One fault: lines of the template's model, what they become, and the check that fails."""

    title: str
    check: str
    changes: tuple[tuple[str, str], ...]
    column: str = ""
    """What the figure shows of the whole run, where the check states no deciding moment."""
    reference: str = ""
    """Column whose last value the figure marks then."""
    included: str = ""
    """A faulty controller that is included, in place of changed lines."""
    drive: str = "pm-ac-interior"
    """The drive on which its counterexample is searched."""

    @property
    def counterexample(self) -> Path:
        """Its file; a controller that knows of no link is not run in those of included ones."""
        return DOCS / "gallery" / ("included" if self.included else "") / f"{self.check}.json"

    @property
    def figure(self) -> Path:
        """The file of its figure."""
        return DOCS / "images" / f"gallery-{self.check}.svg"

    def model(self) -> str:
        """The template's model with the fault."""
        text = (TEMPLATE / MODEL).read_text(encoding="utf-8")
        for right, wrong in self.changes:
            if text.count(right) != 1:
                raise ValueError(f"the template has {text.count(right)} times: {right}")
            text = text.replace(right, wrong)
        return text

    def words(self) -> list[str]:
        """The lines of the model that the fault changes, as a diff, or what the included controller does."""
        if self.included:
            fault = INCLUDED[self.included]
            return [f"`faulty:{fault.name}`, the included `{fault.base}` with one change: {fault.sentence}"]
        return ["```diff", *self.lines(), "```"]

    def lines(self) -> list[str]:
        """The lines of the model that the fault changes, as a diff."""
        right = (TEMPLATE / MODEL).read_text(encoding="utf-8").splitlines()
        changed = list(unified_diff(right, self.model().splitlines(), n=0, lineterm=""))[2:]
        return [f"{line[0]} {line[1:].strip()}" for line in changed if not line.startswith("@@")]

    def candidate(self, folder: Path) -> str:
        """Return the name of its candidate, written into a folder if it is no included one."""
        return f"faulty:{self.included}" if self.included else str(self.write_candidate(folder))

    def write_candidate(self, folder: Path) -> Path:
        """Write the template with the fault into a folder; return its manifest."""
        copytree(TEMPLATE, folder, dirs_exist_ok=True)
        (folder / MODEL).write_text(self.model(), encoding="utf-8")
        manifest = folder / "candidate.toml"
        # Its files of waivers and the like are those of all templates, and none of them is needed here.
        text, _, _ = manifest.read_text(encoding="utf-8").partition("\n[check]")
        manifest.write_text(text.replace("@name@", self.check.lower() or "sound"), encoding="utf-8")
        return manifest


FAULTS: Final = (
    Fault(
        "The delay is compensated in the wrong direction",
        "FWK-3",
        (("    angle += electrical * rtP.Lead;\n", "    angle -= electrical * rtP.Lead;\n"),),
    ),
    Fault(
        "A sign of the decoupling is wrong",
        "DEC-1",
        (
            (
                "rtDW.DirectIntegral - electrical * rtP.QuadratureInductance * quadrature;",
                "rtDW.DirectIntegral + electrical * rtP.QuadratureInductance * quadrature;",
            ),
        ),
    ),
    Fault(
        "Each axis has the whole current limit",
        "OVC-1",
        (
            (
                "    real32_T headroom = rtP.CurrentLimit * rtP.CurrentLimit - direct * direct;\n",
                "    real32_T headroom = rtP.CurrentLimit * rtP.CurrentLimit;\n",
            ),
            (
                "    headroom = sqrtf(rtP.CurrentLimit * rtP.CurrentLimit - direct_error * direct_error);\n",
                "    headroom = rtP.CurrentLimit;\n",
            ),
        ),
    ),
    Fault(
        "There is no zero sequence",
        "RIP-4",
        (
            (
                "0.5F + (phases[leg] - 0.5F * (highest + lowest)) / supply;",
                "0.5F + phases[leg] / supply;",
            ),
        ),
    ),
    Fault(
        "The d current is zero on a salient machine",
        "MTP-1",
        (("    if (saliency < 1e-3F * rtP.DirectInductance) return 0.0F;\n", "    return 0.0F;\n"),),
        "direct_current_a",
    ),
    Fault(
        "Weakening never returns",
        "FWK-2",
        (
            (
                "rtP.WeakeningStep * (0.5F * (1.0F + VOLTAGE_SHARE) * limit - used)",
                "rtP.WeakeningStep * fminf(0.5F * (1.0F + VOLTAGE_SHARE) * limit - used, 0.0F)",
            ),
        ),
        "direct_current_a",
    ),
    Fault(
        "Weakening uses the sign of the speed",
        "FWK-1",
        (
            (
                "direct_for(fminf(fabsf(torque), rtP.GreatestTorque), turning, allowed)",
                "direct_for(fminf(fabsf(torque), rtP.GreatestTorque), electrical, allowed)",
            ),
        ),
        "torque_nm",
    ),
    Fault(
        "The current regulators wind up",
        "STP-1",
        (
            (
                "(direct_error + (direct_given - direct_wanted) / rtP.DirectGain)",
                "direct_error",
            ),
            (
                "(quadrature_error + (quadrature_given - quadrature_wanted) / rtP.QuadratureGain)",
                "quadrature_error",
            ),
        ),
    ),
    Fault(
        "The speed regulator winds up",
        "ROB-4",
        (
            (
                "    if (!rtP.RegulatesTorque && fabsf(torque) > possible && torque * error > 0.0F)\n"
                "        rtDW.SpeedIntegral -= rtP.SpeedStep * error;\n",
                "",
            ),
        ),
    ),
    Fault(
        "Weakening ends with the torque",
        "ACC-1",
        (
            (
                "    direct_error = fmaxf(direct_error, rtP.DeepestDirect);\n",
                "    direct_error = torque == 0.0F ? 0.0F : fmaxf(direct_error, rtP.DeepestDirect);\n",
            ),
        ),
        "torque_nm",
        "torque_reference_nm",
    ),
    Fault(
        "Braking as if the link were ideal",
        "LNK-1",
        (),
        "link_highest_v",
        included="link-taken-for-ideal",
        drive="pm-ac-servo-48v",
    ),
    Fault(
        "Derating of the q current alone",
        "THM-2",
        (),
        "winding_temperature_c",
        included="torque-alone-derated",
        drive="pm-ac-hub",
    ),
    Fault(
        "An observer without the resistance",
        "SLS-1",
        (),
        included="observer-without-resistance",
        drive="pm-ac-2kw-sensorless",
    ),
)


SOUND: Final = Fault("The template as it is written", "", ())


def search(fault: Fault) -> None:
    """Check a faulty controller, and keep its counterexample."""
    with TemporaryDirectory() as folder:
        candidate, report = fault.candidate(Path(folder) / "candidate"), Path(folder) / "report"
        subprocess.run(
            [
                *(sys.executable, "-m", "drivegate", "check", candidate, "--only", fault.check),
                *("--drive", fault.drive, "--effort", "quick", "--output", report, "--quiet"),
            ],
            check=False,
            stdout=subprocess.DEVNULL,
        )
        fault.counterexample.parent.mkdir(exist_ok=True)
        copyfile(report / "counterexamples" / f"{fault.check}.json", fault.counterexample)


def shown(fault: Fault) -> tuple[str, Figure]:
    """Run the counterexample of a fault; return its section of the page and its figure."""
    found = read_counterexample(fault.counterexample)
    assert isinstance(found.scenario, Scenario)
    record, healthy = _run(fault, found.scenario), _run(_sound(fault), found.scenario)
    check, contract = check_of("duty", fault.check), contract_of(found.scenario.drive)
    margin = check.evaluate(record)
    assert margin is not None
    assert margin.value < 0.0, f"{fault.check} is met"
    columns = contract.recorded_signals(record.run)
    moment = deciding_moment(check, record, margin)
    if fault.column:
        levels = (Mark(words="reference", value=columns[fault.reference][-1]),) if fault.reference else ()
        moment = Moment(start_s=0.0, end_s=columns[TIME][-1], column=fault.column, levels=levels)
    figure, (panel,) = new_figure(2.2, 1)
    sound = None if fault.column else check.moment(healthy)
    _draw_sound(panel, moment, sound, contract.recorded_signals(healthy.run))
    draw_moment(panel, moment, columns, contract.panels_of(found.scenario))
    return "\n".join(_section(fault, margin.measured, facts_in_short(found.scenario.to_mapping()))), figure


def _sound(fault: Fault) -> Fault | str:
    """Return what has the fault not: the template, or the name of an included controller."""
    return INCLUDED[fault.included].base if fault.included else SOUND


def _run(fault: Fault | str, scenario: Scenario) -> Record:
    """Run a fault, or an included controller by its name, in a scenario."""
    with TemporaryDirectory() as folder:
        name = fault if isinstance(fault, str) else fault.candidate(Path(folder))
        loaded = own_candidate(resolve_candidate(name))
        return recorded(loaded, scenario, loaded.controller())


def _draw_sound(panel: Axes, moment: Moment, sound: Moment | None, columns: Columns) -> None:
    axis, lines = MomentTime(moment), []
    if moment.column:
        rows = (columns[TIME] >= moment.start_s) & (columns[TIME] <= moment.end_s)
        lines = [(columns[TIME][rows], columns[moment.column][rows])]
    elif sound is not None:
        lines = [(np.array(course.time_s), np.array(course.values)) for course in sound.courses]
    for number, (time, values) in enumerate(lines):
        name = "_" if number else "without the fault"
        panel.plot(axis.factor * (time - axis.origin), values, color="0.6", linewidth=1.2, label=name)
    panel.legend(loc="lower left", bbox_to_anchor=(0.0, 0.98), fontsize=8, frameon=False)


def _section(fault: Fault, measured: str, facts: str) -> list[str]:
    return [
        f"## {fault.title}",
        "",
        *fault.words(),
        "",
        f"[`{fault.check}`](checks/{fault.check}.md): {measured}",
        "",
        f"[Counterexample]({fault.counterexample.relative_to(DOCS).as_posix()}): {facts}",
        "",
        f"![{fault.check}](images/{fault.figure.name})",
        "",
    ]


def main(arguments: Sequence[str]) -> int:
    """Write the page and its figures."""
    if list(arguments) not in ([], ["--search"]):
        sys.stderr.write("usage: python docs/gallery.py [--search]\n")
        return 2
    sections = []
    for fault in FAULTS:
        if arguments:
            search(fault)
        with house_style():
            section, figure = shown(fault)
            write_atomically(fault.figure, svg_document(figure, fault.figure.stem))
        sections.append(section)
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    text = f"{before}{BEGIN}\n\n" + "\n".join(sections) + f"\n{END}{rest.partition(END)[2]}"
    write_atomically(PAGE, text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
