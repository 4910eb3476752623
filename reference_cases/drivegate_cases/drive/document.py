"""The drive as data, and what the plant and a controller know of it."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, Self, TypeAlias, get_args

from pydantic import Field, field_validator, model_validator

from drivegate_cases.documents.document import Document, Section, parse_document
from drivegate_cases.documents.reading import parse_overrides
from drivegate_cases.documents.wording import nearest, nearest_key, one_line, shown
from drivegate_cases.drive.advance import Advance, advance_line
from drivegate_cases.drive.data_sheet import (
    Provenance,
    check_continuous_current,
    check_provenance,
    completed,
    following,
)
from drivegate_cases.drive.plant import NOMINAL, OF_SHAPE, Inverter, Machine, Scales, plant_constants
from drivegate_cases.drive.rating import Rating
from drivegate_cases.drive.requirements import NO_REQUIREMENTS, Requirements, check_points
from drivegate_cases.drive.usual_values import UsualRange, ranges_of_current_fed
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate_models.contract.current.signals import Nameplate
    from drivegate_models.steady.plant import AnyDrive

Position: TypeAlias = Literal["exact", "encoder", "hall", "none"]
"""The plant's own angle without error, an encoder, three Hall switches, or no sensor on the shaft."""
HIGHEST_CHOPPING_FREQUENCY_HZ = 10e6
PM_AC: Final = "pm-ac"
"""Kind of drive that has a document of its own, `pm_ac.document.PmAcDocument`."""
SPLIT_SUPPLY: Final = "half-bridge"
"""Kind of drive whose phases are between legs and the tap of a split supply."""

_KIND_NUMBERS: Final = {"half-bridge": 1, "star": 2}
"""The contract's number of each kind of drive."""

_OF_PM_AC: Final = f'for drives of the kind "{PM_AC}"'
_FEWEST_OF_STAR: Final = 3
_PHASES_OF_HALL: Final = 3
_MOST_NAMED: Final = 6


_OWN_DOCUMENTS: Final[dict[str, type[DriveDocument]]] = {}
"""Documents of kinds that have one of their own."""


