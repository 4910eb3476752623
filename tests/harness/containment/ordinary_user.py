"""Run Python as an ordinary user, for tests that are root's, also where Python is in root's own home.

``python ordinary_user.py FOLDER WORDS...`` becomes the user that owns the folder, and executes this Python with words.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from drivegate.isolation.layers import system_places
from drivegate.isolation.namespaces import _BIND, _MOUNTS, _PRIVATE, _RECURSIVE, _mount
from drivegate.isolation.system_calls import SYSTEM, succeeded

NOBODY = 65534
"""The user and group that have no rights anywhere."""


def run_as_ordinary_user(folder: Path, *words: str) -> str:
    """Run this Python as an ordinary user, with a home folder, and return what it prints."""
    os.chown(folder, NOBODY, NOBODY)
    environment = {
        **{name: os.environ[name] for name in ("PATH", "LANG") if name in os.environ},
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "HOME": str(folder),
        "TMPDIR": str(folder),
        "DRIVEGATE_CACHE": str(folder / "cache"),
    }
    return subprocess.run(
        [sys.executable, __file__, str(folder), *words],
        env=environment,
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=120,
    ).stdout


def _show_to_all(places: Sequence[Path]) -> None:
    """Lay an open folder over each one that other users cannot enter, with what Python needs of it alone.

    Only this process and those that it starts see that.
    """
    is_own = False
    while closed := [folder for place in places for folder in place.parents if not folder.stat().st_mode & 1]:
        if not is_own:
            succeeded(SYSTEM.unshare(_MOUNTS), "unshare")
            _mount(None, "/", None, _RECURSIVE | _PRIVATE)
            is_own = True
        lid = min(closed, key=lambda folder: len(folder.parts))
        inside = [place for place in dict.fromkeys(places) if place.is_relative_to(lid)]
        opened = [(place, os.open(place, os.O_PATH)) for place in inside]
        _mount("tmpfs", str(lid), "tmpfs", 0, "mode=755")
        for place, descriptor in opened:
            if Path(f"/proc/self/fd/{descriptor}").is_dir():
                place.mkdir(parents=True, exist_ok=True)
            elif not place.exists():
                place.parent.mkdir(parents=True, exist_ok=True)
                place.touch()
            _mount(f"/proc/self/fd/{descriptor}", str(place), None, _BIND | _RECURSIVE)


def _become(folder: str, words: Sequence[str]) -> None:
    needed = [*system_places(), sys.executable, __file__, folder, *filter(os.path.isabs, words)]
    exist = [
        Path(form) for place in needed if Path(place).exists() for form in (place, os.path.realpath(place))
    ]
    _show_to_all(sorted(set(exist), key=lambda place: len(place.parts)))
    os.setgroups([])
    os.setgid(NOBODY)
    os.setuid(NOBODY)
    os.execv(sys.executable, [sys.executable, "-P", *words])


if __name__ == "__main__":
    _become(sys.argv[1], sys.argv[2:])
