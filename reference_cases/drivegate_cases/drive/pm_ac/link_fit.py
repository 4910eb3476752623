"""What a `[link]` must fit: the control period, the machine, and the rating of its drive."""

from __future__ import annotations

from math import sqrt
from typing import Any, Final

FASTEST: Final = 20.0
"""Greatest rate of the link's own voltage times the control period, which still is followed exactly (1)."""
_IN_HAND: Final = 2.0
"""Least power that the source can supply at all, over rated power (1)."""
_LEAST_HYSTERESIS: Final = 0.001
# Bounds that only a wrong unit exceeds: limit over nominal voltage; time in which rated power takes the capacitor's
# energy (s); limits of the source over the current of rated power; power of the chopper over rated power.
_MOST_LIMIT: Final = 10.0
_MOST_STORED_S: Final = 2.0
_LEAST_DISCHARGE: Final = 0.1
_MOST_CURRENT: Final = 100.0
_LEAST_BURNT, _MOST_BURNT = 0.02, 100.0


def check_link(link: Any, machine: Any, inverter: Any, rating: Any) -> None:
    """Refuse values that do not fit the machine, the bridge or the rating of the drive."""
    nominal, power = inverter.link_voltage_v, rating.rated_power_w
    if link.source_voltage_v is not None and link.source_voltage_v != nominal:
        raise ValueError(
            f"the key 'source_voltage_v' in [link] is {link.source_voltage_v:g}, but must be the link_voltage_v of "
            f"[inverter], {nominal:g} V; state the voltage of the source there"
        )
    _check_voltages(link, nominal)
    capacitance, resistance = link.capacitance_f, link.source_resistance_ohm
    assert capacitance is not None
    assert resistance is not None
    _check_capacitance(capacitance, machine, nominal, power, inverter.control_period_s)
    if link.source_inductance_h is None:
        _check_charging(capacitance, resistance, inverter.control_period_s)
    most = nominal * nominal / (4.0 * resistance)
    if most < _IN_HAND * power:
        raise ValueError(
            f"the key 'source_resistance_ohm' in [link] is {resistance:g}, with which {nominal:g} V supply at most "
            f"{most:.3g} W; a rated power of {power:g} W requires at most "
            f"{nominal * nominal / (4.0 * _IN_HAND * power):.3g} ohm"
        )
    if link.source_inductance_h is not None:
        _check_inductance(link, link.source_inductance_h, nominal, power, inverter.control_period_s)
    _check_currents(link, nominal, power)
    _check_chopper(link, power)


def _check_voltages(link: Any, nominal: float) -> None:
    """Refuse a limit or thresholds below the nominal voltage (V), or in the wrong order."""
    limit = link.limit(nominal)
    if limit <= nominal:
        raise ValueError(
            f"the key 'link_limit_v' in [link] is {limit:g}, but must be above the nominal {nominal:g} V"
        )
    if limit > _MOST_LIMIT * nominal:
        raise ValueError(
            f"the key 'link_limit_v' in [link] is {limit:g}, but must be at most {_MOST_LIMIT:g} times the nominal "
            f"{nominal:g} V; is it in volts?"
        )
    on, off = link.chopper_on_v, link.chopper_off_v
    if on is None or off is None:
        return
    if off <= nominal:
        raise ValueError(
            f"the key 'chopper_off_v' in [link] is {off:g}, but must be above the nominal {nominal:g} V, or the "
            "chopper burns what the source supplies"
        )
    if on < off + _LEAST_HYSTERESIS * nominal:
        raise ValueError(
            f"the key 'chopper_on_v' in [link] is {on:g}, but must be above chopper_off_v, {off:g}, by at least "
            f"0.1 % of the nominal {nominal:g} V"
        )
    if on >= limit:
        raise ValueError(
            f"the key 'chopper_on_v' in [link] is {on:g}, but must be below the link's limit of {limit:g} V"
        )


