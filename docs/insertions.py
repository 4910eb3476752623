"""Insert generated tables into the pages: ``python docs/insertions.py``; with ``--words`` it counts their words.

Between ``<!-- inserted: NAME ARGUMENT -->`` and ``<!-- end -->`` a page has the output of the function of that name, as
plain Markdown, which reads the same on a git host and in the built pages. A test compares the pages with it.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Final

import click
from pydantic.fields import FieldInfo
from varied_keys import (
    JUDGED,
    NOT_VARIED,
    SENSED,
    Varied,
    drawn_by_family,
    varied_keys,
)

from drivegate.candidates.builtin.duty_faults import DUTY_FAULTS
from drivegate.candidates.builtin.faults.catalogue import MUTATIONS
from drivegate.candidates.builtin.faults.mutation import told_on
from drivegate.candidates.builtin.near import NEAR_DESIGNS
from drivegate.commands.command_line import COMMANDS, command_line
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.scenarios.drawn.families import FAMILY_GROUPS, Family
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.contracts.traceability import family_name, traced_checks, traced_facts
from drivegate.drives.drawn.kinds import DRAWN_KINDS
from drivegate.drives.kinds import DEFAULT_DRIVE, DEFAULT_DRIVES
from drivegate.scenarios.covering import FACTORS, IMPOSSIBLE, covering_rows
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.rating import FOLLOWING
from drivegate_cases.scenario.sensors import PLAIN
from drivegate_models.contract.current import signals as current_signals
from drivegate_models.contract.duty import signals as duty_signals

DOCS: Final = Path(__file__).parent
PLACE: Final = re.compile(r"<!-- inserted: ([\w-]+)(?: (\S+))? -->\n.*?<!-- end -->", re.DOTALL)
LANGUAGES: Final = {".py": "python", ".sh": "sh", ".c": "c", ".h": "c", ".rs": "rust", ".toml": "toml"}
SIGNALS: Final = MappingProxyType({"current": current_signals, "duty": duty_signals})


def _drive_of(contract: str) -> DriveDocument:
    """Return the drive whose numbers stand in the texts of a contract's checks."""
    return load_drive(DEFAULT_DRIVES[contract or "current"])


def check_table(contract: str) -> str:
    """Every check of a contract, each with a link to its page."""
    rows = (
        (f"[`{row['id']}`](checks/{row['id']}.md)", _title(row["id"]), _plain(row["limit"]), row["level"])
        for row in traced_checks(_drive_of(contract))
    )
    return _table(("check", "judges", "limit", "level"), rows)


def _title(name: str) -> str:
    """Return the title of a check's page."""
    first = (DOCS / "checks" / f"{name}.md").read_text(encoding="utf-8").partition("\n")[0]
    return first.partition(": ")[2]


def check(named: str) -> str:
    """One check: requirement, limit, margin, source and faults; of another contract, ``duty:PWR-1``."""
    contract, _, name = named.rpartition(":")
    rows = _check_rows(contract, name)
    if contract and any(known.id == name for known in CHECKS):
        shared = _check_rows("", name)
        rows = {head: text for head, text in rows.items() if text != shared.get(head)}
    return (
        "\n".join(f"- **{head}**: {text}".replace(" \n", "\n") for head, text in rows.items())
        or "Nothing differs."
    )


def _check_rows(contract: str, name: str) -> dict[str, str]:
    row = next(row for row in traced_checks(_drive_of(contract)) if row["id"] == name)
    level = (
        row["level"] if row["subject"] == "candidate" else "a failure is a fault of drivegate, exit code 3"
    )
    stated = {
        "Requirement": row["requirement"],
        "Why": row["why"],
        "Limit": f"{row['limit']} ({level})",
        "Margin": row["formula"],
        "Judged on": row["scenarios"],
        "Source": ", ".join(fact["id"] for fact in row["facts"]) or row["source"],
    }
    faults = _known_faults(contract, name)
    return {head: _plain(text) for head, text in stated.items()} | (
        {"Faulty controllers": faults} if faults else {}
    )


