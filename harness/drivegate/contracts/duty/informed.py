"""A witness that knows the plant: the currents of its oracle, and regulators that reach them in two control periods.

It serves every drive of this contract. It shows that a requirement can be met, not that a controller can do so without
knowing the plant. It detects no failure, so it has no say on `SAF-1`.
"""

from __future__ import annotations

from math import isfinite, pi, sqrt
from typing import Any, Final

from drivegate.contracts.duty.checks.judged import braking_at, greatest_at, least_within, undistorted
from drivegate_cases.scenario.courses import COURSES
from drivegate_cases.scenario.load import VehicleLoad
from drivegate_cases.scenario.piecewise import value_from
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.duty.signals import TORQUE_REFERENCE, DutyCommand, DutyNameplate, DutySense
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.plant.dc_link import is_ideal
from drivegate_models.pm_ac.plant.drive import PmAcDrive, drifted

_THIRD: Final = complex(-0.5, 0.5 * sqrt(3.0))
# Shares of the voltage and of the current limit that references use. The rest is for the regulators (1).
_VOLTAGE: Final = 0.975
_CURRENT: Final = 0.995
# Rates of the speed regulator over the control rate, and of its integral over its own (1).
_SPEED: Final = 0.02
_INTEGRAL: Final = 0.1
# Share of an error of the predicted currents that goes into the disturbance's estimate (1).
_OBSERVED: Final = 0.15
# Share of the current limit below which dead time is made up for in proportion (1).
_SMALL: Final = 0.002
# Digits of speed and torque that the oracle is asked with, since it remembers its answers.
_DIGITS: Final = 4


def _turn(angle: float) -> complex:
    """Return the unit vector at an angle (rad), the same on every machine."""
    return complex(*cosine_sine(angle))


