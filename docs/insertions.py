"""Insert generated tables into the pages: ``python docs/insertions.py``; with ``--words`` it counts their words.

Between ``<!-- inserted: NAME ARGUMENT -->`` and ``<!-- end -->`` a page has the output of the function of that name, as
plain Markdown, which reads the same on a git host and in the built pages. A test compares the pages with it.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Final, get_args

import click
from pydantic.fields import FieldInfo
from reached_code import reached_rows, time_ratios
from requirement_tables import row_table
from varied_keys import (
    NOT_VARIED,
    Varied,
    drawn_by_family,
    varied_keys,
)

from drivegate.commands.command_line import COMMANDS, command_line
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.scenarios.drawn.families import FAMILY_GROUPS, Family
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.contracts.traceability import family_name, traced_checks
from drivegate.drives.kinds import DEFAULT_DRIVE, DEFAULT_DRIVES
from drivegate.scenarios.covering import FACTORS, covering_rows
from drivegate_cases.documents.document import Section
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.rating import FOLLOWING
from drivegate_cases.scenario.scenario import FOLLOWING_KEYS, Scenario, load_scenario, scenario_names
from drivegate_cases.scenario.sensors import PLAIN
from drivegate_lab.candidates.faults.catalogue import MUTATIONS
from drivegate_lab.drawn.kinds import DRAWN_KINDS
from drivegate_lab.selftest.operations import operations
from drivegate_lab.selftest.subjects import FAULTS_OF
from drivegate_models.contract.current import signals as current_signals
from drivegate_models.contract.duty import signals as duty_signals

DOCS: Final = Path(__file__).parent
PLACE: Final = re.compile(r"<!-- inserted: ([\w-]+)(?: (\S+))? -->\n.*?<!-- end -->", re.DOTALL)
LANGUAGES: Final = {
    ".py": "python",
    ".sh": "sh",
    ".c": "c",
    ".h": "c",
    ".cpp": "cpp",
    ".rs": "rust",
    ".toml": "toml",
}
MEASURED: Final = re.compile(r"<!-- ([\w ]+): begin -->\n.*?<!-- \1: end -->", re.DOTALL)
"""Tables that other commands write, each named by its page."""
PRINTED: Final = re.compile(r"<!-- printed: [\w-]+ -->\n.*?<!-- end -->", re.DOTALL)
"""What `outputs.py` inserts."""
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
        "Judged on": row["scenarios"],
        "Source": ", ".join(fact["id"] for fact in row["facts"]),
    }
    faults = _known_faults(contract, name)
    return {head: _plain(text) for head, text in stated.items() if text} | (
        {"Faulty controllers": faults} if faults else {}
    )


def _known_faults(contract: str, name: str) -> str:
    """The faulty controllers for one check; those of duty ratios with their faults."""
    if not contract:
        return ", ".join(f"`faulty:{fault.name}`" for fault in MUTATIONS.values() if fault.check == name)
    known = FAULTS_OF["duty"]
    faults = {fault: found.sentence for fault, found in known.items() if found.check == name}
    return "".join(f"\n  - `faulty:{fault}`: {_plain(sentence)}" for fault, sentence in faults.items())


def drawn_bounds(named: str) -> str:
    """The bounds within which drives of each kind are drawn: ``half-bridge,star``."""
    kinds = {kind: DRAWN_KINDS[kind].bounds for kind in named.split(",")}
    quantities = {bound.quantity: bound.unit for bounds in kinds.values() for bound in bounds.values()}
    rows = []
    for quantity, unit in quantities.items():
        ranges = (
            next(
                (f"{one.lowest:g} to {one.highest:g}" for one in bounds.values() if one.quantity == quantity),
                "–",
            )
            for bounds in kinds.values()
        )
        rows.append((_plain(quantity), *ranges, _plain(unit)))
    return _table(("quantity", *kinds, "unit"), rows)


def fixed_table(_: str) -> str:
    """The names of the scenarios that are always run."""
    return ", ".join(f"`{run.name}`" for run in fixed_scenarios(load_drive(DEFAULT_DRIVE)))


def drawn_table(_: str) -> str:
    """The families that are drawn, from the docstrings of the functions that draw them."""
    return "\n".join(_family(family) for group in FAMILY_GROUPS for family in group)


_WRITTEN: Final = ("schema", "name", "description")


def operations_table(named: str) -> str:
    """Kinds of operation that are rarely tried, each with its fixed runs and the faulty controllers that prove them."""
    rows = (
        (
            each.kind,
            _first_of([f"`{run.name}`" for run in each.runs]),
            ", ".join(f"`{fault.name}` ({fault.check})" for fault in each.faults),
        )
        for each in operations(load_drive(named))
    )
    return _table(
        ("kind of operation", "fixed runs", "faulty controllers, and the check that catches them"), rows
    )


def _first_of(names: Sequence[str]) -> str:
    """Return the names of the first runs, shortened, and how many there are beyond these."""
    shown = [
        f"{name[:_LONGEST_NAME]}…`" if len(name) > _LONGEST_NAME else name for name in names[:_SHOWN_RUNS]
    ]
    more = len(names) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")


_SHOWN_RUNS: Final = 2
_LONGEST_NAME: Final = 60


def coverage_table(contract: str) -> str:
    """What the runs vary, measured on drawn scenarios; of duty ratios alone what some family varies."""
    rows, fixed = [], {}
    for row in varied_keys(drawn_by_family(_drive_of(contract))):
        if row.key in _WRITTEN or row.key.startswith("nameplate ") or (contract and not row.families):
            continue
        if contract or row.key not in NOT_VARIED:
            rows.append((row.key, _plain(_range(row))))
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
        rows.append((ast.unparse(field.target), _plain(str(text.value.value)).replace("`", "")))
    return f"**{record}**\n\n{_list(rows)}"


SHARED_OPTIONS: Final = MappingProxyType(
    {
        "--output": "folder, or file, of what is written",
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
    return _list(SHARED_OPTIONS.items())


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


def joint_table(_: str) -> str:
    """The factors that are varied jointly."""
    factors = (
        (factor, _plain(", ".join(levels)), str(sum(row[factor] != levels[0] for row in covering_rows())))
        for factor, levels in FACTORS.items()
    )
    return _table(
        ("factor", "levels, the plain one first", f"rows of {len(covering_rows())} that change it"), factors
    )


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
    return _list(rows if kind == "pm-ac" else [row for row in _key_rows(DriveDocument) if row not in rows])


def _key_rows(document: type[DriveDocument]) -> list[tuple[str, str]]:
    return [
        (f"{prefix}{key}", _key_text(field, optional=key in FOLLOWING or not field.is_required()))
        for prefix, model in (
            ("", document),
            *((f"{name}.", table) for name, table in document.tables.items()),
        )
        for key, field in model.model_fields.items()
        if key not in DriveDocument.tables and field.alias is None
    ]


def _key_text(field: FieldInfo, *, optional: bool) -> str:
    """Describe a key, with what holds where it is left out."""
    text = _plain(field.description or "")
    stated = field.default if isinstance(field.default, str | int | float) else None
    if not optional or (stated is None and "by default" in text):
        return text
    if stated in (None, ""):
        return f"{text} (optional)"
    if isinstance(stated, bool):
        return f"{text} ({str(stated).lower()})"
    return f"{text} ({stated if isinstance(stated, str) else f'{stated:g}'})"


def scenario_keys(table: str) -> str:
    """Every key of a scenario, or of one of its tables: ``scales``, ``load.dynamometer``."""
    name, _, kind = table.partition(".")
    if not name:
        return _list(_model_rows(Scenario))
    models = tables_of(Scenario.model_fields[name].annotation)
    return _list(row for model in models if kind in ("", kind_of(model)) for row in _model_rows(model))


def _model_rows(model: type[Section]) -> Iterator[tuple[str, str]]:
    for key, field in model.model_fields.items():
        if field.alias is None:
            yield key, _key_text(field, optional=not field.is_required() or key in FOLLOWING_KEYS)


def tables_of(annotation: object) -> list[type[Section]]:
    """Return the tables that a key may hold."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return [annotation]
    return [table for argument in get_args(annotation) for table in tables_of(argument)]


