"""The table `[check]` of a manifest: options of ``drivegate check`` that need not be repeated on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from drivegate_cases.documents.document import Section
from drivegate_cases.documents.reach import Reach
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

_FILES: Final = ("corpus", "waivers", "baseline", "requirements", "output")
"""Keys that name a place in the manifest's folder."""
_FOLDERS: Final = ("corpus", "output")
_Place = Annotated[str, Field(min_length=1)]


class CheckTable(Section):
    """How a candidate is checked where the command line says nothing else."""

    drive: _Place | None = Field(
        default=None, description="drive that it is checked on: the name of one, or the path of its file"
    )
    effort: Literal["quick", "default", "nightly"] | None = Field(
        default=None, description="number of scenarios that are drawn"
    )
    seed: Annotated[int, Field(ge=0, lt=2**63)] | None = Field(default=None, description="seed of the search")
    corpus: _Place | None = Field(default=None, description="folder of counterexamples that are run again")
    waivers: _Place | None = Field(default=None, description="file of failures that are accepted until a day")
    baseline: _Place | None = Field(
        default=None, description="earlier result.json that margins are compared with"
    )
    requirements: _Place | None = Field(
        default=None, description="file of your own requirements, in place of the manifest's"
    )
    output: _Place | None = Field(default=None, description="folder of the report")
    fail_on: Literal["required", "advisory"] | None = Field(
        default=None, description="least level of a check whose failure fails the candidate"
    )
    contested: Literal["pass", "fail"] | None = Field(
        default=None,
        description="whether a failure counts that no known good controller avoids in the same scenario",
    )

    def options(self, reach: Reach) -> dict[str, Any]:
        """Return the values by their option; a manifest must not choose what is read or written elsewhere."""
        from drivegate_cases.drive.drive_document import is_included

        stated = self.model_dump(exclude_none=True)
        for key in _FILES:
            if key in stated:
                place = reach.place(stated[key], f"the key '{key}' of [check]")
                if key != "output" and not place.exists():
                    raise InputError(
                        f"the key '{key}' of [check] names {shown_path(_shown(place))}, which does not exist; name an "
                        "existing one, or leave the key out"
                    )
                _require_kind(key, place)
                stated[key] = _shown(place)
        if self.drive is not None and not is_included(self.drive) and Path(self.drive).suffix:
            stated["drive"] = _shown(reach.place(self.drive, "the key 'drive' of [check]"))
        return stated


def _require_kind(key: str, place: Path) -> None:
    """Refuse a file for a folder, or the other way round."""
    if key in _FOLDERS and place.exists() and not place.is_dir():
        raise InputError(
            f"the key '{key}' of [check] names {shown_path(_shown(place))}, a file; name a folder"
        )
    if key not in _FOLDERS and place.is_dir():
        raise InputError(
            f"the key '{key}' of [check] names {shown_path(_shown(place))}, a folder; name a file in it"
        )


def _shown(place: Path) -> str:
    """Return a path from the present folder, as a person writes it, where it is in there."""
    here = Path.cwd()
    return str(place.relative_to(here) if place.is_relative_to(here) else place)
