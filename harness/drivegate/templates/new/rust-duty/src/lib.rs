//! Field-oriented control: a speed regulator, the least current for a torque, field weakening, current regulators with
//! decoupling and anti-windup, and min-max modulation. Every constant follows from the nameplate; all quantities are in
//! SI units.

const TORQUE_REFERENCE: i64 = 1;
const ROOT_THREE: f64 = 1.7320508075688772;
// Bandwidth of the currents over the sampling rate, of the speed over that, and of the currents' integrals over that.
const CURRENT_SHARE: f64 = 0.2;
const SPEED_SHARE: f64 = 0.02;
const INTEGRAL_SHARE: f64 = 0.1;
// Share of the voltage limit that references use; the rest is for the current regulators. Braking from a speed to a
// lower one leaves more, for a machine of less inductance than on the nameplate.
const VOLTAGE_SHARE: f64 = 0.985;
const BRAKING_SHARE: f64 = 0.185;

/// What the controller knows of its drive before a run: drivegate_duty_nameplate in drivegate_duty.h.
#[repr(C)]
pub struct Nameplate {
    struct_size: i64,
    kind: i64,
    reference_kind: i64,
    pole_pairs: i64,
    updates: i64,
    update_delay: i64,
    supply_voltage: f64,
    base_speed: f64,
    highest_speed: f64,
    rated_power: f64,
    current_limit: f64,
    control_period: f64,
    dead_time: f64,
    resistance: f64,
    direct_inductance: f64,
    quadrature_inductance: f64,
    magnet_flux: f64,
    inertia: f64,
    core_loss_conductance: f64,
    control_every: i64,
    switch_drop: f64,
    diode_drop: f64,
    position_error: f64,
}

/// What the controller senses at the start of a control period.
#[repr(C)]
pub struct Sense {
    struct_size: i64,
    time: f64,
    reference: f64,
    phase_currents: *const [f64; 3],
    supply_voltage: f64,
    supply_current: f64,
    angle: f64,
    speed: f64,
    hall: i64,
    encoder_count: i64,
    trip: i64,
    phase_voltages: [f64; 3],
    enable: i64,
}

/// What the controller answers.
#[repr(C)]
pub struct Command {
    struct_size: i64,
    duty_ratios: [f64; 3],
    legs: [i64; 3],
    next_period: f64,
    torque: f64,
    angle: f64,
    speed: f64,
    input_power: f64,
    fault: i64,
}

/// A vector along and across the magnet's axis.
#[derive(Clone, Copy)]
struct Rotor {
    direct: f64,
    quadrature: f64,
}

/// All that the controller remembers. The buffer is drivegate's; keep nothing in statics, so that many can run.
#[repr(C)]
#[derive(Default)]
pub struct Controller {
    regulates_torque: bool,
    pole_pairs: f64,
    resistance: f64,
    direct_inductance: f64,
    quadrature_inductance: f64,
    saliency: f64,
    flux: f64,
    limit: f64,
    deepest: f64,
    greatest: f64,
    lead: f64,
    direct_gain: f64,
    quadrature_gain: f64,
    direct_step: f64,
    quadrature_step: f64,
    speed_gain: f64,
    speed_step: f64,
    weakening_step: f64,
    speed_integral: f64,
    direct_integral: f64,
    quadrature_integral: f64,
    weakening: f64,
}

impl Controller {
    /// Prepare for a run: made before every one, so it forgets everything.
    fn new(nameplate: &Nameplate) -> Self {
        let period = nameplate.control_period;
        let bandwidth = CURRENT_SHARE / period;
        let mut new = Controller {
            regulates_torque: nameplate.reference_kind == TORQUE_REFERENCE,
            pole_pairs: nameplate.pole_pairs as f64,
            resistance: nameplate.resistance,
            direct_inductance: nameplate.direct_inductance,
            quadrature_inductance: nameplate.quadrature_inductance,
            saliency: nameplate.quadrature_inductance - nameplate.direct_inductance,
            flux: nameplate.magnet_flux,
            limit: nameplate.current_limit,
            // From the sample to the middle of the period in which the answer acts (s).
            lead: (nameplate.update_delay as f64 + 0.5) * period,
            direct_gain: bandwidth * nameplate.direct_inductance,
            quadrature_gain: bandwidth * nameplate.quadrature_inductance,
            speed_gain: nameplate.inertia * SPEED_SHARE * bandwidth,
            ..Default::default()
        };
        // Beyond the magnet's whole flux the voltage rises again.
        new.deepest = -(0.999 * new.limit).min(new.flux / new.direct_inductance);
        // The torque at the current limit, with the direct current that makes it the greatest.
        let turned = 2.0 * new.saliency * new.limit;
        let direct = -turned * new.limit / (new.flux + (new.flux * new.flux + 2.0 * turned * turned).sqrt());
        new.greatest = new.per_ampere(direct) * (new.limit * new.limit - direct * direct).sqrt();
        new.direct_step = CURRENT_SHARE * new.resistance.max(INTEGRAL_SHARE * new.direct_gain);
        new.quadrature_step = CURRENT_SHARE * new.resistance.max(INTEGRAL_SHARE * new.quadrature_gain);
        new.speed_step = new.speed_gain * 0.25 * SPEED_SHARE * CURRENT_SHARE;
        let base_speed = new.pole_pairs * nameplate.base_speed;
        new.weakening_step = 0.02 * CURRENT_SHARE / (base_speed * new.direct_inductance);
        new
    }