class InformedController:
    """Regulates the speed, takes currents from the oracle of the true plant, and predicts with its parameters.

    Currents and voltages are complex: real along the magnet's axis, imaginary across it.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        plant: Any = scenario.drive.plant(scenario.scales)
        self._nominal: PmAcDrive = plant
        self._start = scenario.clock_start_s

    def reset(self, nameplate: DutyNameplate) -> None:
        """Forget everything but the scenario."""
        period = nameplate.control_period
        inertia = self._nominal.inertia
        if isinstance(self._scenario.load, VehicleLoad):
            inertia += self._scenario.load.inertia_kg_m2
        self._period = period
        self._delay = nameplate.update_delay
        self._follows_torque = nameplate.reference_kind == TORQUE_REFERENCE
        self._speed_gain = inertia * _SPEED / period
        self._speed_step = self._speed_gain * _INTEGRAL * _SPEED
        self._torque = 0.0
        self._disturbance = 0j
        self._predicted: complex | None = None
        # Voltages that still act before the next answer does, in the frame at rest.
        self._acting = [0j] * self._delay
        self._angle: float | None = None

    def step(self, sense: DutySense) -> DutyCommand:
        drive = self._drive(sense.time - self._start)
        speed, angle = drive.pole_pairs * sense.speed, self._electrical_angle(drive.pole_pairs, sense)
        link = max(sense.supply_voltage, 1e-9)
        first, second, third = sense.phase_currents
        currents = 2.0 / 3.0 * (first + second * _THIRD + third / _THIRD) * _turn(-angle)
        if self._predicted is not None:
            missed = currents - self._predicted
            self._disturbance += _OBSERVED * self._inductive(drive, missed) / self._period
        turn = speed * self._period
        now = currents
        for number, voltage in enumerate(self._acting):
            now = self._next(drive, now, voltage * _turn(-(angle + (number + 0.5) * turn)), speed)
            if number == 0:
                self._predicted = now
        wanted = self._reference(drive, sense, link)
        middle = 0.5 * (now + wanted)
        voltage = self._inductive(drive, wanted - now) / self._period + self._steady(drive, middle, speed)
        voltage -= self._disturbance
        limit = undistorted(drive, link)
        if abs(voltage) > limit:
            voltage *= limit / abs(voltage)
        at_rest = voltage * _turn(angle + (self._delay + 0.5) * turn)
        if self._delay == 0:
            self._predicted = self._next(drive, now, voltage, speed)
        self._acting = [*self._acting, at_rest][1:] if self._delay else []
        phases = middle * _turn(angle + (self._delay + 0.5) * turn)
        saliency = drive.direct_inductance - drive.quadrature_inductance
        per_ampere = 1.5 * drive.pole_pairs * (drive.magnet_flux + saliency * currents.real)
        return DutyCommand(
            duty_ratios=self._ratios(drive, at_rest, phases, link), torque=per_ampere * currents.imag
        )

    def _drive(self, time: float) -> PmAcDrive:
        """Return the plant as it is at a time."""
        scenario = self._scenario
        if scenario.drift is None:
            return self._nominal
        factors = (COURSES[name].profile(scenario) for name in ("resistance", "emf_constant"))
        return drifted(self._nominal, *(value_from(profile, time) for profile in factors))

    def _electrical_angle(self, pole_pairs: int, sense: DutySense) -> float:
        """Return the angle (rad electrical); between the edges of Hall switches, it goes on with the speed."""
        shown = pole_pairs * sense.angle
        if sense.hall < 0:
            return shown
        if self._angle is not None:
            followed = self._angle + pole_pairs * sense.speed * self._period
            off = (followed - shown + pi) % (2.0 * pi) - pi
            shown += min(max(off, -pi / 6.0), pi / 6.0)
        self._angle = shown
        return shown

    def _reference(self, drive: PmAcDrive, sense: DutySense, link: float) -> complex:
        """Return the currents for what is asked for, as far as the limits allow (A)."""
        if self._follows_torque:
            torque = sense.reference
        else:
            error = sense.reference - sense.speed
            torque = self._speed_gain * error + self._torque
        allowed = drive._replace(current_limit=_CURRENT * drive.current_limit)
        speed = float(f"{sense.speed:.{_DIGITS}g}")
        voltage = float(f"{_VOLTAGE * link:.{_DIGITS}g}")
        state = least_within(allowed, speed, voltage, float(f"{torque:.{_DIGITS}g}"), "current")
        given = torque
        if not isfinite(state.direct):
            most = greatest_at(allowed, speed, voltage)
            if torque * most.torque < 0.0:
                most = braking_at(allowed, speed, voltage)
            state = most
            if not is_ideal(drive.dc_link) and abs(torque) < abs(most.torque):
                # The link limits the power: the currents of the greatest torque suffice for less of it.
                share = torque / most.torque
                state = most._replace(quadrature=share * most.quadrature, torque=torque)
            given = state.torque
            if not isfinite(given):
                deepest = min(drive.magnet_flux / drive.direct_inductance, allowed.current_limit)
                return complex(-deepest, 0.0)
        # The integral waits while the limits leave less than is asked for.
        if not self._follows_torque and (given == torque or (torque - given) * error < 0.0):
            self._torque += self._speed_step * error
        return complex(state.direct, state.quadrature)

    @staticmethod
    def _inductive(drive: PmAcDrive, currents: complex) -> complex:
        """Return the flux linkage of currents (V s)."""
        return complex(drive.direct_inductance * currents.real, drive.quadrature_inductance * currents.imag)

    def _steady(self, drive: PmAcDrive, currents: complex, speed: float) -> complex:
        """Return the voltage that constant currents take (V)."""
        linkage = self._inductive(drive, currents) + drive.magnet_flux
        return drive.resistance * currents + 1j * speed * linkage

    def _next(self, drive: PmAcDrive, currents: complex, voltage: complex, speed: float) -> complex:
        """Return the currents after a period with a voltage, by the midpoint rule (A)."""
        middle = currents
        for share in (0.5, 1.0):
            driving = voltage + self._disturbance - self._steady(drive, middle, speed)
            change = share * self._period * driving
            middle = currents + complex(
                change.real / drive.direct_inductance, change.imag / drive.quadrature_inductance
            )
        return middle

    def _ratios(
        self, drive: PmAcDrive, voltage: complex, currents: complex, link: float
    ) -> tuple[float, float, float]:
        """Return the duty ratios of a voltage at rest about the middle of the link, with dead time made up for."""
        phases = [(voltage / turn).real for turn in (1.0, _THIRD, 1.0 / _THIRD)]
        flowing = [(currents / turn).real for turn in (1.0, _THIRD, 1.0 / _THIRD)]
        middle = 0.5 * (max(phases) + min(phases))
        lost = drive.modulator.dead_time / self._period
        lost *= 0.5 if drive.modulator.updates == 2 else drive.modulator.control_every
        small = _SMALL * drive.current_limit
        first, second, third = (
            min(max(0.5 + (phase - middle) / link + lost * min(max(current / small, -1.0), 1.0), 0.0), 1.0)
            for phase, current in zip(phases, flowing, strict=True)
        )
        return first, second, third