def _check_capacitance(capacitance: float, machine: Any, nominal: float, power: float, period: float) -> None:
    """Refuse a capacitance (F) that oscillates too fast with the machine, or stores more than a capacitor does."""
    least = min(machine.direct_inductance_h, machine.quadrature_inductance_h)
    if sqrt(1.5 / (least * capacitance)) * period > FASTEST:
        raise ValueError(
            f"the key 'capacitance_f' in [link] is {capacitance:g}, with which the link oscillates with the "
            f"machine more than three times in a control period of {period:.3g} s; is it in farads?"
        )
    stored = 0.5 * capacitance * nominal * nominal / power
    if stored > _MOST_STORED_S:
        raise ValueError(
            f"the key 'capacitance_f' in [link] is {capacitance:g}, which stores the rated power of {power:g} W for "
            f"{stored:.3g} s, but must be at most {_MOST_STORED_S * capacitance / stored:.2g}; is it in farads?"
        )


def _check_charging(capacitance: float, resistance: float, period: float) -> None:
    """Refuse a capacitor (F) that a source with a resistance alone (ohm) charges too fast for a control period (s)."""
    own = 1.0 / (resistance * capacitance)
    if own * period > FASTEST:
        raise ValueError(
            f"the link charges from its source in {1.0 / own:.3g} s, less than a twentieth of the control period "
            f"of {period:.3g} s; state a greater capacitance_f or source_resistance_ohm in [link], or leave [link] "
            "out for an ideal source"
        )


def _check_inductance(link: Any, inductance: float, nominal: float, power: float, period: float) -> None:
    """Refuse an inductance (H) that is too fast for the control period (s), or unstable at rated power (W)."""
    capacitance, resistance = link.capacitance_f, link.source_resistance_ohm
    assert capacitance is not None
    assert resistance is not None
    rate = max(1.0 / sqrt(inductance * capacitance), resistance / inductance)
    if rate * period > FASTEST:
        raise ValueError(
            f"the key 'source_inductance_h' in [link] is {inductance:g}, with which the source changes within "
            f"{1.0 / rate:.3g} s, less than a twentieth of the control period of {period:.3g} s; leave the inductance "
            "out"
        )
    most = resistance * capacitance * nominal * nominal / (_IN_HAND * power)
    if inductance > most:
        raise ValueError(
            f"the key 'source_inductance_h' in [link] is {inductance:g}, but must be at most {most:.2g}, or the "
            f"link oscillates with its source by itself at the rated power of {power:g} W; is it in henries?"
        )


def _check_currents(link: Any, nominal: float, power: float) -> None:
    """Refuse limits of the source's current that only a wrong unit has."""
    rated = power / nominal
    for key, current, least in (
        ("discharge_limit_a", link.discharge_limit_a, _LEAST_DISCHARGE),
        ("charge_limit_a", link.charge_limit_a, 0.0),
    ):
        if current is not None and not least * rated <= current <= _MOST_CURRENT * rated:
            raise ValueError(
                f"the key '{key}' in [link] is {current:g}, but must be {least * rated:.2g} to "
                f"{_MOST_CURRENT * rated:.2g}: a rated power of {power:g} W takes {rated:.3g} A; is it in amperes?"
            )


def _check_chopper(link: Any, power: float) -> None:
    """Refuse a chopper that burns next to nothing, or all at once, by rated power (W)."""
    voltage, resistance = link.chopper_on_v, link.chopper_resistance_ohm
    if voltage is None or resistance is None:
        return
    burnt = voltage * voltage / resistance
    if not _LEAST_BURNT * power <= burnt <= _MOST_BURNT * power:
        least, most = (voltage * voltage / (share * power) for share in (_MOST_BURNT, _LEAST_BURNT))
        raise ValueError(
            f"the key 'chopper_resistance_ohm' in [link] is {resistance:g}, which burns {burnt:.3g} W at {voltage:g} "
            f"V, but a rated power of {power:g} W requires {least:.2g} to {most:.2g} ohm"
        )
