"""Options of ``drivegate check`` that a manifest states, and the command line that repeats the others."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from shlex import join
from typing import TYPE_CHECKING, Any, Final

import click

from drivegate.candidates.kinds import MANIFEST_SUFFIX
from drivegate.commands.options import named_drive

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest
    from drivegate_cases.documents.reach import Reach
    from drivegate_cases.drive.drive_document import DriveDocument

MANIFEST: Final = f"candidate{MANIFEST_SUFFIX}"
"""The manifest that is checked where no candidate is named."""
_CANDIDATES: Final = "candidates"
_OF_ONE_CALL: Final = frozenset(
    {_CANDIDATES, "only", "stop_at_first", "last_failed", "max_time", "quiet", "as_json", "watch", "help"}
)
"""Arguments that say which part of a check is run, or how it is printed; no later call needs them."""
_AGAIN: Final = "drivegate.again"


class CheckCommand(click.Command):
    """A command whose candidate may be the manifest in this folder, and whose defaults may be what it states."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if not ctx.resilient_parsing and not set(args) & {*ctx.help_option_names}:
            given, _, _ = self.make_parser(ctx).parse_args(args=list(args))
            found = given.get(_CANDIDATES)
            # A marker of click stands for none.
            named = tuple(found) if isinstance(found, list | tuple) else ()
            if not named:
                args = [*args, _own_manifest()]
            stated = stated_by([*named, MANIFEST][0], given.get("roots") or ()) if len(named) <= 1 else {}
            ctx.default_map = {**(ctx.default_map or {}), **stated}
            ctx.meta[_AGAIN] = join(["drivegate", "check", *named, *self._words(ctx, given)])
        return super().parse_args(ctx, args)

    def _words(self, ctx: click.Context, given: Mapping[str, Any]) -> Iterator[str]:
        """Write the options again that are on the command line, and that a later call needs too."""
        for option in self.get_params(ctx):
            value = None if option.name in _OF_ONE_CALL else given.get(option.name or "")
            if not isinstance(option, click.Option) or value is None:
                continue
            if option.is_flag:
                yield (option.opts if value else option.secondary_opts)[-1]
            elif isinstance(value, list | tuple):
                yield from (word for each in value for word in (option.opts[-1], str(each)))
            else:
                yield from (option.opts[-1], str(value))


def again() -> str:
    """Return the command line that checks the same again, without what its manifest states."""
    return str(click.get_current_context().meta.get(_AGAIN, "drivegate check"))


def is_stated(option: str) -> bool:
    """Return True if an option has the value that the manifest states."""
    context = click.get_current_context()
    source = context.get_parameter_source(option)
    return source is click.core.ParameterSource.DEFAULT_MAP


def _own_manifest() -> str:
    if not Path(MANIFEST).is_file():
        raise click.UsageError(
            f"a candidate is missing, and there is no {MANIFEST} in this folder; name a controller, such as "
            "drivegate check controller.py:Controller, or write one: drivegate new python NAME"
        )
    return MANIFEST


def stated_by(specification: str, roots: Iterable[str] = ()) -> dict[str, Any]:
    """Return the options that a candidate's manifest states; one that is no manifest states none."""
    found = _read(specification, roots)
    return {} if found is None else found[0].check.options(found[1])


def own_drive() -> DriveDocument | None:
    """Return the drive that the manifest in this folder states; None where there is none, or it states none."""
    found = _read(MANIFEST) if Path(MANIFEST).is_file() else None
    if found is None:
        return None
    manifest, reach = found
    stated = manifest.check.options(reach).get("drive")
    return manifest.drive if stated is None else named_drive(stated)


def _read(specification: str, roots: Iterable[str] = ()) -> tuple[Manifest, Reach] | None:
    """Read a manifest, with the files in its reach; None for any other candidate."""
    file = Path(specification)
    if file.suffix.lower() != MANIFEST_SUFFIX or ":" in specification:
        return None
    # Reading a manifest needs pydantic, which takes longer to import than the rest of this module.
    from drivegate.candidates.manifest import Manifest
    from drivegate.candidates.resolution import reach_of
    from drivegate_cases.documents.document import read_document

    reach = reach_of(file, roots)
    return read_document(file, Manifest, reach), reach
