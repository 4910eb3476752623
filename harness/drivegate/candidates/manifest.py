"""The manifest `candidate.toml`: what a candidate is made of, and what it declares of itself."""

from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from drivegate.candidates.check_table import CheckTable
from drivegate.candidates.contract import ContractName
from drivegate.candidates.contract_keys import refuse_other_keys
from drivegate.candidates.declaration import Declaration, FlowchartProfile
from drivegate.candidates.kinds import KINDS
from drivegate_cases.documents.document import Document, Section
from drivegate_cases.documents.reach import Reach
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_cases.drive.drive_document import DriveReference
from drivegate_cases.drive.pm_ac.inverter import MOST_CARRIERS
from drivegate_cases.scenario.failure_kind import FailureKind
from drivegate_cases.scenario.reference import FollowedReference
from drivegate_models.errors import InputError
from drivegate_models.pm_ac.modulation_kind import ModulationKind
from drivegate_models.units import RADIANS_PER_RPM

# A type checker cannot read a Literal that is made of the registry.
if TYPE_CHECKING:
    KindName = str
else:
    KindName = Literal[tuple(KINDS)]

_KINDS_OF_KEY = {
    key: tuple(other.name for other in KINDS.values() if key in other.manifest_keys)
    for kind in KINDS.values()
    for key in kind.manifest_keys
}

Text = Annotated[str, Field(min_length=1)]
Positive = Annotated[float, Field(gt=0)]
Address = Annotated[int, Field(ge=0, lt=2**32)]
Size = Annotated[int, Field(gt=0, le=2**24)]
Value = Annotated[str, Field(min_length=1)] | Annotated[float, Field(allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0)]


class Flowchart(Section):
    """The constants of a candidate whose search follows the paper's flowchart (Fig. 4) to the letter."""

    k1_rpm: Positive = Field(description="greatest speed error at which the search is active")
    k2_w: NotNegative | None = Field(
        default=None, description="change of input power at or below which the search stops"
    )
    k2_percent: NotNegative | None = Field(
        default=None, lt=100, description="the same as a percentage of the new input power"
    )
    step_deg: Positive = Field(le=90, description="magnitude of one change of the advance angle")
    period_s: Positive = Field(description="time from one decision of the search to the next")

    @model_validator(mode="after")
    def _has_one_power_tolerance(self) -> Self:
        if (self.k2_w is None) == (self.k2_percent is None):
            raise ValueError("must give exactly one of 'k2_w' and 'k2_percent'")
        return self

    def profile(self) -> FlowchartProfile:
        """Return the constants in SI units."""
        return FlowchartProfile(
            speed_tolerance=self.k1_rpm * RADIANS_PER_RPM,
            power_tolerance=self.k2_w or 0.0,
            power_tolerance_fraction=(self.k2_percent or 0.0) / 100,
            step=radians(self.step_deg),
            period=self.period_s,
        )


class StubTable(Section):
    """A function of an image that does not run."""

    returns: Value = Field(default=0.0, description="what it returns")
    fills: dict[Text, Value] = Field(
        default={},
        description="what it writes, such as 'data[0]' = 'angle_counts >> 8' through its parameter 'data'",
    )


