"""Manual pages of commands, in the language of man."""

from __future__ import annotations

import inspect
import re

import click

from drivegate.version import __version__
from drivegate_models.errors import InputError


def manual_pages(group: click.Group, name: str = "drivegate") -> dict[str, str]:
    """Return the page of a group and of each of its commands that is installed, by the names of their files."""
    top = click.Context(group, info_name=name)
    commands: dict[str, click.Command] = {}
    for each in group.list_commands(top):
        try:
            found = group.get_command(top, each)
        except InputError:
            # The laboratory may be missing.
            continue
        if found is not None:
            commands[each] = found
    names = [f"{name}-{each}" for each in commands]
    pages = {f"{name}.1": _page(top, name, names)}
    for each, found in commands.items():
        context = click.Context(found, info_name=each, parent=top)
        pages[f"{name}-{each}.1"] = _page(context, f"{name}-{each}", [name])
    return pages


def _page(context: click.Context, title: str, related: list[str]) -> str:
    """Write one page; `related`: the pages to see also."""
    command = context.command
    paragraphs = _paragraphs(command.help or "")
    summary = (paragraphs or [title])[0].split(". ")[0].rstrip(".").replace("\n", " ")
    usage = " ".join(command.collect_usage_pieces(context))
    lines = [
        f'.TH "{title.upper()}" 1 "" "drivegate {__version__}" "drivegate"',
        # Options can be copied as they are: no word is divided, no space is stretched.
        ".nh",
        ".ad l",
        ".SH NAME",
        f"{_literal(title)} \\- {_literal(summary)}",
        ".SH SYNOPSIS",
        f".B {_literal(context.command_path)}",
        _literal(usage),
        ".SH DESCRIPTION",
    ]
    for paragraph in paragraphs:
        lines += [".PP", _literal(paragraph)]
    records = [
        record for option in command.get_params(context) if (record := option.get_help_record(context))
    ]
    lines += [".SH OPTIONS"] if records else []
    for words, meaning in records:
        lines += [".TP", f".B {_literal(words)}", _literal(meaning)]
    if command.epilog:
        lines += [".SH NOTES", _literal(" ".join(command.epilog.split()))]
    lines += [".SH SEE ALSO", ", ".join(f"{_literal(each)}(1)" for each in related)]
    return "\n".join(lines) + "\n"


def _paragraphs(text: str) -> list[str]:
    """Return the paragraphs of a help text, each on one line."""
    shown = inspect.cleandoc(text).partition("\f")[0]
    return [" ".join(part.split()) for part in re.split(r"\n\s*\n", shown) if part.strip()]


def _literal(text: str) -> str:
    """Write text so that man shows each of its characters, and takes no line of it for a request."""
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return re.sub(r"^([.'])", r"\\&\1", escaped, flags=re.MULTILINE)