class DriveDocument(Document):
    """A machine with its supply, inverter, current regulators and rating."""

    tables: ClassVar[Mapping[str, type[Section]]] = {
        "machine": Machine,
        "inverter": Inverter,
        "rating": Rating,
        "advance": Advance,
        "requirements": Requirements,
    }
    contract: ClassVar[str] = "current"
    """Contract of the controllers: what they answer with."""
    sensor_kinds: ClassVar[tuple[str, ...]] = ("ideal", "mcs96", "hall")
    """Kinds of sensors that such a drive can have."""
    excluded: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("failure", "turns_before", "winding_temperature_c"), _OF_PM_AC
    )
    """Keys of a scenario that are for other drives, with those that they are for."""
    excluded_loads: ClassVar[Mapping[str, str]] = {
        "dynamometer": f"{_OF_PM_AC}, whose controllers take a torque reference",
        "hoist": f"{_OF_PM_AC}, whose shaft may be driven",
    }
    """Kinds of load that are for other drives, with those that they are for."""

    name: str = Field(min_length=1, max_length=200, description="name of the drive")
    kind: Literal["half-bridge", "star", "pm-ac"] = Field(
        description='kind of drive: "half-bridge", decoupled phases on half-bridge legs at a split supply, "star", '
        'star-connected phases with an isolated neutral on such legs, or "pm-ac", which has tables of its own'
    )
    machine: Machine = Field(description="table of the windings, their EMF, and the shaft")
    inverter: Inverter = Field(description="table of the supply, the current regulators and the devices")
    rating: Rating = Field(description="table of power, current and speeds that the drive is made for")
    advance: Advance | None = Field(
        default=None,
        description="table of the line of initial advance angles over speed; computed where it is left out",
    )
    requirements: Requirements = Field(
        default=NO_REQUIREMENTS, description="table of the limits that controllers are judged by"
    )
    provenance: Provenance = Field(
        default_factory=dict,
        description="table that says where the values come from, one sentence for each key of each table",
    )

    @model_validator(mode="before")
    @classmethod
    def _keys_stand_in_their_tables(cls, values: Any) -> Any:
        """Refuse a key outside its table, and state where it belongs; an unknown one is refused with the nearest."""
        if isinstance(values, Mapping):
            tables = cls.table_of_key()
            other = cls.of_kind({"kind": PM_AC})
            for table in other.tables:
                if values.get(table) is not None and table not in cls.tables:
                    raise ValueError(f'the table [{table}] is for drives of the kind "{PM_AC}"; leave it out')
            for place in ("", *cls.tables):
                keys = values.get(place) if place else values
                for key in keys if isinstance(keys, Mapping) else ():
                    table = tables.get(key, place)
                    if table != place:
                        raise ValueError(
                            f"the key '{place and place + '.'}{key}' belongs in the table [{table}]"
                        )
                    if key not in tables and place in cls.tables:
                        cls._refuse_other_kinds_key(place, key, values.get("kind"))
        return values

    @model_validator(mode="before")
    @classmethod
    def _rating_follows_from_its_currents(cls, values: Any) -> Any:
        """Fill in what of the rating follows from the currents of a data sheet."""
        return completed(values, cls.model_validate) if isinstance(values, Mapping) else values

    @model_validator(mode="before")
    @classmethod
    def _kind_is_known(cls, values: Any) -> Any:
        """Refuse an unknown kind alone: nothing else can be judged, since the tables depend on it."""
        # Pydantic runs the validator that is defined last before the others.
        kind = values.get("kind") if isinstance(values, Mapping) else None
        known = tuple(
            dict.fromkeys((*get_args(DriveDocument.model_fields["kind"].annotation), *_OWN_DOCUMENTS))
        )
        if isinstance(kind, str) and kind not in known:
            raise ValueError(
                f"the key 'kind' is {shown(kind)}, but must be {', '.join(map(repr, known[:-1]))} or {known[-1]!r}; "
                f"the nearest is '{nearest(kind, known)}'"
            )
        return values

    @classmethod
    def _refuse_other_kinds_key(cls, place: str, key: str, kind: object) -> None:
        """Refuse a key that the same table of another kind of drive has."""
        other = cls.of_kind({"kind": PM_AC}) if cls is DriveDocument else DriveDocument
        is_known = kind in get_args(cls.model_fields["kind"].annotation)
        if is_known and other.table_of_key().get(key) == place:
            own = [name for name in cls.tables[place].model_fields if name not in other.table_of_key()]
            raise ValueError(
                f"the key '{place}.{key}' is for other kinds of drives; the kind {shown(kind)} has "
                f"{', '.join(own[:_MOST_NAMED])}{' and others' * (len(own) > _MOST_NAMED)} instead"
            )

    @field_validator("provenance")
    @classmethod
    def _provenance_is_of_keys(cls, provenance: Provenance) -> Provenance:
        keys = {name: tuple(table.model_fields) for name, table in cls.tables.items()}
        return check_provenance(provenance, keys)

    @classmethod
    def of_kind(cls, values: Mapping[str, Any]) -> type[DriveDocument]:
        """Choose the document of the kind that is named; a kind that is not known is refused by this one."""
        kind = values.get("kind")
        return _OWN_DOCUMENTS.get(kind, cls) if isinstance(kind, str) else cls

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Enter a document that is made for some kinds of drives, so that it is chosen for them."""
        _OWN_DOCUMENTS.update(dict.fromkeys(get_args(cls.model_fields["kind"].annotation), cls))

    @classmethod
    def table_of_key(cls) -> Mapping[str, str]:
        """Return the table of each key; a key is in one only, so that it may go without its table's name."""
        return _table_of_key(cls)

    @model_validator(mode="after")
    def _tables_fit_together(self) -> Self:
        self.check_tables()
        check_continuous_current(self)
        return self

    def check_tables(self) -> None:
        band, limit = self.inverter.hysteresis_band_a, self.rating.current_limit_a
        if band > limit:
            raise ValueError(
                f"the key 'inverter.hysteresis_band_a' is {band:g}, but must be at most the current limit of "
                f"{limit:g} A"
            )
        self._check_kind()
        check_points(self.requirements, self.rating)
        self._check_chopping()

    def _check_kind(self) -> None:
        phases = self.machine.phases
        if self.kind == "star" and (phases < _FEWEST_OF_STAR or phases % 2 == 0):
            raise ValueError(
                f"the key 'machine.phases' is {phases}, but must be odd and at least {_FEWEST_OF_STAR} in a star"
            )
        if self.kind != "star" and self.inverter.regulation is not None:
            raise ValueError(
                "the key 'inverter.regulation' is for the kind \"star\"; decoupled phases chop in every half"
            )

    def _check_chopping(self) -> None:
        """Refuse a band that the current crosses faster than any device could follow.

        With no EMF the current moves by V/L a second, so it crosses the half-width h up and down V/(2 L h)
        times a second; the plant solves each crossing, and its work grows with them.
        """
        band = self.inverter.hysteresis_band_a
        if band == 0.0:
            return
        slew_rate = self.inverter.supply_voltage_v / self.machine.inductance_h
        narrowest = slew_rate / (2.0 * HIGHEST_CHOPPING_FREQUENCY_HZ)
        if band < narrowest:
            raise ValueError(
                f"the key 'inverter.hysteresis_band_a' is {band}, but with this supply and "
                f"machine.inductance_h must be at least {narrowest:.3g}, so that it chops at no more than 10 MHz"
            )

    def __hash__(self) -> int:
        """Hash the values; the provenance, a table, is left out."""
        return hash(
            (
                self.name,
                self.kind,
                self.machine,
                self.inverter,
                self.rating,
                self.advance,
                self.requirements,
            )
        )

    @property
    def may_be_held(self) -> bool:
        """Whether a dynamometer may hold its shaft, so that a controller follows a torque."""
        return "dynamometer" not in self.excluded_loads

    @property
    def values_hash(self) -> str:
        """SHA-256 of all values, in hexadecimal: equal for two drives that differ in name and provenance alone."""
        values = self.model_dump(mode="json", include={"kind", *self.tables}, exclude_none=True)
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()

    def identity(self) -> dict[str, str]:
        """Return name, kind and hash, by which results identify their drive."""
        return {"name": self.name, "kind": self.kind, "hash": self.values_hash}

    @property
    def has_split_supply(self) -> bool:
        """Whether its phases are between legs and the tap of a split supply, whose halves may differ."""
        return self.kind == SPLIT_SUPPLY

    @property
    def real_sensors(self) -> str:
        """Kind of the sensors that it has where they are not ideal.

        A star of three phases is commutated by Hall switches, as conventional brushless DC drives are; any other has
        the encoder of the published implementation.
        """
        has_switches = self.kind == "star" and self.machine.phases == _PHASES_OF_HALL
        return "hall" if has_switches else "mcs96"

    @property
    def one_way_because(self) -> str | None:
        """Return why its shaft never turns backward, in a clause; None where it may."""
        return f'a drive of the kind "{self.kind}" turns forward alone'

    @property
    def position(self) -> Position:
        """What shows the shaft in every run."""
        return "exact"

    @property
    def control_period_s(self) -> float | None:
        """Time between two steps of the controller where the drive itself states it (s)."""
        return None

    def usual_ranges(self) -> tuple[tuple[UsualRange, ...], ...]:
        """Return the ranges that only a wrong unit leaves, those first that others are measured by."""
        return ranges_of_current_fed(self)

    def value(self, key: str) -> Any:
        if key not in self.table_of_key():
            raise InputError(
                f"the drive '{one_line(self.name)}' has no key {shown(key)}; "
                f"{nearest_key(str(key), self.table_of_key())}"
            )
        return getattr(getattr(self, self.table_of_key()[key]), key)

    def replaced(self, **changes: Any) -> Self:
        """Make a drive that differs in a few keys, of any table, checked like any other."""
        return super().replaced(**self._with_tables(changes))

    def _with_tables(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """Put keys into their tables, beside what these hold now."""
        tables = self.table_of_key()
        if "emf_shape" in changes and "emf_shape" in tables:
            others = {
                key: absent for key, (shape, absent) in OF_SHAPE.items() if shape != changes["emf_shape"]
            }
            changes = {**others, **changes}
        top = {key: value for key, value in changes.items() if key not in tables}
        for key, value in changes.items():
            if (table := tables.get(key)) is not None:
                section = getattr(self, table)
                top.setdefault(table, {} if section is None else section.model_dump())[key] = value
        return top

    def with_overrides(self, pairs: Sequence[str]) -> DriveDocument:
        """Set single values from the command line, by ``table.key`` or by the bare key."""
        if not pairs:
            return self
        tables = self.table_of_key()
        given = parse_overrides(
            pairs, ("name", *tables, *(f"{table}.{key}" for key, table in tables.items()))
        )
        values = {key.rpartition(".")[2]: value for key, value in given.items()}
        mapping = self.to_mapping() | self._with_tables(values)
        # What follows from other values follows from the new ones.
        left_out = set(following(self)) - set(values)
        mapping["rating"] = {key: value for key, value in mapping["rating"].items() if key not in left_out}
        sources = {table: dict(sentences) for table, sentences in self.provenance.items()}
        for key in values:
            if key in tables:
                sources.setdefault(tables[key], {})[key] = "set on the command line"
        return parse_document(
            mapping | {"provenance": sources}, DriveDocument, "--set " + " --set ".join(pairs)
        )

    def torque_of_current(self, current: float) -> float:
        """Return the most torque of a peak phase current (A) while the voltage is ample (N·m)."""
        conducting = self.machine.phases * self.inverter.window_deg / 180.0
        return conducting * self.machine.emf_constant_v_s_per_rad * current

    def greatest_torque(self, current: float, speed: float) -> float:
        """Return the greatest torque within a current limit (A) and the supply, at a speed (rad/s); in N·m."""
        from drivegate_models.steady.oracle import greatest_torque_at_limit

        ideal = self.plant()._replace(current_limit=current, hysteresis_band=0.0)
        return float(greatest_torque_at_limit(ideal, speed).torque)

    def plant(self, scales: Scales | None = None) -> AnyDrive:
        """Make the plant's parameters, in SI units."""
        limit = self.rating.current_limit_a
        return plant_constants(self.kind, self.machine, self.inverter, limit, scales or NOMINAL)

    def nameplate(self, control_period: float) -> Nameplate:
        """Make what a controller is given before a run, in SI units."""
        from drivegate_models.contract.current.signals import Nameplate

        window = math.radians(self.inverter.window_deg)
        start, slope = advance_line(self)
        return Nameplate(
            phases=self.machine.phases,
            pole_pairs=self.machine.pole_pairs,
            half_supply_voltage=self.inverter.supply_voltage_v,
            base_speed=self.rating.base_speed_rpm * RADIANS_PER_RPM,
            rated_power=self.rating.rated_power_w,
            current_limit=self.rating.current_limit_a,
            control_period=control_period,
            hysteresis_band=self.inverter.hysteresis_band_a,
            resistance=self.machine.resistance_ohm,
            inductance=self.machine.inductance_h,
            emf_constant=self.machine.emf_constant_v_s_per_rad,
            inertia=self.machine.inertia_kg_m2,
            kind=_KIND_NUMBERS[self.kind],
            window=window,
            conducting_phases=self.machine.phases * window / math.pi,
            advance_start=start,
            advance_slope=slope,
            highest_speed=self.rating.highest_speed_rpm * RADIANS_PER_RPM,
        )


@lru_cache
def _table_of_key(document: type[DriveDocument]) -> Mapping[str, str]:
    return {key: name for name, table in document.tables.items() for key in table.model_fields}


TABLE_KEYS: Final = tuple(DriveDocument.table_of_key())
"""Keys of all tables of the kinds that are given a current reference, by their bare names."""