def _known_faults(contract: str, name: str) -> str:
    """The faulty controllers for one check, each with its fault."""
    if contract:
        faults = {fault: found.sentence for fault, found in DUTY_FAULTS.items() if found.check == name}
    else:
        drive = load_drive(DEFAULT_DRIVE)
        faults = {
            fault.name: told_on(fault, fault.sentence, drive)
            for fault in MUTATIONS.values()
            if fault.check == name
        }
    return "".join(f"\n  - `faulty:{fault}`: {_plain(sentence)}" for fault, sentence in faults.items())


def near_designs(_: str) -> str:
    """The correct controllers that are near a limit by design."""
    drive = load_drive(DEFAULT_DRIVE)
    rows = (
        (f"`near:{design.name}`", _plain(told_on(design, design.sentence, drive)))
        for design in NEAR_DESIGNS.values()
    )
    return _table(("design", "what it does"), rows)


def drawn_bounds(kind: str) -> str:
    """The bounds within which drives of a kind are drawn."""
    rows = (
        (
            _plain(bound.quantity),
            f"{bound.lowest:g} to {bound.highest:g}",
            _plain(bound.unit),
        )
        for bound in DRAWN_KINDS[kind].bounds.values()
    )
    return _table(("quantity", "bounds", "unit"), rows)


def fixed_table(_: str) -> str:
    """The names of the scenarios that are always run."""
    return ", ".join(f"`{run.name}`" for run in fixed_scenarios(load_drive(DEFAULT_DRIVE)))


def drawn_table(_: str) -> str:
    """The families that are drawn, from the docstrings of the functions that draw them."""
    rows = (_family(family) for group in FAMILY_GROUPS for family in group)
    every_run = ", ".join(check.id for check in CHECKS if check.every_run)
    return _table(("family", "drawn", f"exercises, beside {every_run}"), rows)


def fact_table(_: str) -> str:
    """Every fact of the paper with what covers it."""
    rows = []
    for fact in traced_facts():
        by = fact["covered_by"]
        tests = "; ".join(name.partition("::")[2].removeprefix("test_") for name in by["properties"])
        cells = (fact["id"], fact["title"], ", ".join(by["checks"]), tests, ", ".join(by["figures"]))
        rows.append(tuple(_plain(text.replace("_", " ")) for text in cells))
    return _table(("fact", "stated", "checks", "tests", "figures"), rows)


_WRITTEN: Final = ("schema", "name", "description")


def coverage_table(contract: str) -> str:
    """What the runs vary, measured on drawn scenarios; of duty ratios alone what some family varies."""
    rows, fixed = [], {}
    for row in varied_keys(drawn_by_family(_drive_of(contract))):
        if row.key in _WRITTEN or (contract and not row.families):
            continue
        if contract or row.key not in NOT_VARIED:
            rows.append((f"`{row.key}`", _plain(_range(row))))
        else:
            fixed.setdefault(NOT_VARIED[row.key], []).append(f"`{row.key}`")
    reasons = (f"- {', '.join(keys)}: {_plain(reason)}" for reason, keys in fixed.items())
    return "\n".join(
        (_table(("key or field", "range"), rows), "", "Not varied:" if fixed else "", "", *reasons)
    ).strip()


def signals(named: str) -> str:
    """The fields of one record of a contract, from their docstrings: ``duty:DutySense``."""
    contract, _, record = named.partition(":")
    tree = ast.parse(inspect.getsource(getattr(SIGNALS[contract], record))).body[0]
    assert isinstance(tree, ast.ClassDef)
    rows = []
    for field, text in zip(tree.body[1::2], tree.body[2::2], strict=True):
        assert isinstance(field, ast.AnnAssign)
        assert isinstance(text, ast.Expr)
        assert isinstance(text.value, ast.Constant)
        rows.append((f"`{ast.unparse(field.target)}`", _plain(str(text.value.value)).replace("`", "")))
    return _table((record, "is"), rows)


