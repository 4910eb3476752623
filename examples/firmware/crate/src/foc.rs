//! Field-oriented control without allocation.

const ROOT_THREE: f64 = 1.7320508075688772;
/// Bandwidth of the current regulators times the control period, and that of the speed regulator over it.
const BANDWIDTH: f64 = 0.2;
const SPEED_SHARE: f64 = 0.02;
/// Share of the linear range for references, and what braking by the speed regulator leaves of it for regulation.
const VOLTAGE_SHARE: f64 = 0.985;
const BRAKING_SHARE: f64 = 0.185;

#[derive(Clone, Copy)]
pub struct Motor {
    pub pole_pairs: f64,
    pub resistance: f64,
    pub direct_inductance: f64,
    pub quadrature_inductance: f64,
    pub magnet_flux: f64,
    pub inertia: f64,
    pub current_limit: f64,
    pub voltage: f64,
    pub period: f64,
    /// From sampling to the middle of the pulse.
    pub delay: f64,
}

#[derive(Clone, Copy)]
pub enum Demand {
    Speed(f64),
    Torque(f64),
}

pub struct Measured {
    pub currents: [f64; 3],
    pub link: f64,
    pub angle: f64,
    pub speed: f64,
}

#[derive(Clone, Copy)]
struct Regulator {
    gain: f64,
    step: f64,
    integral: f64,
}

impl Regulator {
    fn of_current(inductance: f64, motor: &Motor) -> Self {
        let gain = BANDWIDTH / motor.period * inductance;
        Self { gain, step: BANDWIDTH * motor.resistance.max(0.1 * gain), integral: 0.0 }
    }

    fn output(&mut self, error: f64) -> f64 {
        self.integral += self.step * error;
        self.gain * error + self.integral
    }
}

impl Motor {
    fn torque_per_ampere(&self, direct: f64) -> f64 {
        1.5 * self.pole_pairs * (self.magnet_flux - (self.quadrature_inductance - self.direct_inductance) * direct)
    }

    fn deepest(&self) -> f64 {
        -(0.999 * self.current_limit).min(self.magnet_flux / self.direct_inductance)
    }

    /// Return the direct current of least magnitude for a torque.
    fn least_current(&self, torque: f64) -> f64 {
        let saliency = self.quadrature_inductance - self.direct_inductance;
        if saliency < 1e-3 * self.direct_inductance {
            return 0.0;
        }
        (0..6).fold(0.0, |direct, _| {
            let reluctance = 2.0 * saliency * torque / self.torque_per_ampere(direct);
            (self.magnet_flux - self.magnet_flux.hypot(reluctance)) / (2.0 * saliency)
        })
    }

    /// Return the greatest torque at a direct current within the limits of current and voltage; negative for none.
    fn greatest_torque(&self, direct: f64, speed: f64, voltage: f64) -> f64 {
        let headroom = self.current_limit.powi(2) - direct.powi(2);
        let emf = speed * (self.direct_inductance * direct + self.magnet_flux);
        let reactance = speed * self.quadrature_inductance;
        let a = reactance.powi(2) + self.resistance.powi(2);
        let b = self.resistance * (emf - reactance * direct);
        let inside = b * b - a * ((self.resistance * direct).powi(2) + emf.powi(2) - voltage.powi(2));
        if headroom < 0.0 || inside < 0.0 {
            return -1.0;
        }
        self.torque_per_ampere(direct) * headroom.sqrt().min((inside.sqrt() - b) / a)
    }

    /// Return the first direct current from a given one on that allows a torque, else the one that allows most.
    fn weakened(&self, start: f64, torque: f64, speed: f64, voltage: f64) -> f64 {
        let mut last = (start, self.greatest_torque(start, speed, voltage));
        let mut best = last;
        for step in 1..=64 {
            if best.1 >= torque {
                break;
            }
            let direct = start + (self.deepest() - start) * f64::from(step) / 64.0;
            let possible = self.greatest_torque(direct, speed, voltage);
            if possible >= torque {
                return last.0 + (direct - last.0) * (torque - last.1) / (possible - last.1);
            }
            last = (direct, possible);
            best = if possible > best.1 { last } else { best };
        }
        best.0
    }
}

