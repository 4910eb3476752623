"""What is between plant and controller: ideal sensors, or those that a kind of drive has."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from drivegate_cases.documents.document import Section
from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.document import Position
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import nearest_step

EDGES_A_LINE: Final = 4
"""Edges of a line of an encoder (1)."""
_CURRENT_RANGE = 1.54
_CURRENT_OFFSET = 0.0019
_CURRENT_NOISE = 0.00077
_VOLTAGE_RANGE = 2.08
_VOLTAGE_NOISE = 0.00042
EncoderLines = Annotated[int, Field(ge=1, le=1_000_000, description="lines of the quadrature encoder a turn")]
SpeedWindow = Annotated[
    float, Field(ge=1e-5, le=1.0, description="time over which encoder edges are counted, in seconds")
]
PlacementError = Annotated[
    float,
    Field(
        ge=0.0,
        le=15.0,
        description="greatest error of an edge's place, in electrical degrees; that of each of the six is drawn",
    ),
]
Hysteresis = Annotated[
    float,
    Field(
        ge=0.0,
        le=15.0,
        description="by how much every edge comes later in the sense of rotation, in electrical degrees",
    ),
]
TrackOffset = Annotated[float, Field(ge=-0.2, le=0.2, description="offset of the track over its amplitude")]
"""Offset of the sine or the cosine that a position sensor has one period of in a turn."""
ClockResolution = Annotated[
    float, Field(gt=0.0, le=1e-3, description="resolution of the edges' times, in seconds")
]
CurrentRange = Annotated[
    float | None,
    Field(
        gt=0.0,
        le=1e6,
        description="greatest current that the converter shows, in amperes, by default 1.54 times the current limit",
    ),
]
"""Range of the converter of currents; left out, that of a converter chosen for the drive, as the others here."""
CurrentGainSpread = Annotated[
    float, Field(ge=0.0, le=0.5, description="greatest error of a current sensor's gain, as a share")
]
CurrentOffset = Annotated[
    float | None,
    Field(
        ge=0.0,
        le=1e3,
        description="greatest offset of a current sensor, in amperes, by default 0.19 % of the current limit",
    ),
]
CurrentNoise = Annotated[
    float | None,
    Field(
        ge=0.0,
        le=1e3,
        description="standard deviation of a current sensor's noise, in amperes, by default 0.077 % of the limit",
    ),
]
VoltageRange = Annotated[
    float | None,
    Field(
        gt=0.0,
        le=1e6,
        description="greatest half-supply voltage shown, in volts, by default 2.08 times the supply",
    ),
]
VoltageNoise = Annotated[
    float | None,
    Field(
        ge=0.0,
        le=1e3,
        description="standard deviation of the voltage's noise, in volts, by default 0.042 % of the supply",
    ),
]
ConverterBits = Annotated[int, Field(ge=4, le=24, description="bits of the converter")]


class IdealSensors(Section):
    """Sensors that show the plant as it is, without delay."""

    kind: Literal["ideal"] = Field(description="kind of sensors")


class Mcs96Sensors(Section):
    """Encoder, Hall sensors and converter of a microcontroller of the MCS-96 family (paper, Fig. 8).

    The speed comes from encoder edges timed by the high-speed inputs' clock, the currents and the supply through
    an analogue-to-digital converter. Each phase's gain and offset are drawn once a run from the scenario's seed.
    Ranges and errors that are left out are those of converters chosen for the drive.
    """

    kind: Literal["mcs96"] = Field(description="kind of sensors")
    encoder_lines: EncoderLines = 500
    speed_window_s: SpeedWindow = 0.005
    clock_s: ClockResolution = 1e-6
    current_range_a: CurrentRange = None
    current_gain_spread: CurrentGainSpread = 0.005
    current_offset_a: CurrentOffset = None
    current_noise_a: CurrentNoise = None
    voltage_range_v: VoltageRange = None
    voltage_noise_v: VoltageNoise = None
    converter_bits: ConverterBits = 10


class HallSensors(Section):
    """Three Hall switches, as conventional brushless DC drives have, and the converter of `mcs96`.

    Six edges an electrical cycle give the speed, and the angle that the inverter's windows rest on. The errors of
    their placement are drawn once a run from the scenario's seed, and so are each phase's gain and offset. What the
    errors are by default is assumed.
    """

    kind: Literal["hall"] = Field(description="kind of sensors")
    placement_error_deg: PlacementError = 1.5
    hysteresis_deg: Hysteresis = 1.0
    clock_s: ClockResolution = 1e-6
    current_range_a: CurrentRange = None
    current_gain_spread: CurrentGainSpread = 0.005
    current_offset_a: CurrentOffset = None
    current_noise_a: CurrentNoise = None
    voltage_range_v: VoltageRange = None
    voltage_noise_v: VoltageNoise = None
    converter_bits: ConverterBits = 10


_ACTS_WITH: Final[Mapping[str, tuple[str, tuple[str, ...]]]] = {
    "settling_s": ("shunts", ("low-side", "link")),
    **dict.fromkeys(("encoder_lines", "encoder_error_deg", "speed_window_s"), ("position", ("encoder",))),
    **dict.fromkeys(("placement_error_deg", "hysteresis_deg"), ("position", ("hall",))),
    "clock_s": ("position", ("encoder", "hall")),
    **dict.fromkeys(
        (
            "eccentricity_deg",
            "eccentric_from_deg",
            "sine_offset",
            "cosine_offset",
            "track_gain",
            "track_phase_deg",
            "latency_s",
        ),
        ("position", ("exact",)),
    ),
}
"""Keys of shunts that act only with some values of another key."""


class ShuntSensors(Section):
    """Shunts, an encoder or Hall switches, and converters, as drives have that are given duty ratios.

    A shunt below a lower switch, or in the link, sees a phase's current only in part of a control period. Each phase's
    gain and offset, and the errors of Hall switches, are drawn once a run from the scenario's seed.
    """

    kind: Literal["shunts"] = Field(description="kind of sensors")
    shunts: Literal["in-line", "low-side", "link"] = Field(
        default="in-line",
        description="where the shunts are: one in each phase, below each lower switch, or one in the dc link",
    )
    settling_s: float = Field(
        default=1e-6,
        ge=0.0,
        le=1e-3,
        description="time that a current must have flowed through a shunt to be seen, in seconds",
    )
    position: Position | None = Field(
        default=None,
        description="what shows angle and speed of the shaft, by default what the drive's `[sensing]` states, or else "
        "an encoder",
    )
    encoder_lines: EncoderLines = 1024
    encoder_error_deg: float = Field(
        default=0.0,
        ge=-45.0,
        le=45.0,
        description="error of the encoder's alignment, in electrical degrees",
    )
    speed_window_s: SpeedWindow = 0.002
    placement_error_deg: PlacementError = 1.5
    hysteresis_deg: Hysteresis = 1.0
    eccentricity_deg: float = Field(
        default=0.0,
        ge=0.0,
        le=5.0,
        description="greatest error of the angle by an eccentric sensor, once a turn, in degrees of the shaft",
    )
    eccentric_from_deg: float = Field(
        default=0.0,
        ge=0.0,
        lt=360.0,
        description="angle of the shaft at which that error is 0 and rises, in degrees",
    )
    sine_offset: TrackOffset = 0.0
    cosine_offset: TrackOffset = 0.0
    track_gain: float = Field(
        default=0.0,
        ge=-0.2,
        le=0.2,
        description="amplitude of the sine track over that of the cosine track, less 1",
    )
    track_phase_deg: float = Field(
        default=0.0,
        ge=-10.0,
        le=10.0,
        description="angle by which the sine track is ahead of its place, in degrees of the shaft",
    )
    latency_s: float = Field(
        default=0.0, ge=0.0, le=1e-3, description="age of the angle and the speed that are shown, in seconds"
    )
    clock_s: ClockResolution = 1e-7
    current_range_a: CurrentRange = None
    current_gain_spread: CurrentGainSpread = 0.005
    current_offset_a: CurrentOffset = None
    current_noise_a: CurrentNoise = None
    voltage_range_v: VoltageRange = None
    voltage_noise_v: VoltageNoise = None
    converter_bits: ConverterBits = 12

    @model_validator(mode="after")
    def _stated_keys_act(self) -> Self:
        if (idle := _key_without_effect(self)) is not None:
            raise ValueError(idle)
        return self


def _key_without_effect(sensors: ShuntSensors) -> str | None:
    """Return the sentence that refuses a key which does not act with the values of the others."""
    for key, (other, values) in _ACTS_WITH.items():
        value, chosen = getattr(sensors, key), getattr(sensors, other)
        # A default that is written out, as in a stored scenario, is as good as one that is left out. What is left to
        # the drive is known once the sensors are fitted to it.
        if chosen is not None and chosen not in values and value != type(sensors).model_fields[key].default:
            others = "' or '".join(values)
            return (
                f"the key '{key}' is {value:g}, but must be left out where '{other}' is '{chosen}'; it acts only "
                f"with '{others}'"
            )
    return None


def _by_kind(value: Any) -> Any:
    """Take a bare name for the sensors of that kind with all their defaults."""
    return {"kind": value} if isinstance(value, str) else value


Sensors = Annotated[
    Annotated[IdealSensors | Mcs96Sensors | HallSensors | ShuntSensors, Field(discriminator="kind")],
    BeforeValidator(_by_kind),
]
"""Sensors of a run, also given as a bare name."""

IDEAL = IdealSensors(kind="ideal")
MCS96 = Mcs96Sensors(kind="mcs96")
HALL = HallSensors(kind="hall")
SHUNTS = ShuntSensors(kind="shunts")
PLAIN: Final[Mapping[str, Sensors]] = {plain.kind: plain for plain in (IDEAL, MCS96, HALL, SHUNTS)}
"""The sensors of each kind with all their defaults."""
_PHASES_OF_HALL = 3


def real_sensors(drive: DriveDocument) -> Sensors:
    """Return the sensors that a drive has where they are not ideal."""
    return PLAIN[drive.real_sensors]


def position_of(sensors: Sensors, drive: DriveDocument) -> Position:
    """Return what shows the shaft to a controller of duty ratios."""
    if not isinstance(sensors, ShuntSensors):
        return drive.position
    return sensors.position or ("encoder" if drive.position == "exact" else drive.position)


def has_encoder(sensors: Sensors, drive: DriveDocument) -> bool:
    """Return True if the speed comes from an encoder, whose counter may see false edges."""
    return isinstance(sensors, Mcs96Sensors) or position_of(sensors, drive) == "encoder"


def has_edges(sensors: Sensors, drive: DriveDocument) -> bool:
    """Return True if a controller of duty ratios sees the shaft by the edges of an encoder or of Hall switches."""
    return position_of(sensors, drive) in ("encoder", "hall")


def counted_s(sensors: Mcs96Sensors | HallSensors | ShuntSensors, electrical_speed: float) -> float:
    """Return the time over which edges are counted for the speed (s): the encoder's own, or an electrical cycle."""
    return 2.0 * math.pi / electrical_speed if isinstance(sensors, HallSensors) else sensors.speed_window_s