    /// Answer for one control period, with the measured phase currents (A).
    fn step(&mut self, sense: &Sense, phase_currents: &[f64; 3], command: &mut Command) {
        let (electrical, angle) = (self.pole_pairs * sense.speed, self.pole_pairs * sense.angle);
        let supply = sense.supply_voltage.max(1e-9);
        let limit = supply / ROOT_THREE;
        if sense.enable == 0 {
            self.preload(&sense.phase_voltages, angle, electrical, supply);
            command.duty_ratios = [0.5; 3];
            return;
        }
        let current = park(phase_currents, angle);
        let wanted = self.references(sense.reference, sense.speed, electrical, limit);
        let error = Rotor {
            direct: wanted.direct - current.direct,
            quadrature: wanted.quadrature - current.quadrature,
        };
        let voltage = self.regulate(error, current, electrical, limit);
        command.duty_ratios = modulate(voltage, angle + electrical * self.lead, supply);
        command.torque = self.per_ampere(current.direct) * current.quadrature;
    }

    /// Let the integrals begin at what the back-EMF adds to the nominal one, while the bridge is off.
    fn preload(&mut self, terminals: &[f64; 3], angle: f64, electrical: f64, supply: f64) {
        // Terminals at the rail of a conducting diode do not show it.
        if terminals[0].max(terminals[1]).max(terminals[2]) >= supply {
            return;
        }
        let induced = park(terminals, angle);
        self.direct_integral = induced.direct;
        self.quadrature_integral = induced.quadrature - electrical * self.flux;
    }

    /// Return the voltage that brings the currents to their references (V), within the limit.
    fn regulate(&mut self, error: Rotor, current: Rotor, electrical: f64, limit: f64) -> Rotor {
        // The coupling of the axes and the back-EMF are added in advance.
        let direct = self.direct_gain * error.direct + self.direct_integral
            - electrical * self.quadrature_inductance * current.quadrature;
        let quadrature = self.quadrature_gain * error.quadrature
            + self.quadrature_integral
            + electrical * (self.direct_inductance * current.direct + self.flux);
        // A voltage beyond the limit is shortened, not turned. What the limit cuts does not enter the integrals.
        let used = magnitude(direct, quadrature);
        let share = limit / limit.max(used);
        let cut = share - 1.0;
        self.direct_integral += self.direct_step * (error.direct + cut * direct / self.direct_gain);
        self.quadrature_integral +=
            self.quadrature_step * (error.quadrature + cut * quadrature / self.quadrature_gain);
        // A machine that differs from the nameplate shows in the voltage that is requested.
        let weakening = self.weakening + self.weakening_step * (0.5 * (1.0 + VOLTAGE_SHARE) * limit - used);
        self.weakening = between(weakening, -0.3 * self.limit, 0.0);
        Rotor { direct: share * direct, quadrature: share * quadrature }
    }

    /// Return the currents for what the reference requests, as far as the limits allow (A).
    fn references(&mut self, reference: f64, speed: f64, electrical: f64, limit: f64) -> Rotor {
        let error = reference - speed;
        let integral = self.speed_integral + self.speed_step * error;
        let torque = if self.regulates_torque { reference } else { self.speed_gain * error + integral };
        // Negative where the torque brakes: the drop of the resistance is then against the back-EMF.
        let turning = if torque < 0.0 { -electrical } else { electrical };
        let mut voltage = VOLTAGE_SHARE * limit;
        if !self.regulates_torque && turning < 0.0 {
            voltage -= BRAKING_SHARE * limit * (torque.abs() / (0.2 * self.greatest)).min(1.0);
        }
        let direct = self.direct_for(torque.abs().min(self.greatest), turning, voltage);
        let direct = (direct + self.weakening).max(self.deepest);
        let most = self.possible(direct, turning, voltage).max(0.0);
        // The integral of the speed waits while the limits allow less than it requests.
        if torque.abs() <= most || torque * error <= 0.0 {
            self.speed_integral = integral;
        }
        Rotor { direct, quadrature: between(torque, -most, most) / self.per_ampere(direct) }
    }

