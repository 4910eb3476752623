"""What this process holds and has started beside its templates, which stay for the next test."""

import os
from pathlib import Path

import psutil

from drivegate.containment.templates import TEMPLATES


def template_ids() -> set[int]:
    """Return the process ids of the templates."""
    return {template.pid for template in TEMPLATES.started()}


def template_files() -> set[int]:
    """Return the descriptors of the connections to the templates."""
    return {template.descriptor for template in TEMPLATES.started()} - {-1}


def children() -> list[psutil.Process]:
    """List the processes that came from this one; those that came from a template are among them."""
    found = psutil.Process().children(recursive=True)
    return [child for child in found if child.pid not in template_ids()]


def copies() -> list[int]:
    """List the copies of this process's templates, wherever they are in the tree, with what they have forked.

    The system lists them with the words and the environment of their template.
    """
    mark = str(os.getpid()).encode()
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            words = (place / "cmdline").read_bytes()
        except OSError:
            continue
        if b"offer_copies" in words and mark in words.split(b"\0"):
            found.append(int(place.name))
    return [number for number in found if number not in template_ids()]


def connections() -> list[str]:
    """List this process's pipes, sockets and shared memory."""
    left_out = template_files()
    places = [place for place in Path("/proc/self/fd").iterdir() if int(place.name) not in left_out]
    opened = (str(place.readlink()) for place in places if place.is_symlink())
    return sorted(name for name in opened if name.startswith(("pipe:", "socket:", "/memfd:")))
