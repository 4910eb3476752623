"""What every key of a scenario and of its drive does on each kind of drive, and runs short enough to see it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from math import isnan
from typing import Any, Final, TypeAlias, get_args

from drivegate import Command, DutyCommand, DutySense
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.python.bridge import PythonController
from drivegate.contracts.catalogue import TEXTS, contract_named, contract_of, on_drive
from drivegate.contracts.duty.plant_run import duty_run
from drivegate.drives.duty_ability import duty_envelope
from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.drives.running import run_scenario
from drivegate_cases.documents.document import Section
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario

DRIVES: Final = {"half-bridge": "fan-3-phase", "star": "star-24v-3-phase", "pm-ac": "pm-ac-interior"}
"""A drive of each kind; those of advance angles have three phases, which Hall switches need."""


@dataclass(frozen=True)
class Runs:
    """Another value of the key changes what a controller senses or what the plant does.

    Attributes
    ----------
    value : object
        The other value.
    given : mapping
        Keys with which the key acts, set in both runs.
    with_it : mapping
        Keys that must change with it.
    """

    value: Any
    given: Mapping[str, Any] = field(default_factory=dict)
    with_it: Mapping[str, Any] = field(default_factory=dict)


class Nameplate(Runs):
    """Another value changes what a controller is given before a run, and perhaps the run."""


class Requires(Runs):
    """Another value changes what the checks of the drive require."""


class Plans(Runs):
    """Another value changes which runs the gate makes, or what `drivegate drive` shows."""


class Writes(Runs):
    """Text alone, which the documents of a result keep."""


@dataclass(frozen=True)
class Refused:
    """The kind of drive refuses the key in one sentence.

    Attributes
    ----------
    value : object
        What is refused.
    words : tuple of str
        What the sentence names.
    given : mapping
        Keys that belong to it.
    """

    value: Any
    words: tuple[str, ...]
    given: Mapping[str, Any] = field(default_factory=dict)


Effect: TypeAlias = Runs | Refused


def keys_of(model: type[Section], prefix: str = "") -> Iterator[str]:
    """List the keys of a document with those of its tables, and of each kind of a table that has several."""
    for name, described in model.model_fields.items():
        key = f"{prefix}{described.alias or name}"
        tables = _tables(described.annotation)
        if not tables:
            yield key
        for table in tables:
            if not issubclass(table, DriveDocument):
                kind = f"[{get_args(table.model_fields['kind'].annotation)[0]}]" if len(tables) > 1 else ""
                yield from keys_of(table, f"{key}{kind}.")


def _tables(annotation: Any) -> list[type[Section]]:
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return [annotation]
    return [table for argument in get_args(annotation) for table in _tables(argument)]


def every_key() -> list[str]:
    """List the keys of scenarios, and of drives of all kinds."""
    found = [*keys_of(Scenario), *keys_of(DriveDocument, "drive."), *keys_of(PmAcDocument, "drive.")]
    # A PM AC drive refuses the whole table.
    return [key for key in dict.fromkeys(found) if key != "drive.advance"]


_HALL_EDGES = {"sensors.position": "hall"}
_RESOLVED = {"sensors.position": "exact"}
_LOW_SIDE = {"sensors.shunts": "low-side"}
_FAILS = {"failure": {"kind": "stuck-current", "time_s": 0.01}}
_DROPPED = {"dropouts": [{"signal": "currents", "phase": 1, "start_s": 0.01, "duration_s": 0.005}]}
_GLITCHED = {"sensors": {"kind": "mcs96"}, "glitches": [{"time_s": 0.01, "counts": 9}]}
_GLITCHED_SHUNTS = {**_GLITCHED, "sensors": {"kind": "shunts"}}
_ERRS = {"current_errors": [{"phase": 1, "gain": 0.5, "offset_a": 0.1}]}
_POINT = {"drive.requirements.point": [{"speed_rpm": 5000.0, "torque_n_m": 0.1}]}
_TABLE = [[0.0, 0.0], [60.0, 1.0], [180.0, 0.0]]
_TABLED = {
    "drive.machine.emf_flat_deg": None,
    "drive.machine.emf_shape": "table",
    "drive.machine.emf_table": [[0.0, 0.0], [90.0, 1.0], [180.0, 0.0]],
}
_CONTINUOUS = {"drive.rating.continuous_current_a": 5.0, "drive.rating.rated_power_w": None}
_PEAK = {"drive.rating.peak_current_a": 9.0, "drive.rating.current_limit_a": None}
_LINK = {"drive.link": {"source": "battery", "capacitance_f": 1e-3, "source_resistance_ohm": 0.5}}
_CHOPPER = {
    "drive.link": {
        **_LINK["drive.link"],
        "chopper_on_v": 130.0,
        "chopper_off_v": 124.0,
        "chopper_resistance_ohm": 20.0,
    },
    "supply_v": [[0.0, 70.0], [0.005, 70.0], [0.005, 61.0]],
}
_SENSORLESS = {"drive.sensing": {"position": "none"}}
_MEANS = {"drive.sensing": {"position": "none", "mean_voltages": True}}
_ADVANCE = {"drive.advance": {"start_deg": 10.0, "slope_deg_per_rpm": 0.01}}

_HEATED = {
    "drive.thermal": {
        "heat_capacity_j_per_k": 3.4,
        "thermal_resistance_k_per_w": 4.3,
        "limit_c": 130.0,
        "sensor_lag_s": 0.5,
    }
}

_SCENARIO: Final[dict[str, Effect]] = {
    "schema": Refused(9, ("schema", "9", "2")),
    "name": Writes("another name"),
    "description": Writes("what it shows"),
    "scales.resistance": Runs(2.0),
    "scales.inductance": Runs(2.0),
    "scales.emf_constant": Runs(0.5),
    "scales.inertia": Runs(3.0),
    "scales.friction_added_n_m": Runs(0.05),
    "duration_s": Runs(0.01),
    "control_period_s": Runs(2.5e-4),
    "seed": Runs(1, {"sensors": {"kind": "mcs96"}}),
    "initial_speed_rpm": Runs(150.0),
    "initial_angle_deg": Runs(90.0),
    "clock_start_s": Runs(4294.9),
    "turns_before": Runs(3),
    "winding_temperature_c": Runs(90.0, _HEATED),
    "restarts_s": Runs([0.01]),
    "speed_rpm": Runs([[0.0, 400.0]]),
    "supply_v": Runs([[0.0, 10.0]]),
    "link_voltage_v": Refused(20.0, ("link_voltage_v", '"half-bridge"', "split supply")),
    "load[dynamometer].torque_reference_nm": Runs([[0.0, 0.0], [0.01, 1.0]]),
    "load[dynamometer].released_s": Runs(0.01),
    "load[constant_torque].factor": Runs([[0.0, 0.5]]),
    "load[constant_torque].torque_nm": Runs(0.06),
    "load[hoist].factor": Runs([[0.0, 0.5]]),
    "load[hoist].torque_nm": Runs(0.06),
    "load[constant_power].factor": Runs([[0.0, 0.5]]),
    "load[constant_power].power_w": Runs(2.0),
    "load[fan].factor": Runs([[0.0, 0.5]]),
    "load[fan].torque_nm": Runs(0.06),
    "load[fan].speed_rpm": Runs(500.0),
    "load[vehicle].mass_kg": Runs(60.0),
    "load[vehicle].wheel_radius_m": Runs(0.02),
    "load[vehicle].gear_ratio": Runs(5.0),
    "load[vehicle].rolling_resistance": Runs(0.2),
    "load[vehicle].drag_area_m2": Runs(60.0),
    "load[vehicle].air_density_kg_m3": Runs(60.0),
    "load[vehicle].grade_percent": Runs([[0.0, 20.0]]),
    "sensors[mcs96].encoder_lines": Runs(64),
    "sensors[mcs96].speed_window_s": Runs(0.002),
    "sensors[hall].placement_error_deg": Runs(9.0),
    "sensors[hall].hysteresis_deg": Runs(9.0),
    "sensors[shunts].shunts": Runs("link"),
    "sensors[shunts].settling_s": Runs(4e-5, _LOW_SIDE),
    "sensors[shunts].position": Runs("exact"),
    "sensors[shunts].encoder_lines": Runs(64),
    "sensors[shunts].encoder_error_deg": Runs(9.0),
    "sensors[shunts].speed_window_s": Runs(0.005),
    "sensors[shunts].eccentricity_deg": Runs(1.0, _RESOLVED),
    "sensors[shunts].eccentric_from_deg": Runs(90.0, {**_RESOLVED, "sensors.eccentricity_deg": 1.0}),
    "sensors[shunts].sine_offset": Runs(0.05, _RESOLVED),
    "sensors[shunts].cosine_offset": Runs(0.05, _RESOLVED),
    "sensors[shunts].track_gain": Runs(0.05, _RESOLVED),
    "sensors[shunts].track_phase_deg": Runs(3.0, _RESOLVED),
    "sensors[shunts].latency_s": Runs(1e-4, _RESOLVED),
    "sensors[shunts].placement_error_deg": Runs(9.0, _HALL_EDGES),
    "sensors[shunts].hysteresis_deg": Runs(9.0, _HALL_EDGES),
    **{
        f"sensors[{kind}].{key}": effect
        for kind in ("mcs96", "hall", "shunts")
        for key, effect in {
            "clock_s": Runs(1e-4),
            "current_range_a": Runs(3.0),
            "current_gain_spread": Runs(0.2),
            "current_offset_a": Runs(1.0),
            "current_noise_a": Runs(1.0),
            "voltage_range_v": Runs(9.0),
            "voltage_noise_v": Runs(1.0),
            "converter_bits": Runs(5),
        }.items()
    },
    "current_errors.phase": Runs(2, _ERRS),
    "current_errors.gain": Runs(0.8, _ERRS),
    "current_errors.offset_a": Runs(0.3, _ERRS),
    "imbalance": Runs([[0.0, 0.2]]),
    "drift.resistance": Runs([[0.0, 3.0]]),
    "drift.emf_constant": Runs([[0.0, 0.5]]),
    "drift.inertia": Runs([[0.0, 0.5]]),
    "drift.friction_n_m": Runs([[0.0, 0.05]]),
    "dropouts.signal": Runs(
        "speed", {"dropouts": [{"signal": "currents", "start_s": 0.01, "duration_s": 0.005}]}
    ),
    "dropouts.phase": Runs(2, _DROPPED),
    "dropouts.start_s": Runs(0.005, _DROPPED),
    "dropouts.duration_s": Runs(0.002, _DROPPED),
    "glitches.time_s": Runs(0.005, _GLITCHED),
    "glitches.counts": Runs(-9, _GLITCHED),
    "failure.kind": Runs("open-phase", _FAILS),
    "failure.time_s": Runs(0.005, _FAILS),
    "failure.phase": Runs(2, _FAILS),
    "failure.slip_deg": Runs(90.0, {"failure": {"kind": "slip", "time_s": 0.01, "slip_deg": 45.0}}),
    # Every other kind of load or sensors is another run than the first one's.
    **{
        f"load[{kind}].kind": Runs(kind)
        for kind in ("locked", "dynamometer", "hoist", "constant_power", "fan", "vehicle")
    },
    "load[constant_torque].kind": Runs("constant_torque", {"load": {"kind": "locked"}}),
    **{f"sensors[{kind}].kind": Runs(kind) for kind in ("mcs96", "hall", "shunts")},
    "sensors[ideal].kind": Runs("ideal", {"sensors": {"kind": "mcs96"}}),
}

_DRIVE: Final[dict[str, Effect]] = {
    "drive.schema": Refused(9, ("schema", "9")),
    "drive.name": Writes("another drive"),
    "drive.provenance": Writes({"machine": {"pole_pairs": "counted"}}),
    "drive.kind": Runs("star"),
    "drive.machine.phases": Runs(5),
    "drive.machine.pole_pairs": Runs(6),
    "drive.machine.resistance_ohm": Runs(2.0),
    "drive.machine.inductance_h": Runs(1e-3),
    "drive.machine.emf_constant_v_s_per_rad": Runs(0.01),
    "drive.machine.emf_shape": Runs("sine", with_it={"drive.machine.emf_flat_deg": None}),
    "drive.machine.emf_flat_deg": Runs(40.0),
    "drive.machine.emf_table": Runs(_TABLE, _TABLED),
    "drive.machine.core_loss_conductance_s": Runs(0.05),
    "drive.machine.inertia_kg_m2": Runs(1e-3),
    "drive.machine.friction_n_m": Runs(0.03),
    "drive.machine.viscous_friction_n_m_s_per_rad": Runs(1e-3),
    "drive.machine.direct_inductance_h": Runs(0.02),
    "drive.machine.quadrature_inductance_h": Runs(0.02),
    "drive.machine.magnet_flux_v_s": Runs(0.05),
    "drive.inverter.supply_voltage_v": Runs(10.0),
    "drive.inverter.hysteresis_band_a": Runs(0.5),
    "drive.inverter.window_deg": Runs(90.0),
    "drive.inverter.regulation": Runs("upper-only"),
    "drive.inverter.switch_drop_v": Runs(1.5),
    "drive.inverter.diode_drop_v": Runs(1.5),
    "drive.inverter.turn_on_energy_j": Runs(1e-3),
    "drive.inverter.turn_off_energy_j": Runs(1e-3),
    "drive.inverter.link_voltage_v": Runs(40.0),
    "drive.inverter.carrier_frequency_hz": Runs(5000.0),
    "drive.inverter.carrier": Runs("double"),
    "drive.inverter.update_delay": Runs(0),
    "drive.inverter.control_every": Runs(2),
    "drive.inverter.counter_levels": Runs(50),
    "drive.inverter.dead_time_s": Runs(5e-6),
    "drive.inverter.minimum_pulse_s": Runs(2e-5),
    "drive.sensing.position": Runs("hall"),
    **{
        f"drive.thermal.{key}": Nameplate(value, _HEATED)
        for key, value in {
            "heat_capacity_j_per_k": 4.0,
            "thermal_resistance_k_per_w": 5.0,
            "limit_c": 120.0,
            "ambient_c": 30.0,
            "temperature_coefficient_per_k": 0.003,
            "sensor_lag_s": 0.2,
        }.items()
    },
    "drive.link.source": Runs(
        "battery", with_it={f"drive.link.{key}": value for key, value in _LINK["drive.link"].items()}
    ),
    "drive.link.source_voltage_v": Refused(33.0, ("source_voltage_v", "33", "link_voltage_v"), _LINK),
    "drive.link.capacitance_f": Runs(2e-3, _LINK),
    "drive.link.source_resistance_ohm": Runs(1.0, _LINK),
    "drive.link.source_inductance_h": Runs(1e-4, _LINK),
    "drive.link.charge_limit_a": Nameplate(3.0, _LINK),
    "drive.link.discharge_limit_a": Nameplate(9.0, _LINK),
    "drive.link.link_limit_v": Nameplate(170.0, _LINK),
    "drive.link.chopper_on_v": Nameplate(135.0, _CHOPPER),
    "drive.link.chopper_off_v": Runs(128.0, _CHOPPER),
    "drive.link.chopper_resistance_ohm": Nameplate(30.0, _CHOPPER),
    "drive.sensing.mean_voltages": Runs(True, _SENSORLESS),
    "drive.sensing.voltage_filter_hz": Nameplate(300.0, _MEANS),
    "drive.sensing.least_speed_rpm": Nameplate(300.0, _SENSORLESS),
    "drive.sensing.start_time_s": Nameplate(5.0, _SENSORLESS),
    "drive.rating.base_speed_rpm": Nameplate(1500.0),
    "drive.rating.highest_speed_rpm": Nameplate(5000.0),
    "drive.rating.overspeed_rpm": Plans(9999.0),
    "drive.rating.rated_power_w": Nameplate(20.0),
    "drive.rating.reverses": Plans(False),
    "drive.rating.current_limit_a": Nameplate(4.0),
    "drive.rating.continuous_current_a": Nameplate(4.5, _CONTINUOUS),
    "drive.rating.peak_current_a": Nameplate(8.0, _PEAK),
    "drive.advance.start_deg": Nameplate(12.0, _ADVANCE),
    "drive.advance.slope_deg_per_rpm": Nameplate(0.02, _ADVANCE),
    "drive.requirements.speed_tolerance_rpm": Requires(33.0),
    "drive.requirements.power_tolerance_percent": Requires(3.0),
    "drive.requirements.angle_tolerance_deg": Requires(3.0),
    "drive.requirements.settling_s": Requires(9.0),
    "drive.requirements.optimum_tolerance_percent": Requires(3.0),
    "drive.requirements.ripple_percent": Requires(33.0),
    "drive.requirements.closed_loop_ripple_percent": Requires(33.0),
    "drive.requirements.point.speed_rpm": Requires(5500.0, _POINT),
    "drive.requirements.point.torque_n_m": Requires(0.11, _POINT),
    **{
        f"drive.requirements.{key}": Requires(value)
        for key, value in {
            "torque_tolerance_percent": 3.0,
            "estimate_tolerance_percent": 3.0,
            "overshoot_percent": 33.0,
            "speed_overshoot_percent": 33.0,
            "speed_swing_ratio": 3.0,
            "coupled_current_percent": 33.0,
            "rise_periods": 33.0,
            "peak_current_percent": 133.0,
            "least_current_percent": 3.0,
            "least_loss_percent": 3.0,
            "weakening_torque_percent": 83.0,
            "weakening_voltage_percent": 83.0,
            "direct_current_percent": 13.0,
            "braking_torque_percent": 33.0,
            "safe_state_ms": 33.0,
            "failure_torque_percent": 33.0,
            "dead_time_ripple": 3.0,
            "modulation_ripple": 3.0,
            "temperature_rise_percent": 133.0,
            "source_current_percent": 133.0,
            "link_braking_percent": 33.0,
            "link_swing_percent": 33.0,
            "derated_current_percent": 133.0,
            "derated_torque_percent": 33.0,
            "derating_step_percent": 33.0,
        }.items()
    },
}

_EXCEPT: Final[dict[str, dict[str, Effect]]] = {
    "half-bridge": {"drive.inverter.regulation": Refused("upper-only", ("regulation", "star"))},
    "star": {
        "drive.kind": Runs("half-bridge", with_it={"drive.inverter.regulation": None}),
        "link_voltage_v": Runs(20.0),
        "imbalance": Refused([[0.0, 0.2]], ("imbalance", '"star"', "split supply")),
    },
    "pm-ac": {
        "control_period_s": Refused(5e-4, ("control_period_s", "0.0001")),
        "link_voltage_v": Runs(20.0),
        "imbalance": Refused([[0.0, 0.2]], ("imbalance", '"pm-ac"', "split supply")),
        "glitches.time_s": Runs(0.005, _GLITCHED_SHUNTS),
        "glitches.counts": Runs(-9, _GLITCHED_SHUNTS),
        "seed": Runs(1, {"sensors": {"kind": "shunts"}}),
        "sensors[ideal].kind": Runs("ideal", {"sensors": {"kind": "shunts"}}),
        "drive.requirements.settling_s": Plans(0.5),
        "drive.kind": Refused("star", ("machine.direct_inductance_h", '"star"')),
    },
}
"""Keys that act in another way on one kind of drive than on the others."""

_OTHERS_ALONE: Final = {
    "sensors[shunts]": ("sensors", "'shunts'", "mcs96"),
    "load[dynamometer]": ("'dynamometer'", '"pm-ac"'),
    "load[hoist]": ("'hoist'", '"pm-ac"'),
    "failure": ("failure", '"pm-ac"'),
    "turns_before": ("turns_before", '"pm-ac"'),
    "winding_temperature_c": ("[thermal]", '"pm-ac"'),
    "drive.sensing": ("[sensing]", '"pm-ac"'),
    "drive.thermal": ("[thermal]", '"pm-ac"'),
    "drive.link": ("[link]", '"pm-ac"'),
}
_REFUSED_TABLES: Final[dict[str, dict[str, tuple[str, ...]]]] = {
    "half-bridge": _OTHERS_ALONE,
    "star": _OTHERS_ALONE,
    "pm-ac": {
        "sensors[mcs96]": ("sensors", "'mcs96'", '"pm-ac"', "shunts"),
        "sensors[hall]": ("sensors", "'hall'", '"pm-ac"', "shunts"),
        "drive.advance": ("advance", "no advance angle"),
        **{key: (key, '"pm-ac"', "other kinds") for key in ("current_errors",)},
    },
}
"""Tables and keys that a kind of drive refuses as a whole, with what the sentence names."""

_TABLES: Final[dict[str, dict[str, Any]]] = {
    "load[locked]": {"kind": "locked"},
    "load[dynamometer]": {"kind": "dynamometer", "torque_reference_nm": [[0.0, 0.5]]},
    "load[constant_torque]": {"kind": "constant_torque", "torque_nm": 0.03, "factor": [[0.0, 1.0]]},
    "load[hoist]": {"kind": "hoist", "torque_nm": 0.05, "factor": [[0.0, 1.0]]},
    "load[constant_power]": {"kind": "constant_power", "power_w": 1.0, "factor": [[0.0, 1.0]]},
    "load[fan]": {"kind": "fan", "torque_nm": 0.03, "speed_rpm": 300.0, "factor": [[0.0, 1.0]]},
    "load[vehicle]": {
        "kind": "vehicle",
        "mass_kg": 50.0,
        "wheel_radius_m": 0.01,
        "gear_ratio": 4.0,
        "rolling_resistance": 0.05,
        "drag_area_m2": 9.0,
    },
    **{f"sensors[{kind}]": {"kind": kind} for kind in ("ideal", "mcs96", "hall", "shunts")},
}
"""Tables of each kind, with all that they must have."""


def effect_of(kind: str, key: str) -> Effect:
    """Return what a key does on a kind of drive."""
    if (own := _EXCEPT.get(kind, {}).get(key)) is not None:
        return own
    usual = (_SCENARIO | _DRIVE)[key]
    for table, words in _REFUSED_TABLES[kind].items():
        if key == table or key.startswith(f"{table}."):
            return Refused(usual.value, words, usual.given)
    document = PmAcDocument if kind == "pm-ac" else DriveDocument
    if key.startswith("drive.") and key not in keys_of(document, "drive."):
        return Refused(usual.value, (".".join(key.split(".")[1:3]), f'"{kind}"'))
    return usual


def known_keys() -> set[str]:
    """Return the keys that the table has."""
    return {*_SCENARIO, *_DRIVE}


def mappings(kind: str, key: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Write two runs that differ in one key."""
    effect = effect_of(kind, key)
    before = plain(kind)
    table = key.rpartition(".")[0]
    is_kind = key.endswith("].kind")
    if table in _TABLES and not is_kind:
        _put(before, table.partition("[")[0], deepcopy(_TABLES[table]))
    for path, value in effect.given.items():
        _put(before, path, deepcopy(value))
    after = deepcopy(before)
    if is_kind:
        _put(after, table.partition("[")[0], deepcopy(_TABLES[table]))
    else:
        _put(after, key, effect.value)
    for path, value in getattr(effect, "with_it", {}).items():
        _put(after, path, value)
    return before, after


