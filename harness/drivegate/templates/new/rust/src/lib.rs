//! A speed regulator, and an advance angle that rises with speed by a straight line.

use std::f64::consts::PI;

/// What the controller may know of its drive before a run; the records are those of `drivegate.h`.
#[repr(C)]
pub struct Nameplate {
    struct_size: i64,
    phases: i64,
    pole_pairs: i64,
    half_supply_voltage: f64,
    base_speed: f64,
    rated_power: f64,
    current_limit: f64,
    control_period: f64,
    hysteresis_band: f64,
    resistance: f64,
    inductance: f64,
    emf_constant: f64,
    inertia: f64,
    kind: i64,
    window: f64,
    conducting_phases: f64,
    advance_start: f64,
    advance_slope: f64,
    highest_speed: f64,
}

/// What the controller senses at the start of a control period.
#[repr(C)]
pub struct Sense {
    struct_size: i64,
    time: f64,
    speed_reference: f64,
    speed: f64,
    phase_count: i64,
    phase_currents: *const f64,
    current_magnitude_sum: f64,
    half_supply_voltage: f64,
}

/// What the controller answers.
#[repr(C)]
pub struct Command {
    struct_size: i64,
    current_reference: f64,
    advance_angle: f64,
    input_power: f64,
}

/// All that the controller remembers. The buffer is drivegate's; keep nothing in statics, so that many can run.
#[repr(C)]
pub struct Controller {
    proportional: f64,
    integral_step: f64,
    limit: f64,
    base_speed: f64,
    advance_start: f64,
    advance_slope: f64,
    integral: f64,
}

impl Controller {
    fn new(nameplate: &Nameplate) -> Self {
        // The torque that one ampere gives (N·m/A).
        let torque_per_ampere = nameplate.conducting_phases * nameplate.emf_constant;
        // The speed follows its reference with 80 rad/s, and the integral with 15 rad/s, on a drive of 576 rad/s
        // electrical at base speed; on others in proportion.
        let rate = nameplate.pole_pairs as f64 * nameplate.base_speed / 575.9586531581288;
        let proportional = nameplate.inertia * (80.0 * rate) / torque_per_ampere;
        Controller {
            proportional,
            integral_step: proportional * (15.0 * rate) * nameplate.control_period,
            limit: nameplate.current_limit,
            base_speed: nameplate.base_speed,
            advance_start: nameplate.advance_start,
            advance_slope: nameplate.advance_slope,
            integral: 0.0,
        }
    }

    /// Answer for one control period; all quantities are in SI units.
    fn step(&mut self, sense: &Sense, command: &mut Command) {
        command.current_reference = self.regulate(sense.speed_reference - sense.speed);
        command.advance_angle = self.angle(sense.speed);
        // An estimate of the input power; leave it out if the controller makes none.
        command.input_power = sense.half_supply_voltage * sense.current_magnitude_sum;
    }

    /// Give the current reference (A); the integral waits while the limits leave nothing to do.
    fn regulate(&mut self, error: f64) -> f64 {
        let integral = self.integral + self.integral_step * error;
        let reference = self.proportional * error + integral;
        let limited = reference.clamp(0.0, self.limit);
        if limited == reference {
            self.integral = integral;
        }
        limited
    }

    /// Give the advance angle (rad, electrical). Below base speed it must be 0 exactly (check ADV-1).
    fn angle(&self, speed: f64) -> f64 {
        if speed < self.base_speed {
            return 0.0;
        }
        // Your search for the angle of least input power would add its own part here (check CNV-2).
        (self.advance_start + self.advance_slope * (speed - self.base_speed)).clamp(0.0, 0.5 * PI)
    }
}

#[no_mangle]
pub extern "C" fn drivegate_abi_version() -> i64 {
    1001
}

#[no_mangle]
pub extern "C" fn drivegate_state_size() -> i64 {
    std::mem::size_of::<Controller>() as i64
}

/// Prepare for a run: called before every one, and must forget everything.
///
/// # Safety
/// drivegate passes a buffer of `drivegate_state_size` bytes, aligned to 16, and a valid record.
#[no_mangle]
pub unsafe extern "C" fn drivegate_reset(state: *mut Controller, nameplate: *const Nameplate) -> i32 {
    state.write(Controller::new(&*nameplate));
    0
}

/// # Safety
/// drivegate passes the state that was reset, and valid records.
#[no_mangle]
pub unsafe extern "C" fn drivegate_step(state: *mut Controller, sense: *const Sense, command: *mut Command) {
    (*state).step(&*sense, &mut *command);
}