class Manifest(Document):
    """A candidate of any kind, described in a file."""

    name: Text = Field(description="name of the candidate, which waivers match")
    kind: KindName = Field(description="kind of candidate")
    entry: Text = Field(description="class, function, file or command to start the candidate by")
    sources: tuple[Text, ...] = Field(
        default=(), description="files that the candidate's hash covers, or patterns such as 'src/**/*.c'"
    )
    build: tuple[Text, ...] = Field(
        default=(),
        max_length=16,
        description="commands that make the entry from the sources, such as 'cargo build --release'",
    )
    include: tuple[Text, ...] = Field(default=(), description="folders of headers")
    flags: tuple[Text, ...] = Field(default=(), description="further flags of the compiler")
    profile: Literal["outcome", "flowchart"] = Field(
        default="outcome", description="whether the candidate follows Fig. 4 step by step"
    )
    flowchart: Flowchart | None = Field(default=None, description="constants of the profile 'flowchart'")
    estimates_power: bool = Field(
        default=False, description="whether commands carry an estimate of input power"
    )
    power_window_s: NotNegative = Field(
        default=0.0,
        le=10.0,
        description="time over which that estimate is a mean, in seconds; 0 for the last control period alone",
    )
    speed_range_rpm: tuple[NotNegative, Positive] | None = Field(
        default=None, description="lowest and highest speed that the candidate is made for"
    )
    contract: ContractName | None = Field(
        default=None,
        description="what the candidate answers with: 'current', a current reference and an advance angle, or 'duty', "
        "duty ratios",
    )
    references: tuple[FollowedReference, ...] = Field(
        default=("speed", "torque"),
        description="what a candidate that answers with duty ratios follows: 'speed', 'torque' or both, or 'current' "
        "alone, a q current",
    )
    detects: tuple[FailureKind, ...] = Field(
        default=(),
        description="failures that a candidate that answers with duty ratios brings its drive into a safe state for: "
        "'open-phase', 'stuck-current', 'lost-position', 'locked-rotor', 'slip', and 'lost-edge', after which it may "
        "also keep the torque",
    )
    reverses: bool = Field(
        default=True,
        description="whether a candidate that answers with duty ratios also turns the shaft backward",
    )
    reads_enable: bool = Field(
        default=False,
        description="whether runs of a candidate that answers with duty ratios begin with the bridge off",
    )
    calibration_time_s: NotNegative = Field(
        default=0.0,
        le=0.5,
        description="time at standstill with the bridge off before each run, in seconds, to measure current offsets",
    )
    current_bandwidth_rad_s: Annotated[float, Field(gt=0, le=1e6)] | None = Field(
        default=None,
        description="bandwidth of the current regulators of a candidate that answers with duty ratios, in radians a "
        "second, which its steps are judged by; the drive's rise_periods where it is left out",
    )
    control_every: Annotated[int, Field(ge=1, le=MOST_CARRIERS)] | None = Field(
        default=None,
        description="carrier periods from one step to the next of a candidate that answers with duty ratios, by "
        "default those of the drive; the duty ratios hold in all of them",
    )
    update_delay: Literal[0, 1] | None = Field(
        default=None,
        description="control periods from a step to the one in which its duty ratios act, by "
        "default those of the drive; 0 if they act in the period of the sample",
    )
    modulation: ModulationKind = Field(
        default="continuous",
        description="kind of modulation of a candidate that answers with duty ratios, by whose ideal its torque ripple "
        "is judged: 'continuous', or 'dpwm-min', 'dpwm-max', 'dpwm-0' to 'dpwm-3', which clamp a leg",
    )
    drive: DriveReference | None = Field(
        default=None,
        description="drive that the candidate is made for: the name of one, or the path of its file",
    )
    check: CheckTable = Field(
        default=CheckTable(),
        description="options of drivegate check, such as effort = 'quick', where the command line has no other",
    )
    requirements: Text | None = Field(
        default=None,
        description="file of your own requirements, which the candidate is judged by besides the checks",
    )
    step_deadline_s: Positive | None = Field(
        default=None, le=30.0, description="time that a program has for each step, in seconds"
    )
    start: Text | tuple[Text, ...] = Field(
        default=(), description="function of an image that is called before each reset, or a list of them"
    )
    ram: tuple[tuple[Address, Size], ...] = Field(
        default=(), max_length=64, description="address and size of further memory of an image, in bytes"
    )
    step_instructions: Annotated[int, Field(gt=0, le=2**31)] | None = Field(
        default=None,
        description="greatest number of instructions of an image that a step may execute, those that a condition skips "
        "included",
    )
    step_cycles: Annotated[int, Field(gt=0, le=2**31)] | None = Field(
        default=None,
        description="greatest number of cycles of an image for a Cortex-M4 that a step may take, without wait states",
    )
    stack_bytes: Annotated[int, Field(gt=0, le=2**16)] | None = Field(
        default=None, description="greatest depth of an image's stack in a step, in bytes"
    )
    step: Text | None = Field(
        default=None,
        description="function of an image that is called in each control period; it needs no adapter, but [read]",
    )
    peripherals: dict[Text, Text] = Field(
        default={}, description="names for places in an image, such as TIM1 = 'TIM_TypeDef(0x40010000)'"
    )
    write: dict[Text, Value] = Field(
        default={},
        description="variables of an image that are written before each step, and values such as '2048 + 12.4 * "
        "phase_currents[0]', from fields of the Sense and from nameplate.resistance and the like; before 'start' too, "
        "with the drive at rest",
    )
    read: dict[Text, Value] = Field(
        default={},
        description="fields of the Command, and values such as 'TIM1.CCR1 / TIM1.ARR', from variables of an image",
    )
    once: dict[Text, Value] = Field(
        default={},
        description="variables of an image that are written before each function of 'start' and after the last, and "
        "then no more in a run, as in [write] with the drive at rest",
    )
    pause: Text | None = Field(
        default=None,
        description="function at whose call a step of an image ends and goes on at the next one, for a 'step' that "
        "never returns, such as main; or 'wfi', the instruction",
    )
    stub: dict[Text, Value | StubTable] = Field(
        default={},
        description="functions of an image that do not run, and what they return, from the same names as in [write] "
        "and the function's parameters; or a table with 'returns' and 'fills'",
    )

    @model_validator(mode="after")
    def _profile_and_constants_agree(self) -> Self:
        if self.profile == "flowchart" and self.flowchart is None:
            raise ValueError("the profile 'flowchart' needs a table [flowchart] with its constants")
        if self.profile == "outcome" and self.flowchart is not None:
            raise ValueError(
                "the table [flowchart] needs the profile 'flowchart', but the profile is 'outcome'"
            )
        return self

    @model_validator(mode="after")
    def _has_no_key_of_another_kind(self) -> Self:
        for key, kinds in _KINDS_OF_KEY.items():
            if getattr(self, key) and self.kind not in kinds:
                *others, last = (f"'{kind}'" for kind in kinds)
                named = " and ".join(filter(None, (", ".join(others), last)))
                raise ValueError(
                    f"the key '{key}' is for the kind{'s' if len(kinds) > 1 else ''} {named}, but the kind is "
                    f"'{self.kind}'"
                )
        return self

    @model_validator(mode="after")
    def _has_the_keys_that_others_need(self) -> Self:
        if self.build and not self.sources:
            raise ValueError("the key 'build' needs 'sources', the files that the commands may read")
        if self.step is not None and not (self.read and self.contract):
            raise ValueError("the key 'step' needs a table [read] and the key 'contract'")
        for key in ("peripherals", "write", "once", "read", "stub"):
            if getattr(self, key) and self.step is None:
                raise ValueError(f"the table [{key}] needs the key 'step', the function that is called")
        if self.pause is not None and self.step is None:
            raise ValueError("the key 'pause' needs the key 'step', the function that never returns")
        if self.power_window_s and not self.estimates_power:
            raise ValueError("the key 'power_window_s' needs 'estimates_power = true'")
        if self.calibration_time_s and not self.reads_enable:
            raise ValueError("the key 'calibration_time_s' needs 'reads_enable = true'")
        return self

    @model_validator(mode="after")
    def _references_fit_the_contract(self) -> Self:
        if not self.references:
            raise ValueError(
                "the key 'references' is empty, but must name 'speed', 'torque' or both, or 'current'"
            )
        if "current" in self.references and (len(self.references) > 1 or self.detects):
            other = "'detects'" if self.detects else "a further reference"
            raise ValueError(
                f"the key 'references' names 'current', which excludes {other}; such a candidate is run on q currents "
                "alone, without failures"
            )
        try:
            refuse_other_keys(self.declaration(), self.contract)
        except InputError as error:
            raise ValueError(str(error)) from error
        return self

    @model_validator(mode="after")
    def _speed_range_rises(self) -> Self:
        if self.speed_range_rpm is not None and self.speed_range_rpm[0] >= self.speed_range_rpm[1]:
            raise ValueError("the key 'speed_range_rpm' must give the lowest speed first, then a higher one")
        return self

    def files(self, specification: str, reach: Reach) -> tuple[Path, tuple[Path, ...]]:
        """Find the file that the entry is, whose suffix is the kind's, and the further sources.

        What is built need not exist.
        """
        kind, suffix = KINDS[self.kind], Path(self.entry).suffix.lower()
        suffixes = kind.suffixes
        if suffix not in suffixes and not (kind.may_lack_suffix and suffix == ""):
            raise InputError(
                f"{shown_path(specification)}: the key 'entry' is '{one_line(self.entry)}', but for the kind "
                f"'{self.kind}' must be a file *{' or *'.join(suffixes)}"
            )
        found = reach.place if self.build else reach.file
        return found(self.entry, "the key 'entry'"), self.source_files(reach)

    def source_files(self, reach: Reach) -> tuple[Path, ...]:
        """Find the further sources, those that a pattern such as ``src/**/*.c`` matches in the order of their names."""
        files: dict[Path, None] = {}
        for source in self.sources:
            if set(source) & set("*?["):
                files |= dict.fromkeys(reach.files_matching(source, "'sources'"))
            else:
                files[reach.file(source, "a file of the key 'sources'")] = None
        return tuple(files)

    def declaration(self) -> Declaration:
        """What the candidate declares of itself, in SI units."""
        return Declaration(
            None if self.flowchart is None else self.flowchart.profile(),
            self.estimates_power,
            self.speed_range_rpm,
            self.power_window_s,
            self.references,
            self.detects,
            self.reverses,
            self.reads_enable,
            self.calibration_time_s,
            self.current_bandwidth_rad_s,
            self.control_every,
            self.update_delay,
            self.modulation,
        )