    /// Return the direct current (A) for a torque: the least, weakened for the voltage, or that of most torque.
    fn direct_for(&self, torque: f64, electrical: f64, voltage: f64) -> f64 {
        let (mut direct, mut deeper, near) = (self.least_current(torque), self.deepest, 0.001 * self.limit);
        if self.possible(direct, electrical, voltage) >= torque {
            return direct;
        }
        for _ in 0..14 {
            let middle = 0.5 * (direct + deeper);
            let found = self.possible(middle, electrical, voltage);
            if found >= torque || self.possible(middle - near, electrical, voltage) <= found {
                deeper = middle;
            } else {
                direct = middle;
            }
        }
        deeper
    }

    /// Return the greatest torque at a direct current within both limits (N·m), negative if there is none.
    fn possible(&self, direct: f64, electrical: f64, voltage: f64) -> f64 {
        let headroom = self.limit * self.limit - direct * direct;
        let along = electrical * (self.direct_inductance * direct + self.flux);
        let (reactance, resistance) = (electrical * self.quadrature_inductance, self.resistance);
        // The voltage is a quadratic in the quadrature current: a q² + 2 b q + c = 0 at its limit.
        let a = reactance * reactance + resistance * resistance;
        let b = resistance * (along - reactance * direct);
        let c = resistance * resistance * direct * direct + along * along - voltage * voltage;
        let inside = b * b - a * c;
        if inside < 0.0 {
            return inside;
        }
        self.per_ampere(direct) * headroom.sqrt().min((inside.sqrt() - b) / a)
    }

    /// Return the direct current with which a torque needs the least current (A).
    fn least_current(&self, torque: f64) -> f64 {
        let mut direct = 0.0;
        for _ in 0..6 {
            let quadrature = torque / self.per_ampere(direct);
            let turned = 2.0 * self.saliency * quadrature;
            direct = -turned * quadrature / (self.flux + magnitude(self.flux, turned));
        }
        direct
    }

    /// Return the torque of one ampere across the magnet's axis (N·m/A).
    fn per_ampere(&self, direct: f64) -> f64 {
        1.5 * self.pole_pairs * (self.flux - self.saliency * direct)
    }
}

/// Return a value within bounds.
fn between(value: f64, least: f64, greatest: f64) -> f64 {
    value.max(least).min(greatest)
}

/// Return the length of a vector.
fn magnitude(along: f64, across: f64) -> f64 {
    (along * along + across * across).sqrt()
}

/// Transform currents (A) or voltages (V) of the phases into the frame of the rotor, by Clarke and Park.
fn park(phases: &[f64; 3], angle: f64) -> Rotor {
    let [first, second, third] = *phases;
    let (along, across) = ((2.0 * first - second - third) / 3.0, (second - third) / ROOT_THREE);
    Rotor {
        direct: angle.cos() * along + angle.sin() * across,
        quadrature: angle.cos() * across - angle.sin() * along,
    }
}

/// Return the duty ratios for a voltage (V), by inverse Park and Clarke, centred in the link by a zero sequence.
fn modulate(voltage: Rotor, angle: f64, supply: f64) -> [f64; 3] {
    let along = angle.cos() * voltage.direct - angle.sin() * voltage.quadrature;
    let across = 0.5 * ROOT_THREE * (angle.sin() * voltage.direct + angle.cos() * voltage.quadrature);
    let (second, third) = (across - 0.5 * along, -across - 0.5 * along);
    let middle = 0.5 * (along.max(second).max(third) + along.min(second).min(third));
    [along, second, third].map(|phase| between(0.5 + (phase - middle) / supply, 0.0, 1.0))
}

#[no_mangle]
pub extern "C" fn drivegate_abi_version() -> i64 {
    1001
}

#[no_mangle]
pub extern "C" fn drivegate_state_size() -> i64 {
    std::mem::size_of::<Controller>() as i64
}

/// # Safety
/// drivegate passes a buffer of `drivegate_state_size` bytes, aligned to 16, and a valid record.
#[no_mangle]
pub unsafe extern "C" fn drivegate_duty_reset(state: *mut Controller, nameplate: *const Nameplate) -> i32 {
    state.write(Controller::new(&*nameplate));
    0
}

/// # Safety
/// drivegate passes the state that was reset, and valid records.
#[no_mangle]
pub unsafe extern "C" fn drivegate_duty_step(state: *mut Controller, sense: *const Sense, command: *mut Command) {
    (*state).step(&*sense, &*(*sense).phase_currents, &mut *command);
}
