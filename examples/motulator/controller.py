"""The control systems of the Python package motulator, unchanged, as candidates that answer with duty ratios.

A control system of motulator measures a drive by four methods and answers with a sampling period and duty ratios. The
class `_Front` is these four methods on what drivegate has sensed; motulator's own classes do the rest.
"""

from math import pi

from motulator.drive.control import sm

from drivegate import TORQUE_REFERENCE, DutyCommand, DutyNameplate, DutySense

# As in motulator's example of the machine of 2.2 kW (rad/s).
SPEED_BANDWIDTH = 25.0
# Of the currents and of the filter of their references; left out they are 2 pi 200 and 2 pi 100 (rad/s).
FAST_CURRENTS, FAST_REFERENCES = 2.0 * pi * 300.0, 2.0 * pi * 1000.0


class _Front:
    """A candidate around a control system, which takes it for the drive's machine, mechanics and converter."""

    sensorless = False
    lc_filter = None
    machine = mechanics = converter = property(lambda self: self)

    def reset(self, nameplate: DutyNameplate) -> None:
        """Prepare for a run: a new control system, from the nominal data of the drive."""
        n = nameplate
        machine = sm.SynchronousMachinePars(
            n_p=n.pole_pairs,
            R_s=n.resistance,
            L_d=n.direct_inductance,
            L_q=n.quadrature_inductance,
            psi_f=n.magnet_flux,
        )
        vector = self.vector_controller(
            machine, i_s_max=n.current_limit, sensorless=self.sensorless, T_s=n.control_period
        )
        self.pole_pairs = n.pole_pairs
        self.follows_torque = n.reference_kind == TORQUE_REFERENCE
        speed = None if self.follows_torque else sm.SpeedController(J=n.inertia, alpha_s=SPEED_BANDWIDTH)
        dead_time = sm.InverterNonlinearity(t_d=n.dead_time)
        self.system = sm.VectorControlSystem(
            vector, speed, sm.PWM(d_err=dead_time, single_update=n.updates == 1)
        )

    def step(self, sense: DutySense) -> DutyCommand:
        """Answer for one control period."""
        self.sense = sense
        follow = self.system.set_torque_ref if self.follows_torque else self.system.set_speed_ref
        follow(sense.reference)
        observer = self.system.vector_ctrl.observer
        angle, speed = observer.theta_m / self.pole_pairs, observer.w_M
        _, duty_ratios = self.system(self)
        # It keeps every signal of every period, and a run is long.
        self.system.clear_data()
        if not self.sensorless:
            return DutyCommand(duty_ratios)
        return DutyCommand(duty_ratios, angle=angle, speed=speed)

    def meas_dc_voltage(self) -> float:
        """Voltage of the link (V)."""
        return self.sense.supply_voltage

    def meas_currents(self) -> tuple[float, float, float]:
        """Phase currents (A)."""
        return self.sense.phase_currents

    def meas_speed(self) -> float:
        """Speed of the shaft (rad/s)."""
        return self.sense.speed

    def meas_position(self) -> float:
        """Angle of the shaft (rad)."""
        return self.sense.angle


class CurrentVector(_Front):
    """Current-vector control."""

    @staticmethod
    def vector_controller(
        machine: sm.SynchronousMachinePars, **settings: float
    ) -> sm.CurrentVectorController:
        """Make the controller of the currents."""
        return sm.CurrentVectorController(machine, sm.CurrentVectorControllerCfg(**settings))


class FastCurrentVector(CurrentVector):
    """Current-vector control with bandwidths of its own parameters raised."""

    @staticmethod
    def vector_controller(
        machine: sm.SynchronousMachinePars, **settings: float
    ) -> sm.CurrentVectorController:
        """Make the controller of the currents."""
        return CurrentVector.vector_controller(
            machine, alpha_c=FAST_CURRENTS, alpha_ref=FAST_REFERENCES, **settings
        )


class FluxVector(_Front):
    """Flux-vector control."""

    @staticmethod
    def vector_controller(machine: sm.SynchronousMachinePars, **settings: float) -> sm.FluxVectorController:
        """Make the controller of flux and torque."""
        return sm.FluxVectorController(machine, sm.FluxVectorControllerCfg(**settings))


class SensorlessCurrentVector(CurrentVector):
    """Current-vector control with its flux observer in place of a sensor."""

    sensorless = True


class SensorlessFluxVector(FluxVector):
    """Flux-vector control with its flux observer in place of a sensor."""

    sensorless = True


class SignalInjection(_Front):
    """Current-vector control that injects a voltage to find the angle of a salient rotor, but not its polarity."""

    sensorless = True

    @staticmethod
    def vector_controller(
        machine: sm.SynchronousMachinePars, **settings: float
    ) -> sm.SignalInjectionController:
        """Make the controller of the currents."""
        return sm.SignalInjectionController(machine, sm.CurrentVectorControllerCfg(**settings))