def plain(kind: str) -> dict[str, Any]:
    """Write a run of 20 ms of a free shaft at 300 rpm, through ideal sensors."""
    return {
        "schema": 2,
        "name": "short",
        "drive": load_drive(DRIVES[kind]).to_mapping(),
        "duration_s": 0.02,
        "speed_rpm": [[0.0, 300.0]],
        "initial_speed_rpm": 300.0,
        "load": deepcopy(_TABLES["load[constant_torque]"]),
    }


def _put(mapping: Any, path: str, value: Any) -> None:
    """Put a value into nested tables, and into the first of a list of tables."""
    *tables, key = (step.partition("[")[0] for step in path.split("."))
    for table in tables:
        mapping = mapping.setdefault(table, {})
        mapping = mapping[0] if isinstance(mapping, list) else mapping
    mapping[key] = value


class _Noting:
    """Answers the same whatever it senses, and notes what that is."""

    def __init__(self, answers: list[Any]) -> None:
        self.answers = answers
        self.senses: list[Any] = []
        self.resets: list[int] = []

    def reset(self, _nameplate: Any) -> None:
        """Note when it is reset."""
        self.resets.append(len(self.senses))

    def step(self, sense: Any) -> Any:
        """Note what is sensed."""
        if isinstance(sense, DutySense) and isnan(sense.winding_temperature):
            # NaN equals nothing, and the same senses have to be equal.
            sense = sense._replace(winding_temperature=None)
        if isinstance(sense, DutySense) and isnan(sense.mean_voltages[0]):
            sense = sense._replace(mean_voltages=None)
        self.senses.append(sense)
        return self.answers[len(self.senses) % len(self.answers)]


