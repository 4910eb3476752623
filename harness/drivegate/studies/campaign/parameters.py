"""The parameters of a run: a value from its distribution, and a case changed as parameters say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drivegate.scenarios.parameters import SCALES, SHARES, SPEED
from drivegate.studies.campaign.file import NormalSpread, Spread
from drivegate_cases.documents.rounding import significant
from drivegate_cases.documents.wording import one_line
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.load import DynamometerLoad, LockedLoad, VehicleLoad
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

_DIGITS = 6


def drawn(spread: Spread, share: float) -> float:
    """Draw a value."""
    if isinstance(spread, NormalSpread):
        from scipy.special import ndtr, ndtri

        low, high = (ndtr((end - spread.mean) / spread.sigma) for end in (spread.lowest, spread.highest))
        value = spread.mean + spread.sigma * float(ndtri(low + share * (high - low)))
    else:
        value = spread.lowest + share * (spread.highest - spread.lowest)
    return min(max(significant(value, _DIGITS), spread.lowest), spread.highest)


def with_parameters(case: Scenario, parameters: Mapping[str, float], *, name: str, seed: int) -> Scenario:
    """Change a case as parameters say."""
    changes: dict[str, Any] = {"name": name[:200], "seed": seed}
    scales = {key: value for key, value in parameters.items() if key in SCALES}
    if scales:
        changes["scales"] = _scaled(case, scales)
    drive = {key: value for key, value in parameters.items() if key not in (*SCALES, *SHARES, SPEED)}
    if drive:
        changes["drive"] = _changed_drive(case, drive)
    if SPEED in parameters:
        changes["initial_speed_rpm"] = parameters[SPEED]
        changes["speed_rpm"] = ((0.0, parameters[SPEED]),)
    if "supply_share" in parameters:
        changes["supply_v"] = _times(case.supply_profile, parameters["supply_share"])
    if "load_share" in parameters:
        changes["load"] = _shared_load(case, parameters["load_share"])
    try:
        return case.replaced(**changes)
    except InputError as error:
        raise InputError(
            f"the case '{one_line(case.name)}' cannot have the parameters of the campaign: {error}"
        ) from error


def _changed_drive(case: Scenario, values: Mapping[str, float]) -> DriveDocument:
    """Set keys of the drive; those of the other contract's drives are known to the file, but not to this one."""
    known = case.drive.table_of_key()
    for key in values:
        if key not in known:
            raise InputError(
                f"the case '{one_line(case.name)}' is of a drive of the kind '{case.drive.kind}', which has no key "
                f"'{key}'; leave it out of the grid, or take cases that have it"
            )
    return case.drive.with_overrides([f"{key}={value:.17g}" for key, value in values.items()])


def _shared_load(case: Scenario, share: float) -> dict[str, Any]:
    """Give a share of the load, or of the torque that a controller on a dynamometer is asked for."""
    load = case.load
    if isinstance(load, DynamometerLoad):
        return {**load.model_dump(), "torque_reference_nm": _times(load.torque_reference_nm, share)}
    if isinstance(load, (LockedLoad, VehicleLoad)):
        raise InputError(
            f"the case '{one_line(case.name)}' has a load of kind '{load.kind}', which has no share; "
            "leave 'load_share' out, or take a case with another load"
        )
    return {**load.model_dump(), "factor": _times(load.factor, share)}


def _scaled(case: Scenario, scales: Mapping[str, float]) -> dict[str, float]:
    own = case.scales.model_dump()
    changed = {
        key: own[key] + value if key == "friction_added_n_m" else own[key] * value
        for key, value in scales.items()
    }
    return {**own, **changed}


def _times(profile: Profile, share: float) -> Profile:
    return tuple((time, value * share) for time, value in profile)