def refusal(sensors: Sensors, drive: DriveDocument) -> str | None:
    """State why a drive cannot have such sensors, if so.

    Three switches show the angle of any rotor to 60 degrees, which is where the windows of three phases open and close,
    whether they are connected in a star or not; those of any other number of phases lie between the edges.
    """
    if sensors.kind not in drive.sensor_kinds:
        *others, last = drive.sensor_kinds
        own = f"{', '.join(others)} or {last}"
        return f"the sensors '{sensors.kind}' are for other kinds of drives; one of the kind \"{drive.kind}\" has {own}"
    stated = drive.position
    if isinstance(sensors, ShuntSensors) and sensors.position == "none" != stated:
        return "its 'position' is 'none', but the drive has a sensor; its [sensing] may state position = \"none\""
    if isinstance(sensors, ShuntSensors) and stated not in ("exact", position_of(sensors, drive)):
        return f"its 'position' is '{sensors.position}', but the drive's [sensing] states '{stated}' for every run"
    if isinstance(sensors, ShuntSensors):
        return _key_without_effect(sensors)
    phases = drive.machine.phases
    if not isinstance(sensors, HallSensors) or phases == _PHASES_OF_HALL:
        return None
    return f"the sensors 'hall' are three switches for a drive with 3 phases, but this one has {phases}"


