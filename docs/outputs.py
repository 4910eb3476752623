"""Insert what commands print into README and the pages: ``python docs/outputs.py [NAME ...]``.

Between ``<!-- printed: NAME -->`` and ``<!-- end -->`` a page has lines that the commands of that name print. Which
lines, the page says itself: each of its lines is replaced by the printed one with the same beginning, and ``…`` stays.
The commands run for minutes; with ``--check`` nothing is written, and the exit code is 1 if a page is not current.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Final

DOCS: Final = Path(__file__).parent
ROOT: Final = DOCS.parent
PLACE: Final = re.compile(r"<!-- printed: ([\w-]+) -->\n\n```text\n(.*?)```\n\n<!-- end -->", re.DOTALL)
_WIDTH: Final = 240
_ELISION: Final = "…"
FAULT: Final = re.compile(r"^([a-z-]+) +([A-Z]+-\d) +(.+)$")
"""A line of README: a faulty controller, a check and what it measured."""


def pages() -> list[Path]:
    return [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]


def printed_by(command: str, folder: Path) -> list[str]:
    """Return the lines that a command prints in a folder; whatever it ends with, as long as it was carried out."""
    ended = subprocess.run(
        [sys.executable, "-m", *command.split()],
        cwd=folder,
        env={**os.environ, "COLUMNS": str(_WIDTH)},
        capture_output=True,
        text=True,
        check=False,
    )
    if ended.returncode not in (0, 1):
        raise SystemExit(f"{command}\n{ended.stdout}{ended.stderr}")
    return [line.rstrip() for line in ended.stdout.splitlines()]


def selected(shown: Sequence[str], printed: Sequence[str]) -> list[str]:
    """Return for each shown line the printed one that begins so, each after the one before."""
    made, place = [], 0
    for line in shown:
        if line.strip() in ("", _ELISION):
            made.append(line)
            continue
        begin = _beginning(line)
        found = next((at for at in range(place, len(printed)) if _beginning(printed[at]) == begin), None)
        if found is None:
            raise SystemExit(f"no printed line begins with '{begin}' after the one before it")
        made.append(printed[found])
        place = found + 1
    return made


def _beginning(line: str) -> str:
    """Return a line up to its first wide gap or colon: what stays the same where numbers change."""
    return re.split(r" {2,}|: ", line.strip(), maxsplit=1)[0]


COMMANDS: Final = MappingProxyType(
    {
        "firmware": (
            "drivegate new embedded-coder my-firmware",
            "drivegate check my-firmware/candidate.toml --only STP-1,FWK-2,OVC-1",
        ),
        "gallery": (
            "drivegate new embedded-coder my-firmware",
            "drivegate replay docs/gallery --candidate my-firmware/candidate.toml",
        ),
        "spread": ("drivegate campaign examples/campaign/spread.toml --output spread --workers 2",),
        "pm-ac": ("drivegate campaign examples/campaign/pm-ac.toml --output pm-ac --workers 2",),
    }
)
"""Commands by the name of what is inserted, run one after the other in an empty folder next to examples and docs."""
FAULTS: Final = "faults"
"""Name of the lines that each have a command of their own."""


def fault_command(name: str, check: str) -> str:
    return f"drivegate check faulty:{name} --only {check} --effort quick"


def lines_of(name: str, shown: Sequence[str]) -> list[str]:
    """Run the commands of a name, and return the lines that are shown of them."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for shown_folder in ("examples", "docs"):
            (folder / shown_folder).symlink_to(ROOT / shown_folder)
        if name == FAULTS:
            return [_fault_line(line, folder) for line in shown]
        return selected(shown, [line for command in COMMANDS[name] for line in printed_by(command, folder)])


def _fault_line(line: str, folder: Path) -> str:
    known = FAULT.match(line)
    assert known is not None, line
    printed = printed_by(fault_command(known[1], known[2]), folder)
    measured = next(line for line in printed if line.startswith("  measured "))
    value, _, _ = measured.removeprefix("  measured ").partition("; limit ")
    return f"{line[: known.start(3)]}{value}"


def renewed(text: str, names: Sequence[str], made: Callable[[str, Sequence[str]], list[str]]) -> str:
    """Return a page with what is printed inserted again."""

    def inserted(place: re.Match[str]) -> str:
        if names and place[1] not in names:
            return place[0]
        lines = "\n".join(made(place[1], place[2].splitlines()))
        return f"<!-- printed: {place[1]} -->\n\n```text\n{lines}\n```\n\n<!-- end -->"

    return PLACE.sub(inserted, text)


def changed_pages(names: Sequence[str]) -> Iterator[tuple[Path, str]]:
    """Run what the pages show, and list those that are not current, with what they should be."""
    for page in pages():
        before = page.read_text(encoding="utf-8")
        after = renewed(before, names, lines_of)
        if after != before:
            yield page, after


def main(words: list[str]) -> int:
    """Insert, or compare with ``--check``, all outputs or those of some names."""
    checks = "--check" in words
    names = [word for word in words if word != "--check"]
    unknown = set(names) - {FAULTS, *COMMANDS}
    if unknown:
        sys.stderr.write(f"usage: outputs.py [--check] [{' | '.join((FAULTS, *COMMANDS))} ...]\n")
        return 2
    stale = list(changed_pages(names))
    for page, text in stale:
        sys.stdout.write(f"{page.relative_to(ROOT)} is not current\n" if checks else f"written: {page}\n")
        if not checks:
            page.write_text(text, encoding="utf-8")
    return int(checks and bool(stale))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