SHARED_OPTIONS: Final = MappingProxyType(
    {
        "--drive": "a drive by its name, or a file of one",
        "--set": "set one key of the drive, KEY=VALUE; may be given again",
        "--workers": "number of processes; the results do not depend on it",
        "--isolation": "isolate the candidate: `auto`, `strict` or `none`",
        "--csv": "write rows as CSV",
        "--parquet": "write rows as Parquet",
        "--plot": "write a figure, .png or .svg",
        "--json": "print one JSON document, errors too",
    }
)
"""Options that mean the same wherever they are, stated once."""


def shared_options(_: str) -> str:
    """The options that several commands have."""
    return _table(("option", "does"), ((f"`{name}`", text) for name, text in SHARED_OPTIONS.items()))


def command_table(_: str) -> str:
    """Every command with the options of its own."""
    lines: list[str] = []
    with command_line.make_context("drivegate", [], resilient_parsing=True) as context:
        for name, summary in COMMANDS.items():
            command = command_line.get_command(context, name)
            assert command is not None
            lines += ["", f"## {name}", "", _plain(summary), ""]
            for option in command.params:
                if isinstance(option, click.Option) and not SHARED_OPTIONS.keys() & set(option.opts):
                    written = ", ".join(f"`{one}`" for one in (*option.opts, *option.secondary_opts))
                    lines.append(f"- {written}: {_plain(option.help or '')}")
    return "\n".join(lines).strip()


def signal_table(_: str) -> str:
    """The fields of `Sense` and `Command`, and what reaches or judges them."""
    rows = (
        (f"`{kind}.{field}`", _plain(", ".join(given)))
        for kind, fields in (("Sense", SENSED), ("Command", JUDGED))
        for field, given in fields.items()
    )
    return _table(("field", "reached by the keys, or judged by the checks"), rows)


def joint_table(_: str) -> str:
    """The factors that are varied jointly, and the pairs that are impossible."""
    factors = (
        (factor, _plain(", ".join(levels)), str(sum(row[factor] != levels[0] for row in covering_rows())))
        for factor, levels in FACTORS.items()
    )
    pairs = (
        (_plain(" with ".join(f"{factor} {level}" for factor, level in sorted(pair))), _plain(reason))
        for pair, reason in IMPOSSIBLE.items()
    )
    heads = ("factor", "levels, the plain one first", f"rows of {len(covering_rows())} that change it")
    return f"{_table(heads, factors)}\n\n{_table(('impossible pair', 'reason'), pairs)}"


def _range(row: Varied) -> str:
    """Write the range of numbers, or all words."""
    if row.key in ("name", "description", "schema") or not row.values:
        return "–"
    if isinstance(row.values[0], str):
        return ", ".join(map(str, row.values))
    lowest, highest = (f"{value:.6g}" for value in row.values)
    return lowest if lowest == highest else f"{lowest} to {highest}"


def drive_keys(kind: str) -> str:
    """Every key of a PM AC drive, or those of the other kinds that differ from it."""
    rows = _key_rows(DriveDocument.of_kind({"kind": "pm-ac"}))
    if kind != "pm-ac":
        rows = [row for row in _key_rows(DriveDocument) if row not in rows]
    return _table(("key", "is", "left out"), rows)


def _key_rows(document: type[DriveDocument]) -> list[tuple[str, str, str]]:
    return [
        (f"`{prefix}{key}`", _plain(field.description or ""), _left_out_of_drive(key, field))
        for prefix, model in (
            ("", document),
            *((f"{name}.", table) for name, table in document.tables.items()),
        )
        for key, field in model.model_fields.items()
        if key not in DriveDocument.tables and field.alias is None
    ]


def _left_out_of_drive(key: str, field: FieldInfo) -> str:
    return "follows" if key in FOLLOWING else _left_out(field.is_required(), field.default)


def _left_out(required: bool, default: object) -> str:
    if required:
        return "refused"
    if isinstance(default, str):
        return default
    return f"{default:g}" if isinstance(default, int | float) else "none"