def fitted(sensors: Sensors, drive: DriveDocument) -> Sensors:
    """Take what follows from the drive where nothing is stated."""
    own = _of_drive(sensors, drive)
    return sensors.model_copy(
        update={key: value for key, value in own.items() if getattr(sensors, key) is None}
    )


def unfitted(sensors: Sensors, drive: DriveDocument) -> Sensors:
    """Leave out what follows from the drive."""
    own = _of_drive(sensors, drive)
    same = [key for key, value in own.items() if getattr(sensors, key) == value]
    return sensors.model_copy(update=dict.fromkeys(same))


def _of_drive(sensors: Sensors, drive: DriveDocument) -> dict[str, Any]:
    """Return the ranges and errors of the drive's converters, and what shows its shaft."""
    if isinstance(sensors, IdealSensors):
        return {}
    own = asdict(converter_ranges(drive))
    return own | {"position": position_of(SHUNTS, drive)} if isinstance(sensors, ShuntSensors) else own


@dataclass(frozen=True)
class ConverterRanges:
    """What converters chosen for a drive show of it: 40 A and 100 V on the paper's, the same shares on any other."""

    current_range_a: float
    """Greatest current shown (A): half as much again as the current limit, and a little."""
    current_offset_a: float
    current_noise_a: float
    """Greatest offset of a current sensor, and standard deviation of its noise (A): about 0.2 % and 0.08 % of
    the current limit."""
    voltage_range_v: float
    voltage_noise_v: float
    """Greatest voltage shown, and standard deviation of its noise (V): about twice the voltage of each half
    of the supply, and 0.04 % of it."""


def converter_ranges(drive: DriveDocument) -> ConverterRanges:
    limit, supply = drive.rating.current_limit_a, drive.inverter.supply_voltage_v
    return ConverterRanges(
        current_range_a=significant(_CURRENT_RANGE * limit, 2),
        current_offset_a=nearest_step(_CURRENT_OFFSET * limit),
        current_noise_a=nearest_step(_CURRENT_NOISE * limit),
        voltage_range_v=significant(_VOLTAGE_RANGE * supply, 2),
        voltage_noise_v=nearest_step(_VOLTAGE_NOISE * supply),
    )
