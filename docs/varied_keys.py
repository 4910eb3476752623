"""What the runs of a check vary: each field of the contract and each key of a scenario, measured on drawn scenarios."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final, TypeAlias, get_args

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.strategies import SearchStrategy

from drivegate.contracts.current.scenarios.combined import combined_scenarios
from drivegate.contracts.current.scenarios.drawn.families import FAMILY_GROUPS
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.contracts.duty.scenarios.drawn import families as duty
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios as fixed_duty_scenarios
from drivegate.contracts.traceability import FIXED, family_name
from drivegate.scenarios.isolation import from_the_seed_alone
from drivegate_cases.documents.document import Section
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.failure_kind import FAILURE_KINDS
from drivegate_cases.scenario.scenario import Scenario

JOINT: Final = "joint"
"""Name of the runs of joint changes."""
DRAWS: Final = 60
"""Scenarios that are drawn of each family to measure what it varies."""

_NO_PART = "says what a run is called or how it is written, and is no part of it"
_VEHICLE = "part of a vehicle's torque, which its mass, gear and grade vary"
_PUBLISHED = "as in the published implementation; its errors vary with the seed"
_HALL = "of Hall switches, which stars have; the error of each edge varies with the seed"
_DRIVE = "the drive's, which `--drive` names; the plant's own varies by `scales`"
_OWN = "for your own scenarios; the runs vary the load"
_DUTY = "of PM AC drives, whose own runs vary it"

NOT_VARIED: Final[Mapping[str, str]] = {
    "schema": _NO_PART,
    "name": _NO_PART,
    "description": _NO_PART,
    "drive": _DRIVE,
    "link_voltage_v": "it is stored as supply_v",
    "drift.friction_n_m": _OWN,
    **dict.fromkeys(
        (
            "load.wheel_radius_m",
            "load.rolling_resistance",
            "load.drag_area_m2",
            "load.air_density_kg_m3",
        ),
        _VEHICLE,
    ),
    **dict.fromkeys(
        (
            "sensors.encoder_lines",
            "sensors.speed_window_s",
            "sensors.clock_s",
            "sensors.current_range_a",
            "sensors.current_gain_spread",
            "sensors.current_offset_a",
            "sensors.current_noise_a",
            "sensors.voltage_range_v",
            "sensors.voltage_noise_v",
            "sensors.converter_bits",
        ),
        _PUBLISHED,
    ),
    **dict.fromkeys(
        (
            "sensors.shunts",
            "sensors.settling_s",
            "sensors.position",
            "sensors.encoder_error_deg",
            "sensors.eccentricity_deg",
            "sensors.eccentric_from_deg",
            "sensors.sine_offset",
            "sensors.cosine_offset",
            "sensors.track_gain",
            "sensors.track_phase_deg",
            "sensors.latency_s",
        ),
        _DUTY,
    ),
    **dict.fromkeys(
        (
            "load.torque_reference_nm",
            "load.released_s",
            "turns_before",
            "winding_temperature_c",
            "failure.kind",
            "failure.time_s",
            "failure.phase",
            "failure.slip_deg",
            "scales.inertia",
        ),
        _DUTY,
    ),
    **dict.fromkeys(("sensors.placement_error_deg", "sensors.hysteresis_deg"), _HALL),
    **dict.fromkeys(
        (
            "nameplate phases",
            "nameplate pole_pairs",
            "nameplate half_supply_voltage",
            "nameplate base_speed",
            "nameplate rated_power",
            "nameplate current_limit",
            "nameplate hysteresis_band",
            "nameplate resistance",
            "nameplate inductance",
            "nameplate emf_constant",
            "nameplate kind",
            "nameplate window",
            "nameplate conducting_phases",
            "nameplate advance_start",
            "nameplate advance_slope",
            "nameplate highest_speed",
        ),
        _DRIVE,
    ),
}
"""Keys and fields that no family varies, each with the reason."""

SENSED: Final[Mapping[str, tuple[str, ...]]] = {
    "time": ("clock_start_s", "control_period_s", "restarts_s"),
    "speed_reference": ("speed_rpm",),
    "speed": ("initial_speed_rpm", "sensors.kind", "dropouts.signal", "glitches.counts"),
    "phase_currents": (
        "current_errors.gain",
        "current_errors.offset_a",
        "dropouts.phase",
        "initial_angle_deg",
    ),
    "current_magnitude_sum": ("load.factor", "current_errors.gain", "dropouts.signal", "sensors.kind"),
    "half_supply_voltage": ("supply_v", "imbalance", "dropouts.signal", "sensors.kind"),
}
"""For each field of `Sense`, the keys of a scenario that reach it, beside all that moves the plant."""

JUDGED: Final[Mapping[str, tuple[str, ...]]] = {
    "current_reference": ("CMD-1", "CUR-1"),
    "advance_angle": ("ADV-1", "ADV-2"),
    "input_power": ("PWR-2",),
}
"""For each field of `Command`, the checks that judge it; a candidate varies it, not a scenario."""

Value: TypeAlias = float | str
Values: TypeAlias = Mapping[str, set[Value]]


@dataclass(frozen=True)
class Varied:
    """How one key of a scenario, or one field of the contract, varies."""

    key: str
    """The key, with those above it, or the field."""
    families: tuple[str, ...]
    """Families that vary it."""
    values: tuple[Value, ...]
    """Lowest and highest number, or all words."""


def document_keys(model: type[Section] = Scenario, prefix: str = "") -> Iterator[str]:
    """List the keys of a kind of document, and those of its tables."""
    for name, field in model.model_fields.items():
        key = f"{prefix}{field.alias or name}"
        tables = [table for table in _sections(field.annotation) if table is not DriveDocument]
        if not tables:
            yield key
        for table in tables:
            yield from document_keys(table, f"{key}.")


def _sections(annotation: Any) -> list[type[Section]]:
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return [annotation]
    return [section for argument in get_args(annotation) for section in _sections(argument)]


def drawn_by_family(drive: DriveDocument) -> dict[str, list[Scenario]]:
    """Draw scenarios of every family, always the same."""
    if isinstance(drive, PmAcDocument):
        return _drawn_of_pm_ac(drive)
    found = {FIXED: list(fixed_scenarios(drive))}
    for group in FAMILY_GROUPS:
        for family in group:
            found[family_name(family.__name__)] = draws(family(drive, None))
    found[JOINT] = list(combined_scenarios(drive, None, 0))
    return found


def _drawn_of_pm_ac(drive: PmAcDocument) -> dict[str, list[Scenario]]:
    families = dict.fromkeys(
        family for group in duty.FAMILY_GROUPS for family in group if duty.serves(family, drive)
    )
    drawn = {family_name(family.__name__): draws(family(drive)) for family in families}
    return {FIXED: list(fixed_duty_scenarios(drive, detected=FAILURE_KINDS)), **drawn}


def draws(strategy: SearchStrategy[Scenario], count: int = DRAWS, start: int = 0) -> list[Scenario]:
    """Draw scenarios of a strategy, always the same for the same start."""
    drawn: list[Scenario] = []

    @seed(start)
    @settings(
        max_examples=count,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(strategy)
    def draw(scenario: Scenario) -> None:
        drawn.append(scenario)

    with from_the_seed_alone():
        draw()
    return drawn


def values_of(scenarios: Iterable[Scenario]) -> Values:
    """Collect the values that each key takes."""
    found: dict[str, set[Value]] = {}
    for scenario in scenarios:
        nameplate = scenario.nameplate()
        for key, value in _leaves(scenario.to_mapping()):
            found.setdefault(key, set()).add(value)
        for field, value in zip(nameplate._fields, nameplate, strict=True):
            found.setdefault(f"nameplate {field}", set()).add(value)
    return found


def _leaves(value: Any, key: str = "") -> Iterator[tuple[str, Value]]:
    if isinstance(value, Mapping):
        for name, item in value.items():
            if name != "drive":
                yield from _leaves(item, f"{key}.{name}" if key else name)
    elif isinstance(value, list):
        for item in value:
            is_point = isinstance(item, list)
            yield from _leaves(item[1] if is_point else item, key)
    else:
        yield key, value


def varied_keys(by_family: Mapping[str, Iterable[Scenario]]) -> list[Varied]:
    """Find how every key of a scenario, and every field of the nameplate, varies from run to run."""
    measured = {family: values_of(scenarios) for family, scenarios in by_family.items()}
    keys = dict.fromkeys(
        [*document_keys(), *(key for values in measured.values() for key in values if " " in key)]
    )
    return [_varied(key, measured) for key in keys]


def _varied(key: str, measured: Mapping[str, Values]) -> Varied:
    families = tuple(family for family, values in measured.items() if len(values.get(key, set())) > 1)
    every: set[Value] = set().union(*(values.get(key, set()) for values in measured.values()))
    numbers = sorted(value for value in every if not isinstance(value, str))
    words = sorted(value for value in every if isinstance(value, str))
    return Varied(key, families, (numbers[0], numbers[-1]) if numbers else tuple(words))


def unvaried(varied: Iterable[Varied], keys: Iterable[str]) -> list[str]:
    """List the keys that nothing varies and nobody has given a reason for."""
    known = {row.key for row in varied if row.families} | set(NOT_VARIED)
    return [key for key in dict.fromkeys(keys) if key not in known]
