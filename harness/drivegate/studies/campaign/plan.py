"""The runs of a campaign: which candidate meets which scenario in which run, known from its number alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.contract import ANSWERS
from drivegate.candidates.kinds import WHOLE_FILE_SUFFIXES
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.kinds import require_contract, scenario_at_declared_timing
from drivegate.scenarios.parameters import SCALES, SHARES, SPEED, SPREADABLE
from drivegate.studies.campaign.file import Campaign, NormalSpread, Spread
from drivegate.studies.campaign.row import JUDGED_CHECKS
from drivegate_cases.documents.wording import one_line, significant
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.load import DynamometerLoad, LockedLoad, VehicleLoad
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.reference import reference_of
from drivegate_cases.scenario.scenario import Scenario, load_scenario
from drivegate_models.errors import InputError

_DIGITS = 6
_MANTISSA = 2.0**-53
_MOST_CHECKED = 2_000
_PATH_ENDINGS = (".json", ".py", *WHOLE_FILE_SUFFIXES)


@dataclass(frozen=True)
class CampaignRun:
    """One run, before it is made."""

    number: int
    """Number of the run in the campaign, from 0."""
    case: str
    draw: int
    """Number of the drawn drive at this point of the grid, from 0."""
    seed: int
    """Seed of everything random in the run."""
    parameters: dict[str, float]
    """Value of every parameter that differs between runs."""
    scenario: Scenario
    """The scenario, with all of that in it."""


@dataclass(frozen=True)
class Chunk:
    """Consecutive runs of one candidate, whose results share a file."""

    candidate: int
    """Place of the candidate in the campaign."""
    part: int
    """Number of the file among those of the candidate, from 0."""
    first: int
    """Number of its first run in the campaign."""
    length: int


@dataclass(frozen=True)
class CampaignPlan:
    """A campaign with everything that it names."""

    campaign: Campaign
    candidates: tuple[Candidate, ...]
    """Its candidates, none of whose code has run."""
    cases: tuple[Scenario, ...]

    @property
    def contract(self) -> str:
        """Contract of its candidates, which the drives of all cases take."""
        return self.cases[0].drive.contract

    @property
    def checks(self) -> tuple[str, ...]:
        """Checks that judge every run, in the order of the catalogue."""
        known, requested = JUDGED_CHECKS[self.contract], self.campaign.checks
        return known if requested is None else tuple(name for name in known if name in requested)

    @property
    def runs(self) -> int:
        return len(self.candidates) * self.campaign.runs_per_candidate

    @cached_property
    def _points(self) -> tuple[dict[str, float], ...]:
        grid = self.campaign.grid
        return tuple(dict(zip(grid, values, strict=True)) for values in product(*grid.values()))

    @cached_property
    def places(self) -> tuple[tuple[str, dict[str, float]], ...]:
        """What was chosen, and not drawn: every case with every point of the grid, in the order of the runs."""
        return tuple((case.name, point) for case in self.cases for point in self._points)

    def place_of(self, number: Any) -> Any:
        """Return which of `places` a run is at, or each of many."""
        return (number % self.campaign.runs_per_candidate) // self.campaign.draws

    def chunks(self) -> Iterator[Chunk]:
        """Cut the campaign into the fixed pieces that are made and kept as a whole."""
        runs, length = self.campaign.runs_per_candidate, self.campaign.file_length
        for candidate in range(len(self.candidates)):
            for part, first in enumerate(range(0, runs, length)):
                yield Chunk(candidate, part, candidate * runs + first, min(length, runs - first))

    def run(self, number: int) -> CampaignRun:
        """Return one run.

        Its random numbers depend on the campaign's seed and on its place among the runs of its candidate, so
        that all candidates meet the same drives, and no run depends on another.
        """
        place = number % self.campaign.runs_per_candidate
        at, draw = self.place_of(number), place % self.campaign.draws
        case_place, point = divmod(at, len(self._points))
        case = self.cases[case_place]
        words = np.random.SeedSequence([self.campaign.seed, place]).generate_state(
            1 + len(SPREADABLE), np.uint64
        )
        parameters = self._points[point] | {
            # The upper 53 of 64 random bits make a number between 0 and 1, neither included.
            key: drawn(spread, ((int(words[1 + SPREADABLE.index(key)]) >> 11) + 0.5) * _MANTISSA)
            for key, spread in self.campaign.spread.items()
        }
        seed = int(words[0]) >> 1
        scenario = with_parameters(case, parameters, name=f"{case.name}, run {number}", seed=seed)
        return CampaignRun(number, case.name, draw, seed, parameters, scenario)

    def check_parameters(self) -> None:
        """Refuse a campaign in which a case cannot have the parameters."""
        ends = {key: (spread.lowest, spread.highest) for key, spread in self.campaign.spread.items()}
        for case in self.cases:
            for point in self._points[:_MOST_CHECKED]:
                for place in (0, 1):
                    extremes = {key: end[place] for key, end in ends.items()}
                    with_parameters(case, point | extremes, name=case.name, seed=0)


def planned(campaign: Campaign, folder: Path, drive: DriveDocument | None = None) -> CampaignPlan:
    """Find what a campaign names; a drive that is given takes the place of every case's."""
    candidates = tuple(resolve_candidate(below(text, folder)) for text in campaign.candidates)
    cases = tuple(load_scenario(below(text, folder)) for text in campaign.cases)
    if drive is not None:
        cases = tuple(case.replaced(drive=drive) for case in cases)
    for noun, names in (
        ("candidates", [candidate.name for candidate in candidates]),
        ("cases", [case.name for case in cases]),
    ):
        for place, name in enumerate(names):
            if name in names[:place]:
                raise InputError(
                    f"two {noun} of the campaign are called '{one_line(name)}', but each needs a name of its own"
                )
    plan = CampaignPlan(campaign, candidates, cases)
    _require_one_contract(plan)
    _require_followed_references(plan)
    plan = replace(plan, cases=tuple(scenario_at_declared_timing(case, candidates) for case in cases))
    plan.check_parameters()
    return plan