def kind_of(model: type[Section]) -> str:
    """Return the kind that a table states; empty for one without kinds."""
    described = model.model_fields.get("kind")
    return "" if described is None else str(get_args(described.annotation)[0])


def load_kinds(_: str) -> str:
    """The kinds of loads, each with its keys."""
    lines = []
    for model in tables_of(Scenario.model_fields["load"].annotation):
        what = _plain((inspect.getdoc(model) or "").partition("\n")[0])
        lines += [f"- `{kind_of(model)}`: {what}"]
        lines += [f"  - `{key}`: {text}" for key, text in _model_rows(model) if key != "kind"]
    return "\n".join(lines)


def packaged_cases(contract: str) -> str:
    """The scenarios that come with drivegate for the drives of a contract."""
    loaded = [load_scenario(name) for name in scenario_names()]
    return _list((one.name, _plain(one.description)) for one in loaded if one.drive.contract == contract)


def sensor_keys(kind: str) -> str:
    """Every key of a kind of sensors."""
    fields = type(PLAIN[kind]).model_fields
    return _list((key, _key_text(field, optional=True)) for key, field in fields.items() if key != "kind")


def requirement_table(named: str) -> str:
    """A table of what rows of requirements can say, such as ``quantities``."""
    heads, rows = row_table(named)
    return _table(heads, ([_plain(cell) if "`" not in cell else cell for cell in row] for row in rows))


