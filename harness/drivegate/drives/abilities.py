"""What drives of each kind can do, and what a check refuses of a drive, with the values that it accepts instead."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

from drivegate.drives.ability import Ability, RunTime
from drivegate.drives.angle_ability import ANGLE_ABILITY
from drivegate.drives.duty_ability import DUTY_ABILITY
from drivegate.drives.kinds import DEFAULT_DRIVE, HALF_BRIDGE, PM_AC, STAR
from drivegate.drives.power_reach import UnreachableRating, setting_words, unreachable_power
from drivegate.drives.required_ripple import UnreachableRipple
from drivegate_cases.documents.wording import rounded_to_digits
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.usual_values import unusual_keys
from drivegate_models.errors import InputError

ABILITIES: Final[Mapping[str, Ability]] = {
    HALF_BRIDGE.name: ANGLE_ABILITY,
    STAR.name: ANGLE_ABILITY,
    PM_AC.name: DUTY_ABILITY,
}


def ability_of(drive: DriveDocument) -> Ability:
    return ABILITIES[drive.kind]


@dataclass(frozen=True)
class TooSlow:
    found: RunTime
    change: Mapping[str, float]
    """A value that a check accepts, by its key."""

    @property
    def accepted(self) -> tuple[Mapping[str, float], ...]:
        return (self.change,)

    def sentence(self) -> str:
        return (
            f"it needs {self.found.time:.3g} s {self.found.until}, but must need at most {self.found.longest:g} s; "
            f"a check accepts {setting_words(self.change)}"
        )

    def document(self) -> dict[str, object]:
        return {
            "key": next(iter(self.change)),
            "message": self.sentence(),
            "needed_time_s": self.found.time,
            "longest_time_s": self.found.longest,
            "accepted": [dict(self.change)],
        }


Refusal: TypeAlias = TooSlow | UnreachableRating | UnreachableRipple
"""A reason why a check refuses a drive, with a sentence about it."""


def unreachable_rating(document: DriveDocument) -> UnreachableRating | None:
    """Find where rated power is out of reach, and the nearest ratings that are not."""
    ability = ability_of(document)
    return unreachable_power(document, ability.reach, ability.accepts)


def refusals(document: DriveDocument) -> tuple[Refusal, ...]:
    """Find every reason why a check refuses a drive: too slow, or required of it what no controller can do."""
    unmet = ability_of(document).unmet(document)
    found = (_too_slow(document), unreachable_rating(document), *unmet)
    return tuple(refusal for refusal in found if refusal is not None)


def refuse_unreachable(document: DriveDocument) -> None:
    """Refuse a drive whose rating or requirements no controller can meet: no candidate is to be failed for it."""
    if document == load_drive(DEFAULT_DRIVE):
        return
    for found in refusals(document):
        if isinstance(found, TooSlow):
            raise InputError(f"the drive '{document.name}' is too slow to be checked: {found.sentence()}")
        suspects = unusual_keys(document)
        # What follows from a wrong unit is no value to write down.
        reason = (
            f"correct {', '.join(suspects)} first, from which that may follow: {next(iter(suspects.values()))}"
            if suspects
            else found.sentence()
        )
        raise InputError(f"no controller can meet what the drive '{document.name}' requires: {reason}")


def _too_slow(document: DriveDocument) -> TooSlow | None:
    run_time = ability_of(document).run_time
    found = run_time(document)
    if found.time <= found.longest:
        return None
    lighter = {"inertia_kg_m2": rounded_to_digits(found.share * document.machine.inertia_kg_m2, up=False)}
    faster = {"base_speed_rpm": rounded_to_digits(document.rating.base_speed_rpm / found.share, up=True)}
    is_enough = run_time(document.replaced(**lighter)).time <= found.longest
    return TooSlow(found, lighter if is_enough else faster)
