"""The PM AC drive as data, and what its plant and a controller of duty ratios know of it."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, pi, radians
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Literal, Self, get_args

from pydantic import Field, field_validator, model_validator

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.document import DriveDocument, Position
from drivegate_cases.drive.plant import (
    NOMINAL,
    CoreLossConductance,
    Friction,
    Inertia,
    PolePairs,
    Resistance,
    Scales,
    ViscousFriction,
)
from drivegate_cases.drive.pm_ac.inverter import UPDATES, PmAcInverter
from drivegate_cases.drive.pm_ac.limits import GREATEST_ANGLE_DEG
from drivegate_cases.drive.pm_ac.link import PmAcLink
from drivegate_cases.drive.pm_ac.requirements import NO_PM_AC_REQUIREMENTS, PmAcRequirements
from drivegate_cases.drive.pm_ac.sensorless import least_speed_rpm, natural_period_s, start_time_s
from drivegate_cases.drive.pm_ac.thermal import PmAcThermal
from drivegate_cases.drive.pm_ac.usual_values import ranges_of_pm_ac
from drivegate_cases.drive.rating import HIGHEST_SPEED_RPM, Rating
from drivegate_cases.drive.usual_values import UsualRange
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate_models.contract.duty.signals import DutyNameplate
    from drivegate_models.pm_ac.plant.dc_link import DcLink
    from drivegate_models.pm_ac.plant.drive import PmAcDrive

_PHASES = 3
POSITIONS: Final[tuple[Position, ...]] = get_args(Position)
"""What may show the shaft; the place of each is the contract's number of it."""

_Inductance = Annotated[float, Field(gt=0.0, le=1e6)]


class PmAcMachine(Section):
    """A star of three sinusoidal phases with an isolated neutral; quantities of the rotor's frame are peak values."""

    pole_pairs: PolePairs
    resistance_ohm: Resistance
    direct_inductance_h: _Inductance = Field(description="inductance along the magnet's axis, L_d, in henry")
    quadrature_inductance_h: _Inductance = Field(description="inductance across it, L_q, in henry")
    magnet_flux_v_s: float = Field(
        gt=0.0, le=1e6, description="peak flux linkage of one phase by the magnet, in volt seconds"
    )
    core_loss_conductance_s: CoreLossConductance = 0.0
    inertia_kg_m2: Inertia
    friction_n_m: Friction = 0.0
    viscous_friction_n_m_s_per_rad: ViscousFriction = 0.0

    @property
    def phases(self) -> int:
        return _PHASES

    @property
    def emf_shape(self) -> str:
        """Shape of the EMF, by the name that the machines have which can have others."""
        return "sine"


class PmAcRating(Rating):
    """Power, current and speeds, and whether the shaft may turn backward."""

    needs_weakening: ClassVar[bool] = False
    reverses: bool | None = Field(
        default=None,
        description="whether controllers are also run backward, by default true; false for a drive that turns one way",
    )


class PmAcSensing(Section):
    """The sensor on the shaft that the drive always has."""

    position: Position = Field(
        description='what shows angle and speed of the shaft in every run: "exact", without error, "encoder", "hall" '
        'or "none", for a drive without a sensor'
    )
    least_speed_rpm: float | None = Field(
        default=None,
        gt=0.0,
        le=HIGHEST_SPEED_RPM,
        description="speed from which on the shaft must run steadily without a sensor, in turns a minute; by default "
        "from dead time and resistance",
    )
    start_time_s: float | None = Field(
        default=None,
        gt=0.0,
        le=60.0,
        description="time from standstill to least_speed_rpm under half of rated torque without a sensor, in seconds; "
        "by default from inertia and current limit",
    )
    mean_voltages: bool = Field(
        default=False,
        description="whether controllers see the means of the terminals' voltages over each control period",
    )
    voltage_filter_hz: float | None = Field(
        default=None,
        gt=0.0,
        le=1e6,
        description="cut-off frequency of a filter of one pole that these means pass, in hertz; none where it is left "
        "out",
    )

    @model_validator(mode="after")
    def _filter_has_voltages(self) -> Self:
        if self.voltage_filter_hz is not None and not self.mean_voltages:
            raise ValueError(
                f"the key 'voltage_filter_hz' is {self.voltage_filter_hz:g}, but must be left out without "
                "'mean_voltages = true'; it filters these voltages"
            )
        return self

    @property
    def voltage_filter_s(self) -> float:
        """Time constant of the filter of the means of the terminals' voltages (s); 0 without one."""
        return 0.0 if self.voltage_filter_hz is None else 0.5 / (pi * self.voltage_filter_hz)

    @model_validator(mode="after")
    def _start_is_without_a_sensor(self) -> Self:
        for key in ("least_speed_rpm", "start_time_s"):
            if self.position != "none" and (value := getattr(self, key)) is not None:
                raise ValueError(
                    f"the key '{key}' is {value:g}, but must be left out where 'position' is '{self.position}'; it is "
                    "for a drive without a sensor"
                )
        return self


