"""Quantities with their derivatives at one instant, for products and for the stationary frame."""

from __future__ import annotations

from typing import NamedTuple

from drivegate_models.compilation.kernels import inlined
from drivegate_models.pm_ac.plant.circuit import Circuit


class Jet(NamedTuple):
    """A quantity and its first three time derivatives at one instant."""

    value: float
    slope: float
    bend: float
    jerk: float


class Currents(NamedTuple):
    """The currents in the rotor frame, or in a stationary frame that coincides with it at the instant (A)."""

    direct: Jet
    quadrature: Jet


class Rates(NamedTuple):
    """Coefficients of the equations in the rotor frame, solved for the slopes of the currents."""

    direct: float
    """-R/L_d (1/s)."""
    direct_turning: float
    """w L_q/L_d (1/s)."""
    quadrature_turning: float
    """-w L_d/L_q (1/s)."""
    quadrature: float
    """-R/L_q (1/s)."""
    per_direct: float
    """1/L_d (1/H)."""
    per_quadrature: float
    """1/L_q (1/H)."""
    opposed: float
    """w psi/L_q (A/s)."""


class Step(NamedTuple):
    """One order of the change of the currents in a time (A)."""

    direct: float
    quadrature: float
    driven: float
    """Contribution of the rotating d-axis voltage to the next order (A)."""
    driven_across: float
    """Contribution of the rotating q-axis voltage to the next order (A)."""


@inlined
def rates_of(circuit: Circuit) -> Rates:
    """Return the coefficients of the equations in an advance."""
    per_direct = 1.0 / circuit.direct
    per_quadrature = 1.0 / circuit.quadrature
    return Rates(
        -circuit.resistance * per_direct,
        circuit.electrical * circuit.quadrature * per_direct,
        -circuit.electrical * circuit.direct * per_quadrature,
        -circuit.resistance * per_quadrature,
        per_direct,
        per_quadrature,
        circuit.electrical * circuit.flux * per_quadrature,
    )


@inlined
def derivatives(
    rates: Rates, direct: float, quadrature: float, driven: float, driven_across: float
) -> Currents:
    """Return the currents and their derivatives, from the slopes by the voltages alone (A/s)."""
    slope_d = rates.direct * direct + rates.direct_turning * quadrature + driven
    slope_q = (
        rates.quadrature_turning * direct + rates.quadrature * quadrature + (driven_across - rates.opposed)
    )
    bend_d = rates.direct * slope_d + rates.direct_turning * (slope_q + driven_across)
    bend_q = rates.quadrature_turning * (slope_d + driven) + rates.quadrature * slope_q
    # The voltages rotate backward in the rotor frame.
    turned_d = rates.direct_turning * driven_across
    turned_q = rates.quadrature_turning * driven
    jerk_d = rates.direct * bend_d + rates.direct_turning * (bend_q + turned_q)
    jerk_q = rates.quadrature_turning * (bend_d + turned_d) + rates.quadrature * bend_q
    return Currents(Jet(direct, slope_d, bend_d, jerk_d), Jet(quadrature, slope_q, bend_q, jerk_q))


@inlined
def following_step(rates: Rates, length: float, before: Step, order: int) -> Step:
    """Return an order of the change of the currents from the preceding order.

    `length`: time t (s). `order`: order n, at least 2. Result: including the factor ``t**n / n!``.
    """
    share = length * (1.0 / order)
    turned = rates.direct_turning * before.driven_across
    turned_across = rates.quadrature_turning * before.driven
    return Step(
        share * (rates.direct * before.direct + rates.direct_turning * before.quadrature + turned),
        share
        * (rates.quadrature_turning * before.direct + rates.quadrature * before.quadrature + turned_across),
        share * turned,
        share * turned_across,
    )


@inlined
def product_of(one: Jet, other: Jet) -> Jet:
    """Return the product of two quantities with its derivatives."""
    return Jet(
        one.value * other.value,
        one.slope * other.value + one.value * other.slope,
        one.bend * other.value + 2.0 * one.slope * other.slope + one.value * other.bend,
        one.jerk * other.value
        + 3.0 * (one.bend * other.slope + one.slope * other.bend)
        + one.value * other.jerk,
    )


@inlined
def square_of(currents: Currents) -> Jet:
    """Return the squared magnitude of the currents with its derivatives."""
    d, q = currents.direct, currents.quadrature
    return Jet(
        d.value * d.value + q.value * q.value,
        2.0 * (d.value * d.slope + q.value * q.slope),
        2.0 * (d.slope * d.slope + q.slope * q.slope + d.value * d.bend + q.value * q.bend),
        2.0 * (3.0 * (d.slope * d.bend + q.slope * q.bend) + d.value * d.jerk + q.value * q.jerk),
    )


@inlined
def torque_of(circuit: Circuit, currents: Currents) -> Jet:
    """Return the torque over 1.5 times the pole pairs (V A s) with its derivatives."""
    d = currents.direct
    saliency = circuit.direct - circuit.quadrature
    flux = Jet(circuit.flux + saliency * d.value, saliency * d.slope, saliency * d.bend, saliency * d.jerk)
    return product_of(flux, currents.quadrature)


@inlined
def in_stationary_frame(currents: Currents, electrical: float) -> Currents:
    """Return the currents in the stationary frame that coincides with the rotor frame at the instant."""
    d, q = currents.direct, currents.quadrature
    twice = 2.0 * electrical
    thrice = 3.0 * electrical
    square = electrical * electrical
    return Currents(
        Jet(
            d.value,
            d.slope - electrical * q.value,
            d.bend - twice * q.slope - square * d.value,
            d.jerk - thrice * (q.bend + electrical * d.slope) + square * electrical * q.value,
        ),
        Jet(
            q.value,
            q.slope + electrical * d.value,
            q.bend + twice * d.slope - square * q.value,
            q.jerk + thrice * (d.bend - electrical * q.slope) - square * electrical * d.value,
        ),
    )
