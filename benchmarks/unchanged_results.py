"""List what drivegate's commands answer, so that two lists show whether a change of the code has changed any result.

    python benchmarks/unchanged_results.py before.txt --wording --keep before     # on the old code
    python benchmarks/unchanged_results.py after.txt --wording --keep after       # on the new code
    diff before.txt after.txt && diff -r before after                             # nothing, or what to explain

Each line has the exit code of one command and a hash of its JSON document without provenance, times and wording: a text
with a space is wording. Further lines have hashes of the files that it wrote, where they have numbers.

With --wording, texts are compared too, and so are pages, reports in words, templates, helps, refusals, and the order of
keys. Folders, times, versions and hashes of sources are replaced. A page has three lines: the whole of it, its words,
and its figures.

With --keep, what is hashed is stored, to see what differs. --only takes a part of a line's name. Use the same script
and the same options for both lists; the code is that of the environment that runs it. The list grows while commands
run, in a fixed order. The whole list takes about forty minutes on two processors.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from joblib import Parallel, delayed

from proof_rows import Row, rows
from proof_text import Places, answered, as_text, files_in, normal, parts_of

_AT_ONCE: Final = 2
_REFUSED: Final = 2
_PROGRESS: Final = re.compile(r": (\d+ of \d+ |compiling|running|recording|writing|shrinking)")
_ROOT: Final = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Listing:
    """What the lines of a list are made of."""

    scratch: Path
    """Folder that the commands run in."""
    keep: Path | None = None
    """Folder that receives what is hashed."""
    places: Places | None = None
    """The folders that texts name; None where texts are not compared."""

    def lines(self, row: Row) -> list[str]:
        """Run one command and return its lines."""
        folder = self.scratch / _short(row.name)
        for name, text in row.given.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8")
        folder.mkdir(exist_ok=True)
        for words in row.first:
            _run(words, folder)
        before = frozenset(str(path.relative_to(folder)) for path in folder.rglob("*"))
        done = _run(("drivegate", *row.words), folder)
        lines = [self._line(row.name, done.returncode, as_text(self._shown(row, done)))]
        if row.files:
            for path in files_in(folder, before, wording=self.places is not None):
                for part, text in parts_of(path, self.places).items():
                    lines.append(self._line(f"{row.name}: {path.relative_to(folder)}{part}", None, text))
        return lines

    def _shown(self, row: Row, done: subprocess.CompletedProcess[str]) -> Any:
        if self.places is None and row.name.startswith("help"):
            return sorted(set(re.findall(r"--[a-z-]+", done.stdout)))
        shown = answered(done.stdout, self.places)
        if self.places is None or done.returncode < _REFUSED:
            return shown
        said = normal(done.stderr, self.places).splitlines()
        return {"answer": shown, "error": [line for line in said if not _PROGRESS.search(line)]}

    def _line(self, name: str, code: int | None, text: str) -> str:
        if self.keep is not None:
            (self.keep / f"{_short(name)}.txt").write_text(f"{text}\n", encoding="utf-8")
        return f"{hashlib.sha256(text.encode()).hexdigest()[:16]} {'-' if code is None else code} {name}"


def _short(name: str) -> str:
    return re.sub(r"[^a-z0-9-]+", "-", name.lower().replace(str(_ROOT).lower(), ""))


def _run(words: tuple[str, ...], where: Path) -> subprocess.CompletedProcess[str]:
    programs = Path(sys.executable).parent
    program = str(programs / words[0]) if words[0] in ("drivegate", "python") else words[0]
    environment = {**os.environ, "COLUMNS": "120", "NO_COLOR": "1"}
    return subprocess.run(
        [program, *words[1:]], cwd=where, env=environment, capture_output=True, text=True, check=False
    )


def _places(scratch: Path) -> Places:
    """Ask the environment where its code is: this script may be another clone's."""
    headers = Path(_run(("drivegate", "include-dir"), scratch).stdout.strip())
    clones = (folder for folder in headers.parents if (folder / "pyproject.toml").is_file())
    code = next(clones, headers.parents[2])
    return Places.of(scratch, _ROOT, code)


def main() -> None:
    """Run the commands, and write their lines in a fixed order."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("list", type=Path, help="file that receives the list")
    parser.add_argument("--wording", action="store_true", help="compare texts, pages and refusals too")
    parser.add_argument("--keep", type=Path, help="folder that receives what is hashed")
    parser.add_argument(
        "--only", action="append", default=[], help="a part of the names of lines; may be repeated"
    )
    options = parser.parse_args()
    if options.keep is not None:
        options.keep.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, options.list.open("w", encoding="utf-8") as file:
        scratch = Path(folder)
        listing = Listing(scratch, options.keep, _places(scratch) if options.wording else None)
        chosen = [row for row in rows() if not options.only or any(part in row.name for part in options.only)]
        jobs = (delayed(listing.lines)(row) for row in chosen)
        for lines in Parallel(_AT_ONCE, prefer="threads", return_as="generator")(jobs):
            for line in lines:
                sys.stderr.write(f"{line}\n")
                file.write(f"{line}\n")
            file.flush()


if __name__ == "__main__":
    main()