_CURRENTS: Final = [Command(3.0, 0.3, 0.0)] * 3 + [Command(2.0, 0.3, 0.0)]
_PULSES: Final = [DutyCommand(ratios) for ratios in ((0.6, 0.45, 0.4), (0.7, 0.01, 0.3), (0.95, 0.52, 0.4))]


@dataclass(frozen=True)
class Seen:
    """A run by commands that are always the same.

    Attributes
    ----------
    resets : list of int
        Steps before which the controller is reset.
    senses : list
        What it senses.
    plant : str
        What the plant does, bit for bit.
    """

    resets: list[int]
    senses: list[Any]
    plant: str


def seen(scenario: Scenario) -> Seen:
    """Run a scenario by commands that are always the same."""
    if scenario.drive.contract == "duty":
        noting = _Noting(_PULSES)
        run: Any = duty_run(DRIVE_KINDS["pm-ac"].prepare_loop(), scenario, PythonController(noting))
    else:
        noting = _Noting(_CURRENTS)
        run = run_scenario(scenario, PythonController(noting), trace_every=1)
    return Seen(noting.resets, noting.senses, repr((run.trace.tolist(), run.totals.tolist())))


def required(drive: DriveDocument) -> list[str]:
    """Return what the texts of all checks require of a drive."""
    checks = (on_drive(check, drive) for check in contract_named(drive.contract).checks)
    return [getattr(check, name) for check in checks for name in TEXTS]


def planned(drive: DriveDocument) -> Any:
    """Return the fixed runs of a drive, and what `drivegate drive` shows of one that takes duty ratios."""
    runs = contract_of(drive).fixed_scenarios(drive, Declaration())
    shown = duty_envelope(drive) if isinstance(drive, PmAcDocument) else None
    return [run.to_mapping() | {"drive": None} for run in runs], shown