class PmAcDocument(DriveDocument):
    """A machine of the rotor's frame with its bridge, modulator and rating.

    Its tables are others than those of the kinds that are given a current reference; what all kinds have in common
    has the same names: pole pairs, resistance, inertia, phases, supply and rating.
    """

    tables: ClassVar[Mapping[str, type[Section]]] = {
        "machine": PmAcMachine,
        "inverter": PmAcInverter,
        "rating": PmAcRating,
        "sensing": PmAcSensing,
        "link": PmAcLink,
        "thermal": PmAcThermal,
        "requirements": PmAcRequirements,
    }

    contract: ClassVar[str] = "duty"
    sensor_kinds: ClassVar[tuple[str, ...]] = ("ideal", "shunts")
    excluded: ClassVar[Mapping[str, str]] = {"current_errors": "for other kinds of drives"}
    excluded_loads: ClassVar[Mapping[str, str]] = {}

    kind: Literal["pm-ac"] = Field(
        description='kind of drive: "pm-ac", a d-q machine on a two-level bridge that is given duty ratios'
    )
    # Not of the base's types, which type checkers would want: those who are given any kind use what both have.
    machine: PmAcMachine = Field(  # type: ignore[assignment]
        description="table of the windings in the rotor's frame, and the shaft"
    )
    inverter: PmAcInverter = Field(  # type: ignore[assignment]
        description="table of the dc link, the bridge and the modulator"
    )
    rating: PmAcRating = Field(description="table of power, current and speeds that the drive is made for")
    advance: None = Field(default=None, description="a line of advance angles is for other kinds")
    sensing: PmAcSensing | None = Field(
        default=None,
        description="table of what every run shows of the shaft; angle and speed without error where it is left out",
    )
    link: PmAcLink | None = Field(
        default=None,
        description="table of the capacitor and the source of the dc link; an ideal source where it is left out",
    )
    thermal: PmAcThermal | None = Field(
        default=None,
        description="table of the temperature of the windings; their resistance is constant where it is left out",
    )
    requirements: PmAcRequirements = Field(  # type: ignore[assignment]
        default=NO_PM_AC_REQUIREMENTS, description="table of the limits that controllers are judged by"
    )

    @field_validator("advance", mode="before")
    @classmethod
    def _has_no_advance(cls, advance: object) -> None:
        if advance is not None:
            raise ValueError("must be left out, since a drive of duty ratios has no advance angle")

    # Pydantic makes a hash of its own for a frozen model that defines none.
    __hash__ = DriveDocument.__hash__

    def check_tables(self) -> None:
        """Refuse a link or thermal data that do not fit the drive, and what it cannot do without a sensor."""
        if self.link is not None:
            self.link.check_fit(self.machine, self.inverter, self.rating)
        if self.thermal is not None:
            self.thermal.check_fit(self.machine, self.inverter, self.rating)
        self._check_start()
        self._check_filter()

    def _check_filter(self) -> None:
        """Refuse a filter of voltages that is faster than a control period, which it would not filter."""
        highest = 0.5 / (pi * self.control_period_s)
        given = None if self.sensing is None else self.sensing.voltage_filter_hz
        if given is not None and given > highest:
            raise ValueError(
                f"the key 'voltage_filter_hz' is {given:g}, but must be at most {highest:.4g}, where the filter is as "
                "slow as a control period"
            )

    def _check_start(self) -> None:
        sensing = self.sensing
        if sensing is None or sensing.position != "none":
            return
        least, base = sensing.least_speed_rpm, self.rating.base_speed_rpm
        if least is not None and least > base:
            raise ValueError(
                f"the key 'least_speed_rpm' is {least:g}, but must be at most the base speed of {base:g} rpm"
            )
        shortest = natural_period_s(self)
        if sensing.start_time_s is not None and sensing.start_time_s < shortest:
            raise ValueError(
                f"the key 'start_time_s' is {sensing.start_time_s:g}, but must be at least {shortest:.3g}, the period "
                "in which the rotor swings about the current of a start"
            )

    @property
    def real_link(self) -> PmAcLink | None:
        """The link, unless it is ideal."""
        return None if self.link is None or self.link.source == "ideal" else self.link

    @property
    def control_period_s(self) -> float:
        return self.inverter.control_period_s

    @property
    def weakens(self) -> bool:
        """Whether its controllers weaken the field: its highest speed is above base speed."""
        return self.rating.highest_speed_rpm > self.rating.base_speed_rpm

    @property
    def one_way_because(self) -> str | None:
        return (
            "the key 'reverses' in the drive's [rating] is false" if self.rating.reverses is False else None
        )

    @property
    def real_sensors(self) -> str:
        return "shunts"

    @property
    def position(self) -> Position:
        return "exact" if self.sensing is None else self.sensing.position

    @property
    def has_sensor(self) -> bool:
        """Whether anything shows the shaft to a controller."""
        return self.position != "none"

    @property
    def least_speed_rpm(self) -> float:
        """Speed from which on the shaft must run steadily without a sensor (rpm); 0 with one."""
        if self.sensing is None or self.has_sensor:
            return 0.0
        return self.sensing.least_speed_rpm or least_speed_rpm(self)

    @property
    def start_time_s(self) -> float:
        """Time from standstill to that speed under half of rated torque (s); 0 with a sensor."""
        if self.sensing is None or self.has_sensor:
            return 0.0
        return self.sensing.start_time_s or start_time_s(self, self.least_speed_rpm)

    def usual_ranges(self) -> tuple[tuple[UsualRange, ...], ...]:
        return ranges_of_pm_ac(self)

    def torque_of_current(self, current: float) -> float:
        from drivegate_models.pm_ac.fundamental import most_torque_per_ampere, steady_state

        plant = self.plant()
        return float(steady_state(plant, 0.0, *most_torque_per_ampere(plant, current)).torque)

    def greatest_torque(self, current: float, speed: float) -> float:
        from drivegate_cases.drive.pm_ac.greatest_torque import greatest_within
        from drivegate_models.pm_ac.oracle import undistorted_limits

        plant = self.plant()._replace(current_limit=current)
        torque = greatest_within(plant, undistorted_limits(plant), speed, weakens=self.weakens).torque
        return torque if isfinite(torque) else 0.0

    def plant(self, scales: Scales | None = None) -> PmAcDrive:  # type: ignore[override]
        from drivegate_models.pm_ac.plant.drive import Modulator, make_pm_ac_drive

        differs = scales or NOMINAL
        machine, inverter = self.machine, self.inverter
        return make_pm_ac_drive(
            pole_pairs=machine.pole_pairs,
            modulator=Modulator(
                UPDATES[inverter.carrier],
                inverter.update_delay,
                inverter.counter_levels,
                inverter.dead_time_s,
                inverter.minimum_pulse_s,
                inverter.control_every or 1,
            ),
            resistance=machine.resistance_ohm * differs.resistance,
            magnet_flux=machine.magnet_flux_v_s * differs.emf_constant,
            direct_inductance=machine.direct_inductance_h * differs.inductance,
            quadrature_inductance=machine.quadrature_inductance_h * differs.inductance,
            link_voltage=inverter.link_voltage_v,
            current_limit=self.rating.current_limit_a,
            core_loss_conductance=machine.core_loss_conductance_s,
            inertia=machine.inertia_kg_m2 * differs.inertia,
            friction=machine.friction_n_m + differs.friction_added_n_m,
            viscous_friction=machine.viscous_friction_n_m_s_per_rad,
            switch_drop=inverter.switch_drop_v,
            diode_drop=inverter.diode_drop_v,
            dc_link=self._dc_link(),
        )

    def _dc_link(self) -> DcLink:
        from drivegate_models.pm_ac.plant.dc_link import DcLink

        nominal = self.inverter.link_voltage_v
        link = self.real_link
        return DcLink() if link is None else link.plant(nominal, self.rating.rated_power_w / nominal)

    def nameplate(self, control_period: float) -> Any:
        return self.duty_nameplate(control_period, torque_reference=False)

    def duty_nameplate(self, control_period: float, *, torque_reference: bool) -> DutyNameplate:
        """Make what a controller is given before a run, in SI units."""
        from drivegate_models.contract.current.signals import PM_AC
        from drivegate_models.contract.duty.signals import SPEED_REFERENCE, TORQUE_REFERENCE, DutyNameplate

        machine, inverter, rating = self.machine, self.inverter, self.rating
        link = self._dc_link()
        return DutyNameplate(
            kind=PM_AC,
            reference_kind=TORQUE_REFERENCE if torque_reference else SPEED_REFERENCE,
            pole_pairs=machine.pole_pairs,
            updates=UPDATES[inverter.carrier],
            update_delay=inverter.update_delay,
            supply_voltage=inverter.link_voltage_v,
            base_speed=rating.base_speed_rpm * RADIANS_PER_RPM,
            highest_speed=rating.highest_speed_rpm * RADIANS_PER_RPM,
            rated_power=rating.rated_power_w,
            current_limit=rating.current_limit_a,
            control_period=control_period,
            dead_time=inverter.dead_time_s,
            resistance=machine.resistance_ohm,
            direct_inductance=machine.direct_inductance_h,
            quadrature_inductance=machine.quadrature_inductance_h,
            magnet_flux=machine.magnet_flux_v_s,
            inertia=machine.inertia_kg_m2,
            core_loss_conductance=machine.core_loss_conductance_s,
            control_every=inverter.control_every or 1,
            switch_drop=inverter.switch_drop_v,
            diode_drop=inverter.diode_drop_v,
            position_error=radians(GREATEST_ANGLE_DEG[self.position]),
            link_capacitance=link.capacitance,
            source_resistance=link.source_resistance,
            link_limit=link.limit,
            charge_limit=link.charge_limit,
            discharge_limit=link.discharge_limit,
            chopper_voltage=link.chopper_on,
            chopper_resistance=1.0 / link.chopper_conductance if link.chopper_conductance else 0.0,
            position=POSITIONS.index(self.position),
            least_speed=self.least_speed_rpm * RADIANS_PER_RPM,
            start_time=self.start_time_s,
            is_reversing=0 if self.rating.reverses is False else 1,
            voltage_filter=0.0 if self.sensing is None else self.sensing.voltage_filter_s,
            **self._thermal_nameplate(),
        )

    def _thermal_nameplate(self) -> dict[str, float]:
        thermal = self.thermal
        if thermal is None:
            return {}
        return {
            "heat_capacity": thermal.heat_capacity_j_per_k,
            "thermal_resistance": thermal.thermal_resistance_k_per_w,
            "ambient_temperature": thermal.ambient_c,
            "temperature_limit": thermal.limit_c,
            "temperature_coefficient": thermal.temperature_coefficient_per_k,
            "temperature_lag": thermal.sensor_lag_s or 0.0,
        }
