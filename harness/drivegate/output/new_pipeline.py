"""Where the pipeline of a new candidate goes: into its folder, or where the repository around it runs pipelines."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Final

from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

_WORKFLOWS: Final = Path(".github/workflows")
_ACTION: Final = ".github/actions/drivegate/action.yml"
_GITLAB: Final = ".gitlab-ci.yml"
_TEMPLATES: Final = ("workflow.yml", "action.yml", "gitlab.yml")
"""Names of the pipelines' files among the templates, where they mean nothing to the tools of this repository."""
_UNQUOTED: Final = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_./-]*")
_IS: Final = MappingProxyType(
    {
        "action.yml": "what the gate does there, step by step",
        "workflow.yml": "the gate in continuous integration",
        "gitlab.yml": "the gate in continuous integration",
    }
)


@dataclass(frozen=True)
class Pipeline:
    """The files of a pipeline, and how they name the candidate's."""

    places: Mapping[str, Path]
    """Path of each template's file; a relative one is in the candidate's folder."""
    here: str = ""
    """From the top of the repository to the candidate's folder, with a slash at its end; empty if they are the same."""
    hint: str | None = None
    """What is left to do; None for nothing."""

    @property
    def left_out(self) -> frozenset[str]:
        """The templates that are not written."""
        return frozenset(_TEMPLATES) - frozenset(self.places)

    def rows(self) -> str:
        """Return the rows of the table of files in a README."""
        named = {template: place for template, place in self.places.items() if not place.is_absolute()}
        return "".join(f"| `{place}` | {_IS[template]} |\n" for template, place in named.items())


def pipeline_for(service: str, folder: Path, name: str) -> Pipeline:
    """Choose the files of a pipeline; none of them exists."""
    if service == "none":
        return Pipeline({})
    root = _repository_around(folder)
    here = "" if root is None else f"{folder.resolve().relative_to(root).as_posix()}/"
    if here and not _UNQUOTED.fullmatch(here):
        raise InputError(
            f"{shown_path(folder)} cannot be named in a pipeline: its path in the repository has other "
            "characters than letters, digits and '_-./'; name another folder with --output, or give --ci none"
        )
    if service == "gitlab":
        return _on_gitlab(root, here)
    if root is None:
        return Pipeline({"workflow.yml": _WORKFLOWS / "drivegate.yml", "action.yml": Path(_ACTION)})
    names = ("drivegate.yml", f"drivegate-{name}.yml")
    free = [place for file in names if not (place := root / _WORKFLOWS / file).exists()]
    if not free:
        raise InputError(
            f"{shown_path(root / _WORKFLOWS)} has {' and '.join(names)} already, and nothing is ever overwritten; "
            "choose another name, or give --ci none"
        )
    return Pipeline({"workflow.yml": free[0], "action.yml": Path(_ACTION)}, here)


def _on_gitlab(root: Path | None, here: str) -> Pipeline:
    if root is None or (root / _GITLAB).exists():
        hint = f"add to {_GITLAB}: include: [{{local: {here}{_GITLAB}}}]" if root else None
        return Pipeline({"gitlab.yml": Path(_GITLAB)}, here, hint)
    return Pipeline({"gitlab.yml": root / _GITLAB}, here)


def _repository_around(folder: Path) -> Path | None:
    """Find the top of the Git repository that a new folder will be in."""
    for parent in folder.resolve().parents:
        if (parent / ".git").exists():
            return parent
    return None