pub struct Controller {
    motor: Motor,
    most_torque: f64,
    direct: Regulator,
    quadrature: Regulator,
    speed: Regulator,
    weakening: f64,
}

impl Controller {
    pub fn new(motor: Motor) -> Self {
        let gain = motor.inertia * SPEED_SHARE * BANDWIDTH / motor.period;
        Self {
            most_torque: motor.greatest_torque(motor.weakened(0.0, f64::MAX, 0.0, motor.voltage), 0.0, motor.voltage),
            direct: Regulator::of_current(motor.direct_inductance, &motor),
            quadrature: Regulator::of_current(motor.quadrature_inductance, &motor),
            speed: Regulator { gain, step: 0.25 * SPEED_SHARE * BANDWIDTH * gain, integral: 0.0 },
            weakening: 0.0,
            motor,
        }
    }

    /// Return the duty ratios of the three legs.
    pub fn step(&mut self, measured: &Measured, demand: Demand) -> [f64; 3] {
        let motor = self.motor;
        let [a, b, c] = measured.currents;
        let link = measured.link.max(1.0); // a sensor may show 0
        let (speed, limit) = (motor.pole_pairs * measured.speed, link / ROOT_THREE);
        let (alpha, beta) = ((2.0 * a - b - c) / 3.0, (b - c) / ROOT_THREE);
        let (sine, cosine) = (motor.pole_pairs * measured.angle).sin_cos();
        let (direct, quadrature) = (cosine * alpha + sine * beta, cosine * beta - sine * alpha);

        let waiting = self.speed.integral;
        let mut allowed = VOLTAGE_SHARE * limit;
        let torque = match demand {
            Demand::Torque(torque) => torque,
            Demand::Speed(target) => self.speed.output(target - measured.speed),
        };
        if matches!(demand, Demand::Speed(_)) && torque * speed < 0.0 {
            allowed -= BRAKING_SHARE * limit * (torque.abs() / (0.2 * self.most_torque)).min(1.0);
        }
        let wanted = torque.abs().min(self.most_torque);
        let target = motor.weakened(motor.least_current(wanted), wanted, speed.abs(), allowed) + self.weakening;
        let target = target.max(motor.deepest());
        let possible = motor.greatest_torque(target, speed.abs(), allowed).max(0.0);
        // The speed integral waits while the limits leave less than it demands.
        if torque.abs() > possible && torque * (self.speed.integral - waiting) > 0.0 {
            self.speed.integral = waiting;
        }

        let across = torque.clamp(-possible, possible) / motor.torque_per_ampere(target);
        let mut voltage = [
            self.direct.output(target - direct) - speed * motor.quadrature_inductance * quadrature,
            self.quadrature.output(across - quadrature) + speed * (motor.direct_inductance * direct + motor.magnet_flux),
        ];
        let length = voltage[0].hypot(voltage[1]);
        let excess = 1.0 - (limit / length.max(1e-6)).min(1.0);
        for (regulator, output) in [&mut self.direct, &mut self.quadrature].into_iter().zip(&mut voltage) {
            regulator.integral -= regulator.step * excess * *output / regulator.gain;
            *output -= excess * *output;
        }
        let trim = 0.1 * BANDWIDTH * motor.current_limit / motor.voltage;
        self.weakening += trim * (0.5 * (1.0 + VOLTAGE_SHARE) * limit - length);
        self.weakening = self.weakening.clamp(-0.3 * motor.current_limit, 0.0);

        // The voltage acts later; the rotor turns on meanwhile.
        let (sine, cosine) = (motor.pole_pairs * measured.angle + speed * motor.delay).sin_cos();
        let (alpha, beta) = (cosine * voltage[0] - sine * voltage[1], sine * voltage[0] + cosine * voltage[1]);
        let phases = [alpha, 0.5 * (ROOT_THREE * beta - alpha), -0.5 * (ROOT_THREE * beta + alpha)];
        let highest = phases.into_iter().fold(f64::MIN, f64::max);
        let lowest = phases.into_iter().fold(f64::MAX, f64::min);
        phases.map(|phase| (0.5 + (phase - 0.5 * (highest + lowest)) / link).clamp(0.0, 1.0))
    }
}
