"""How every page is made: printable text, one template folder, one style sheet, one script, and a strict policy."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Final

from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from jinja2 import Environment

LONGEST_TEXT: Final = 2_000
"""Longest text of a cell (characters)."""
LONGEST_BLOCK: Final = 20_000
"""Longest scenario or traceback (characters)."""
STYLE_SHEET: Final = "house.css"
"""Style sheet of every page, among the templates."""
SCRIPT: Final = "tables.js"
"""Script of every page: it lets tables be sorted and filtered; without it they read as they are."""
TRACE_STYLES: Final = ("uplot/uPlot.min.css",)
TRACE_SCRIPTS: Final = ("uplot/uPlot.iife.min.js", "traces.js")
TRACE_LICENCE: Final = "uplot/LICENSE"
"""What a page with traces has besides."""


def clean(value: object, longest: int = LONGEST_TEXT) -> str:
    """Make any text printable and bounded; line ends are kept."""
    text = str(value)[: longest + 1]
    shown = "".join(
        character
        if character == "\n" or character.isprintable()
        else character.encode("unicode_escape").decode("ascii")
        for character in text
    )
    return shown if len(shown) <= longest else shown[: longest - 1] + "…"


def plain_number(value: float, digits: int = 3) -> str:
    """Write a number with its sign and never in powers of ten: people read −399, not −4e+02."""
    text = f"{value:+.{digits}g}"
    return (f"{value:+.0f}" if "e" in text else text).replace("-", "−")


def plain_data(value: object, indent: int = 0) -> str:
    """Write plain data so that it reads well: a line for each key, lists on one line."""
    if not isinstance(value, Mapping) or not value:
        return json.dumps(value, ensure_ascii=False, default=str)
    lines = []
    for key, item in value.items():
        nested = isinstance(item, Mapping) and bool(item)
        written = plain_data(item, indent + 1)
        lines.append(f"{'  ' * indent}{key}:{chr(10) if nested else ' '}{written}")
    return "\n".join(lines)


def page_text(template: str, *, traces: bool = False, **values: Any) -> str:
    """Make a page, with or without what draws traces."""
    style = "".join(map(_part, (*(TRACE_STYLES if traces else ()), STYLE_SHEET)))
    script = "\n".join(map(_part, (*(TRACE_SCRIPTS if traces else ()), SCRIPT)))
    if traces:
        script = f"/* {_part(TRACE_LICENCE)} */\n{script}"
    return (
        environment()
        .get_template(template)
        .render(style=style, script=script, policy=_policy(script), **values)
    )


@cache
def environment() -> Environment:
    from jinja2 import Environment as NewEnvironment
    from jinja2 import PackageLoader, StrictUndefined

    return NewEnvironment(
        loader=PackageLoader("drivegate_reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def _part(name: str) -> str:
    return (files("drivegate_reports") / "templates" / name).read_text(encoding="utf-8")


def _policy(script: str) -> str:
    """Write the content policy: the hash of the script allows it, and no other."""
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return (
        f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'; "
        "base-uri 'none'; form-action 'none'"
    )


def require_document(document: Mapping[str, Any], kind: str, schema: int, name: str) -> None:
    """Refuse a document of another kind, or of a schema newer than the one that this version reads."""
    if document.get("kind") != kind:
        raise InputError(f"the document is of kind {document.get('kind')!r}, but must be of kind '{kind}'")
    found = document.get("schema")
    if not isinstance(found, int) or found > schema:
        raise InputError(f"{name} has the schema {found!r}, but this version reads up to {schema}")