def code_coverage(_: str) -> str:
    """What the gate reaches of templates, examples and firmwares, and how much longer it computes to count it."""
    table = _table(("code", "effort", "lines", "branches", "not reached"), reached_rows())
    turns, counting, sanitizing = time_ratios()
    return (
        f"{table}\n\nA gate of template `c` takes {counting:.2f} times the processor time with `--coverage`, and "
        f"{sanitizing:.2f} times with\n`--sanitize address,undefined` (the option `--turns {turns}`)."
    )


def source(path: str) -> str:
    """A file of the repository, in full."""
    text = (DOCS.parent / path).read_text(encoding="utf-8").rstrip("\n")
    return f"```{LANGUAGES[Path(path).suffix]}\n{text}\n```"


def function(named: str) -> str:
    """One function of a file of the repository, ``examples/c/controller.c:drivegate_step``."""
    path, _, name = named.rpartition(":")
    text = (DOCS.parent / path).read_text(encoding="utf-8")
    found = re.search(rf"^[^\n]*\b{name}\([^\n]*\{{\n.*?^\}}$", text, re.MULTILINE | re.DOTALL)
    assert found is not None, named
    return f"```{LANGUAGES[Path(path).suffix]}\n{found[0]}\n```"


def opening_comment(path: str) -> str:
    """What a header says before its first directive, which is an example."""
    text = (DOCS.parent / path).read_text(encoding="utf-8")
    return f"```c\n{text.partition('#ifndef')[0].rstrip()}\n```"


INSERTED: Final = MappingProxyType(
    {
        "check-table": check_table,
        "check": check,
        "drawn-bounds": drawn_bounds,
        "fixed-scenarios": fixed_table,
        "drawn-scenarios": drawn_table,
        "coverage-table": coverage_table,
        "operations": operations_table,
        "signals": signals,
        "shared-options": shared_options,
        "command-table": command_table,
        "joint-table": joint_table,
        "drive-keys": drive_keys,
        "scenario-keys": scenario_keys,
        "load-kinds": load_kinds,
        "packaged-cases": packaged_cases,
        "sensor-keys": sensor_keys,
        "requirement-table": requirement_table,
        "code-coverage": code_coverage,
        "source": source,
        "function": function,
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


def _family(family: Family) -> str:
    """Describe a family in the words of its function's docstring."""
    text = inspect.getdoc(family) or ""
    summary = text.partition("\n")[0].removeprefix("Draw ").rstrip(".")
    returned = re.search(r"Of scenarios ?(.*?)\.?(\n\n|\Z)", text, re.DOTALL)
    detail = "" if returned is None else " ".join(returned[1].split())
    return f"- {family_name(family.__name__)}: {_plain(f'{summary}: {detail}' if detail else summary)}"


def _list(rows: Iterable[tuple[str, str]]) -> str:
    return "\n".join(f"- `{name}`: {text}" for name, text in rows)


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def _plain(text: str) -> str:
    """Let Markdown show a text as it is, inside a table."""
    return re.sub(r"([|*_<>\[\]$])", r"\\\1", " ".join(text.split()))


def words(text: str) -> tuple[int, int]:
    """Count the words of a page: by hand, and generated."""
    generated = sum(
        len(place[0].split()) for kind in (PLACE, MEASURED, PRINTED) for place in kind.finditer(text)
    )
    return len(text.split()) - generated, generated


def word_counts() -> dict[str, tuple[int, int]]:
    """Count the words of every page: by hand, and generated."""
    return {
        page.relative_to(DOCS).as_posix(): words(page.read_text(encoding="utf-8"))
        for page in sorted(DOCS.rglob("*.md"))
    }


def _print_words() -> None:
    counts = word_counts()
    total = tuple(sum(column) for column in zip(*counts.values(), strict=True))
    for name, (by_hand, generated) in {**counts, "all": total}.items():
        sys.stdout.write(f"{by_hand:6} by hand {generated:6} generated  {name}\n")


if __name__ == "__main__":
    if sys.argv[1:] == ["--words"]:
        _print_words()
        sys.exit()
    for page in sorted(DOCS.rglob("*.md")):
        before = page.read_text(encoding="utf-8")
        after = renewed(before)
        if after != before:
            page.write_text(after, encoding="utf-8")