def sensor_keys(kind: str) -> str:
    """Every key of a kind of sensors."""
    rows = [
        (
            f"`{key}`",
            _plain(field.description or ""),
            "–" if field.default is None else _left_out(False, field.default),
        )
        for key, field in type(PLAIN[kind]).model_fields.items()
        if key != "kind"
    ]
    return _table(("key", "is", "left out"), rows)


def source(path: str) -> str:
    """A file of the repository, in full."""
    text = (DOCS.parent / path).read_text(encoding="utf-8").rstrip("\n")
    return f"```{LANGUAGES[Path(path).suffix]}\n{text}\n```"


def opening_comment(path: str) -> str:
    """What a header says before its first directive, which is an example."""
    text = (DOCS.parent / path).read_text(encoding="utf-8")
    return f"```c\n{text.partition('#ifndef')[0].rstrip()}\n```"


INSERTED: Final = MappingProxyType(
    {
        "check-table": check_table,
        "check": check,
        "near-designs": near_designs,
        "drawn-bounds": drawn_bounds,
        "fixed-scenarios": fixed_table,
        "drawn-scenarios": drawn_table,
        "fact-table": fact_table,
        "coverage-table": coverage_table,
        "signal-table": signal_table,
        "signals": signals,
        "shared-options": shared_options,
        "command-table": command_table,
        "joint-table": joint_table,
        "drive-keys": drive_keys,
        "sensor-keys": sensor_keys,
        "source": source,
        "opening-comment": opening_comment,
    }
)


def renewed(text: str, made: MappingProxyType[str, Callable[[str], str]] = INSERTED) -> str:
    """Return a page with everything inserted again.

    Parameters
    ----------
    text : str
        The page.
    made : mapping
        What makes each insertion.

    Returns
    -------
    str
        The page, the same where nothing has changed.
    """

    def inserted(place: re.Match[str]) -> str:
        opening = place[0].partition("\n")[0]
        return f"{opening}\n\n{made[place[1]](place[2] or '')}\n\n<!-- end -->"

    return PLACE.sub(inserted, text)


def _family(family: Family) -> tuple[str, str, str]:
    """Take a family's words from the docstring of its function."""
    text = inspect.getdoc(family) or ""
    summary = text.partition("\n")[0].removeprefix("Draw ").rstrip(".")
    returned = re.search(r"Of scenarios ?(.*?)\.?(\n\n|\Z)", text, re.DOTALL)
    detail = "" if returned is None else " ".join(returned[1].split())
    name = family_name(family.__name__)
    return (
        name,
        _plain(f"{summary}: {detail}" if detail else summary),
        ", ".join(sorted(check.id for check in CHECKS if name in check.families)),
    )


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def _plain(text: str) -> str:
    """Let Markdown show a text as it is, inside a table."""
    return re.sub(r"([|*_<>\[\]$])", r"\\\1", " ".join(text.split()))


def words(text: str) -> tuple[int, int]:
    """Count the words of a page: by hand, and inserted."""
    inserted = sum(len(place[0].split()) for place in PLACE.finditer(text))
    return len(text.split()) - inserted, inserted


def word_counts() -> dict[str, tuple[int, int]]:
    """Count the words of every page: by hand, and inserted."""
    return {
        page.relative_to(DOCS).as_posix(): words(page.read_text(encoding="utf-8"))
        for page in sorted(DOCS.rglob("*.md"))
    }


def _print_words() -> None:
    counts = word_counts()
    total = tuple(sum(column) for column in zip(*counts.values(), strict=True))
    for name, (by_hand, inserted) in {**counts, "all": total}.items():
        sys.stdout.write(f"{by_hand:6} by hand {inserted:6} generated  {name}\n")


if __name__ == "__main__":
    if sys.argv[1:] == ["--words"]:
        _print_words()
        sys.exit()
    for page in sorted(DOCS.rglob("*.md")):
        before = page.read_text(encoding="utf-8")
        after = renewed(before)
        if after != before:
            page.write_text(after, encoding="utf-8")