def _require_one_contract(plan: CampaignPlan) -> None:
    """Refuse cases, candidates and checks that are not of one contract: its checks are the columns of all rows."""
    first = plan.cases[0]
    for case in plan.cases:
        if case.drive.contract != plan.contract:
            raise InputError(
                f"the case '{one_line(case.name)}' is of a drive that takes {ANSWERS[case.drive.contract]}, but "
                f"'{one_line(first.name)}' of one that takes {ANSWERS[plan.contract]}; make a campaign of each"
            )
        for candidate in plan.candidates:
            require_contract(candidate, case.drive)
    for name in plan.campaign.checks or ():
        if name not in plan.checks:
            raise InputError(
                f"the check '{name}' does not judge controllers that answer with {ANSWERS[plan.contract]}, which the "
                f"campaign's cases take; the checks that do are {', '.join(JUDGED_CHECKS[plan.contract])}"
            )


def _require_followed_references(plan: CampaignPlan) -> None:
    """Refuse a case with a reference that a candidate declares not to follow."""
    for case in plan.cases:
        reference = reference_of(case)
        for candidate in plan.candidates:
            if reference not in candidate.declaration.references:
                raise InputError(
                    f"the case '{one_line(case.name)}' has a reference of the {reference}, which the candidate "
                    f"'{one_line(candidate.name)}' declares not to follow; make a campaign of each"
                )


def below(text: str, folder: Path) -> str:
    """Let a relative path start from a folder."""
    path, colon, attribute = text.partition(".py:")
    file = f"{path}.py" if colon else text
    if ":" in file or not file.lower().endswith(_PATH_ENDINGS):
        return text
    return f"{folder / file}:{attribute}" if colon else str(folder / file)


def drawn(spread: Spread, share: float) -> float:
    if isinstance(spread, NormalSpread):
        from scipy.special import ndtr, ndtri

        low, high = (ndtr((end - spread.mean) / spread.sigma) for end in (spread.lowest, spread.highest))
        value = spread.mean + spread.sigma * float(ndtri(low + share * (high - low)))
    else:
        value = spread.lowest + share * (spread.highest - spread.lowest)
    return min(max(significant(value, _DIGITS), spread.lowest), spread.highest)


def with_parameters(case: Scenario, parameters: Mapping[str, float], *, name: str, seed: int) -> Scenario:
    changes: dict[str, Any] = {"name": name[:200], "seed": seed}
    scales = {key: value for key, value in parameters.items() if key in SCALES}
    if scales:
        own = case.scales.model_dump()
        changes["scales"] = own | {
            key: own[key] + value if key == "friction_added_n_m" else own[key] * value
            for key, value in scales.items()
        }
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
    """Return a share of the load, or of the torque that a controller on a dynamometer is asked for."""
    load = case.load
    if isinstance(load, DynamometerLoad):
        return {**load.model_dump(), "torque_reference_nm": _times(load.torque_reference_nm, share)}
    if isinstance(load, (LockedLoad, VehicleLoad)):
        raise InputError(
            f"the case '{one_line(case.name)}' has a load of kind '{load.kind}', which has no share; "
            "leave 'load_share' out, or take a case with another load"
        )
    return {**load.model_dump(), "factor": _times(load.factor, share)}


def _times(profile: Profile, share: float) -> Profile:
    return tuple((time, value * share) for time, value in profile)
