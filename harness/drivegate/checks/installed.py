"""Checks of the user's in Python, which installed packages offer by entry points.

They run in the judge, with all that it can do: unlike a candidate, such a package is trusted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Final, Literal

from drivegate.candidates.fault import bounded_line
from drivegate.checks.check import Check, Evaluate, NotRun
from drivegate.checks.margin import Margin
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

CHECK_GROUP: Final = "drivegate.checks"
"""The group of entry points."""


@dataclass(frozen=True)
class InstalledCheck:
    """What an entry point of the group names: a check, and whose controllers it judges."""

    contract: Literal["current", "duty"]
    check: Check


@dataclass(frozen=True)
class _Guarded:
    """A function of a package, whose mistakes are reported in a sentence."""

    point: str
    id: str
    evaluate: Evaluate

    def __call__(self, record: Any) -> Margin | None:
        try:
            margin: object = self.evaluate(record)
        except NotRun:
            raise
        except Exception as error:
            what = bounded_line(f"{type(error).__name__}: {error}")
            raise InputError(
                f"the check {self.id} of the entry point '{self.point}' failed ({what}); mend the package, or "
                "uninstall it"
            ) from error
        if margin is None or (isinstance(margin, Margin) and margin.check == self.id):
            return margin
        raise InputError(
            f"the check {self.id} of the entry point '{self.point}' returned {bounded_line(repr(margin))}, but must "
            f'return None or a Margin("{self.id}", …)'
        )


@cache
def installed_checks(contract: str) -> tuple[Check, ...]:
    """Return the checks of installed packages that judge the controllers of a contract, by their names."""
    loaded = [(point, _loaded(point)) for point in _points()]
    return tuple(
        replace(one.check, evaluate=_Guarded(point.name, one.check.id, one.check.evaluate))
        for point, one in loaded
        if one.contract == contract
    )


@cache
def installed_versions() -> dict[str, str]:
    """Return the versions of the packages that offer checks, by their names."""
    packages = (point.dist for point in _points())
    return {package.name: package.version for package in packages if package is not None}


def _points() -> list[EntryPoint]:
    return sorted(entry_points(group=CHECK_GROUP), key=lambda point: point.name)


def _loaded(point: EntryPoint) -> InstalledCheck:
    name = one_line(point.name)
    try:
        found = point.load()
    except Exception as error:
        what = bounded_line(f"{type(error).__name__}: {error}")
        raise InputError(
            f"the entry point '{name}' of {CHECK_GROUP} cannot be loaded ({what}); mend the package, or uninstall it"
        ) from error
    if not isinstance(found, InstalledCheck):
        raise InputError(
            f"the entry point '{name}' of {CHECK_GROUP} names {bounded_line(repr(found))}, but must name an "
            "InstalledCheck"
        )
    return found
