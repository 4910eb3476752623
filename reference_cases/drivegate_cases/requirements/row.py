"""One requirement of a user as a row: when, in which window, what quantity, which limit."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, field_validator, model_validator

from drivegate_cases.documents.document import Section
from drivegate_cases.documents.wording import nearest
from drivegate_cases.requirements.quantities import QUANTITIES
from drivegate_cases.requirements.vocabulary import EVENTS, TIME_UNITS, EventName, StatisticName

LONGEST_RUN_S: Final = 86400.0
_MOST_TIMES: Final = 1e9
_ENDS: Final = 2
_UNSIGNED: Final = ("absolute", "peak", "rms", "peak to peak", "time until", "sign changes")

Number = Annotated[float, Field(allow_inf_nan=False)]
Range = tuple[Number, Number]
Window = Annotated[tuple[Annotated[float, Field(ge=0.0, le=_MOST_TIMES)], ...], Field(max_length=_ENDS)]
_Length = Annotated[float, Field(gt=0.0, le=_MOST_TIMES)]


def _ordered(limits: Any) -> Any:
    """Refuse a range that nothing is in."""
    match limits:
        case (float() | int() as low, float() | int() as high) if low > high:
            raise ValueError("must be a range [lowest, highest], but its first value is above its second")
    return limits


OrderedRange = Annotated[Range, BeforeValidator(_ordered)]


class When(Section):
    """The event after which a row is judged, the state in which it is, or both: the state at the event."""

    event: EventName | None = Field(
        default=None, description="event of the scenario; none for as long as the state lasts"
    )
    step_percent: OrderedRange | None = Field(
        default=None,
        description="size of the step in percent of base speed, rated torque or the link's voltage, a range, negative "
        "downward",
    )
    speed_rpm: OrderedRange | None = Field(default=None, description="range of the speed, negative backward")
    torque_nm: OrderedRange | None = Field(default=None, description="range of the torque")
    link_voltage_v: OrderedRange | None = Field(default=None, description="range of the link voltage")
    speed_reference_rpm: OrderedRange | None = Field(
        default=None, description="range of the speed reference; after a step, that of the new one"
    )
    torque_reference_nm: OrderedRange | None = Field(
        default=None, description="range of the torque reference; after a step, that of the new one"
    )
    load_torque_nm: OrderedRange | None = Field(default=None, description="range of the load's torque")
    direction: Literal["forward", "backward"] | None = Field(
        default=None, description="sense in which the shaft turns"
    )
    alone: bool = Field(
        default=True,
        description="whether steps and restarts count only where nothing else changes at once and the drive has had "
        "the time to settle before",
    )

    @model_validator(mode="after")
    def _can_be(self) -> Self:
        if self.step_percent is not None and not (self.event or "").startswith("step of"):
            raise ValueError("must have a step as its event where it has the key 'step_percent'")
        speeds = self.speed_rpm
        if speeds is not None and (
            (self.direction == "forward" and speeds[1] <= 0.0)
            or (self.direction == "backward" and speeds[0] >= 0.0)
        ):
            raise ValueError(
                f"must not contradict itself: at {speeds[0]:g} to {speeds[1]:g} rpm no shaft turns {self.direction}; "
                "speeds backward are negative"
            )
        return self

    def ranges(self) -> dict[str, Range]:
        """Return the ranges of signals that make up the state, by the name of the signal."""
        stated = {name: getattr(self, name) for name in STATE_SIGNALS}
        return {name: limits for name, limits in stated.items() if limits is not None}

    @property
    def has_state(self) -> bool:
        return bool(self.ranges()) or self.direction is not None


STATE_SIGNALS: Final = (
    "speed_rpm",
    "torque_nm",
    "link_voltage_v",
    "speed_reference_rpm",
    "torque_reference_nm",
    "load_torque_nm",
)
"""Keys of `When` that are ranges of signals."""


def _as_table(value: Any) -> Any:
    return {"event": value} if isinstance(value, str) else value


class Row(Section):
    """A requirement that is judged like a check."""

    id: str = Field(
        min_length=1,
        max_length=40,
        pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$",
        description="identifier, such as REQ-12, that reports, waivers and --only use",
    )
    text: str = Field(min_length=1, max_length=500, description="the requirement in one sentence")
    when: Annotated[
        When,
        BeforeValidator(_as_table),
        WithJsonSchema({"anyOf": [{"enum": list(EVENTS)}, When.model_json_schema()]}),
    ] = Field(
        default_factory=When,
        description="event, such as 'step of load', or a table of event and state; left out, all of every run",
    )
    between_s: Window = Field(
        default=(),
        description="begin and end of the judged window after the event, in seconds; the end is optional",
    )
    between_periods: Window = Field(default=(), description="the same in control periods")
    between_settling_times: Window = Field(default=(), description="the same in the drive's settling times")
    between_mechanical_times: Window = Field(
        default=(), description="the same in mechanical time constants, J·ω/T at base speed"
    )
    between_electrical_periods: Window = Field(
        default=(), description="the same in electrical periods at base speed"
    )
    for_s: _Length | None = Field(
        default=None,
        description="length of the stretches that the statistic is taken over, in seconds: a value counts where it "
        "lasts so long, a mean is that of each such stretch",
    )
    for_periods: _Length | None = Field(default=None, description="the same in control periods")
    quantity: str = Field(
        description="what is limited, with its unit, such as speed_deviation_rpm",
        json_schema_extra={"enum": list(QUANTITIES)},
    )
    statistic: StatisticName = Field(default="value", description="what of the quantity is limited")
    until: OrderedRange | None = Field(
        default=None, description="range that 'time until' waits for, in the quantity's unit"
    )
    at_most: Number | None = Field(default=None, description="greatest value that is allowed")
    at_least: Number | None = Field(default=None, description="least value that is allowed")
    within: OrderedRange | None = Field(default=None, description="least and greatest value that are allowed")
    level: Literal["required", "advisory"] = Field(
        default="required", description="whether a failure fails the candidate"
    )

    @field_validator("quantity")
    @classmethod
    def _is_known(cls, name: str) -> str:
        if name not in QUANTITIES:
            raise ValueError(
                f"must be a quantity with its unit, the nearest is '{nearest(name, QUANTITIES)}'; the reference lists "
                "all of them"
            )
        return name

    @field_validator(*(f"between_{unit}" for unit in TIME_UNITS))
    @classmethod
    def _has_a_length(cls, window: tuple[float, ...]) -> tuple[float, ...]:
        if len(window) == _ENDS and window[0] >= window[1]:
            raise ValueError("must be a window [begin, end] whose begin is before its end")
        return window

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        self._check_limits()
        windows = [f"between_{unit}" for unit in TIME_UNITS if getattr(self, f"between_{unit}")]
        for keys in (windows, [key for key in ("for_s", "for_periods") if getattr(self, key) is not None]):
            if len(keys) > 1:
                raise ValueError(f"{self.id} states {' and '.join(keys)}, but must state one of them")
        if (self.statistic == "time until") is (self.until is None):
            raise ValueError(
                f"{self.id} must state 'until', the range that the quantity has to reach, for the statistic "
                "'time until', and for no other"
            )
        begin, end = self.window[1]
        length = self.for_s if self.window[0] == "s" else None
        if length is not None and end is not None and length > end - begin:
            raise ValueError(
                f"{self.id} has a for_s of {length:g} s, but its window is only {end - begin:g} s long"
            )
        return self

    def _check_limits(self) -> None:
        stated = [key for key in ("at_most", "at_least", "within") if getattr(self, key) is not None]
        if len(stated) != 1:
            what = " and ".join(stated) or "no limit"
            raise ValueError(
                f"{self.id} states {what}, but must state exactly one of 'at_most', 'at_least' and 'within'"
            )
        low, high = self.limits
        if low is not None and low == high:
            raise ValueError(f"{self.id} is met by {low:g} alone; state a range that a real drive can be in")
        if self.statistic in _UNSIGNED and high is not None and high < 0.0:
            raise ValueError(
                f"{self.id} can never be met: the statistic '{self.statistic}' is never below 0, but its limit is "
                f"{high:g}"
            )
        if self.statistic == "time until" and high is not None and high > LONGEST_RUN_S:
            raise ValueError(f"{self.id} allows {high:g} s, but a run lasts {LONGEST_RUN_S:g} s at most")

    @property
    def limits(self) -> tuple[float | None, float | None]:
        """Least and greatest value that are allowed; None for no limit."""
        return self.within if self.within is not None else (self.at_least, self.at_most)

    @property
    def window(self) -> tuple[str, tuple[float, float | None]]:
        """Unit of the window's times, its begin, and its end where it has one."""
        for unit in TIME_UNITS:
            match getattr(self, f"between_{unit}"):
                case (begin, end):
                    return unit, (begin, end)
                case (begin,):
                    return unit, (begin, None)
        return "s", (0.0, None)
