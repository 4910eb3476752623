//! The controller of ../python in Rust, behind the functions of drivegate.h: no crates, no allocation, no panic.

use std::ffi::{c_int, c_void};

const ABI_VERSION: i64 = 1001;

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

#[repr(C)]
pub struct Command {
    struct_size: i64,
    current_reference: f64,
    advance_angle: f64,
    input_power: f64,
}

const DEGREE: f64 = 0.017453292519943295;

/// The search decides once in this time (rad at base speed).
const INTERVAL: f64 = 57.5;
/// A speed that stays behind for so long has lost its torque (rad at base speed).
const PATIENCE: f64 = 4.6;
/// Shares of base speed: a calm error, a creeping one, and how far above it the advance begins.
const CALM: f64 = 0.003;
const CREEPING: f64 = 0.0014;
const MARGIN: f64 = 0.02;
const FIRST_STEP: f64 = 2.0 * DEGREE;
const LAST_STEP: f64 = 0.7 * DEGREE;
const HIGHEST: f64 = 24.0 * DEGREE;
const NOWHERE: f64 = -90.0 * DEGREE;

#[derive(Clone, Copy, Default, PartialEq)]
enum Phase {
    #[default]
    Waiting,
    Searching,
    Recovering,
    Resting,
}

#[derive(Default)]
struct Controller {
    limit: f64,
    base_speed: f64,
    nominal_voltage: f64,
    period: f64,
    gain: f64,
    integral_step: f64,
    integral: f64,
    interval: f64,
    patience: f64,
    calm: f64,
    creeping: f64,
    advance_begins: f64,
    line_start: f64,
    line_slope: f64,
    speed_reference: f64,
    speed_mark: f64,
    current_sum: f64,
    worst_error: f64,
    last_current: f64,
    offset: f64,
    step_size: f64,
    lost_offset: f64,
    best_offset: f64,
    best_current: f64,
    best_integral: f64,
    advancing: bool,
    phase: Phase,
    intervals: i64,
    steps: i64,
    moves: i64,
    escapes: i64,
    strained: i64,
}

fn limited(value: f64, lowest: f64, highest: f64) -> f64 {
    if value < lowest {
        lowest
    } else if value > highest {
        highest
    } else {
        value
    }
}

impl Controller {
    fn new(nameplate: &Nameplate) -> Self {
        let frequency = nameplate.pole_pairs as f64 * nameplate.base_speed;
        let bandwidth = frequency / 7.2;
        let torque_per_ampere = nameplate.conducting_phases * nameplate.emf_constant;
        let gain = bandwidth * nameplate.inertia / torque_per_ampere;
        Self {
            limit: nameplate.current_limit,
            base_speed: nameplate.base_speed,
            nominal_voltage: nameplate.half_supply_voltage,
            period: nameplate.control_period,
            gain,
            integral_step: 0.1875 * bandwidth * gain * nameplate.control_period,
            interval: INTERVAL / frequency,
            patience: PATIENCE / frequency,
            calm: CALM * nameplate.base_speed,
            creeping: CREEPING * nameplate.base_speed,
            advance_begins: nameplate.base_speed + MARGIN * nameplate.base_speed,
            line_start: nameplate.advance_start,
            line_slope: nameplate.advance_slope,
            speed_reference: -1.0,
            lost_offset: NOWHERE,
            ..Self::default()
        }
    }

    fn step(&mut self, sense: &Sense, command: &mut Command) {
        let error = sense.speed_reference - sense.speed;
        let reference = self.regulate(error);
        command.current_reference = reference;
        command.advance_angle = 0.0;
        command.input_power = sense.half_supply_voltage * sense.current_magnitude_sum;
        if sense.speed_reference != self.speed_reference {
            self.speed_reference = sense.speed_reference;
            self.offset = 0.0;
            self.begin_anew();
        }
        if sense.speed < self.base_speed {
            self.advancing = false;
        } else if sense.speed >= self.advance_begins {
            self.advancing = true;
        }
        if !self.advancing {
            return;
        }

        if error.abs() > self.worst_error {
            self.worst_error = error.abs();
        }
        self.current_sum += sense.current_magnitude_sum;
        self.steps += 1;
        if self.has_lost_torque(error, reference, sense.speed) {
            self.regain_torque();
        } else if self.steps as f64 * self.period >= self.interval {
            self.end_interval();
        }
        command.advance_angle = self.advance_angle(sense.speed, sense.half_supply_voltage);
    }

    /// Return the current reference: a PI regulator whose integral waits while the output is limited.
    fn regulate(&mut self, error: f64) -> f64 {
        let integral = self.integral + self.integral_step * error;
        let reference = self.gain * error + integral;
        let output = limited(reference, 0.0, self.limit);
        if output == reference {
            self.integral = integral;
        }
        output
    }

    /// Return the initial line over speed, at the same EMF over supply, plus the search's offset.
    fn advance_angle(&self, speed: f64, voltage: f64) -> f64 {
        let speed = if voltage > 1.0 { speed * self.nominal_voltage / voltage } else { speed };
        let line = self.line_start + self.line_slope * (speed - self.base_speed);
        limited(line + self.offset, 0.0, 90.0 * DEGREE)
    }

    /// Begin a new search, with nothing known of the edge where the torque is lost.
    fn begin_anew(&mut self) {
        self.lost_offset = NOWHERE;
        self.enter(Phase::Waiting);
        self.last_current = 0.0;
    }

    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.intervals = 0;
        self.begin_interval();
    }

    /// Begin to take the mean of the current sum.
    fn begin_interval(&mut self) {
        self.steps = 0;
        self.current_sum = 0.0;
        self.worst_error = 0.0;
    }

    /// Decide on the angle from the mean of the current sum over the interval.
    fn end_interval(&mut self) {
        let current = self.current_sum / self.steps as f64;
        let error = self.worst_error;
        let change = (current - self.last_current).abs();
        self.intervals += 1;
        self.begin_interval();
        match self.phase {
            Phase::Waiting => {
                self.last_current = current;
                if self.intervals >= 2 && error <= self.calm && change <= 0.004 * current {
                    self.keep(current);
                    self.moves = 0;
                    self.step_size = -FIRST_STEP;
                    self.try_next();
                }
            }
            Phase::Searching => {
                if self.intervals >= 2 {
                    self.judge(current, error);
                }
            }
            Phase::Recovering => {
                if error <= self.calm {
                    self.try_next();
                } else if self.intervals >= 3 {
                    // The best angle so far keeps the torque for a while only.
                    self.lost_offset = self.best_offset;
                    self.best_offset = self.best_offset + FIRST_STEP;
                    self.offset = self.best_offset;
                    self.unwind();
                    self.enter(Phase::Recovering);
                }
            }
            Phase::Resting => {
                if self.intervals < 3 {
                    self.last_current = current;
                } else if (current - self.best_current).abs() > 0.05 * self.best_current {
                    self.begin_anew();
                } else if self.intervals < 25 && change > 0.003 * self.last_current {
                    // Restless, so too near to the edge.
                    self.offset = self.offset + 0.5 * DEGREE;
                    self.enter(Phase::Resting);
                }
            }
        }
    }

    /// Keep the angle that was tried if the current sum is less there and the regulator does not creep up.
    fn judge(&mut self, current: f64, error: f64) {
        let creeps = error >= self.creeping && self.integral >= 1.02 * self.best_integral;
        if current < 0.999 * self.best_current && !creeps {
            self.keep(current);
            self.moves += 1;
        } else if self.moves == 0 && self.step_size == -FIRST_STEP {
            self.step_size = 0.5 * FIRST_STEP;
        } else {
            self.step_size = 0.5 * self.step_size;
        }
        self.try_next();
    }

    /// Note the present angle as the best one.
    fn keep(&mut self, current: f64) {
        self.best_current = current;
        self.best_offset = self.offset;
        self.best_integral = self.integral;
    }

    /// Go one step on from the best angle, by half a step where more loses the torque; or rest there.
    fn try_next(&mut self) {
        let mut following = self.best_offset + self.step_size;
        if following <= self.lost_offset {
            self.step_size = 0.5 * self.step_size;
            following = self.best_offset + self.step_size;
        }
        if self.step_size.abs() < LAST_STEP || following <= self.lost_offset {
            self.offset = self.best_offset;
            self.escapes = 0;
            self.enter(Phase::Resting);
        } else {
            self.offset = following;
            self.enter(Phase::Searching);
        }
    }

    /// Return whether the speed has stayed behind for some time, or does not rise at the current limit.
    fn has_lost_torque(&mut self, error: f64, reference: f64, speed: f64) -> bool {
        let settled = self.phase == Phase::Searching || self.phase == Phase::Resting;
        let strained = if settled { error > self.calm } else { reference >= self.limit };
        self.strained = if strained { self.strained + 1 } else { 0 };
        if self.strained == 1 {
            self.speed_mark = speed;
        }
        if (self.strained as f64) * self.period < self.patience {
            return false;
        }
        self.strained = 0;
        settled || speed <= self.speed_mark
    }

    /// Go back from the edge of what the angle allows.
    fn regain_torque(&mut self) {
        if self.phase == Phase::Searching {
            self.lost_offset = self.offset;
            self.step_size = 0.5 * self.step_size;
            self.offset = self.best_offset + FIRST_STEP;
            self.unwind();
            self.enter(Phase::Recovering);
        } else if self.phase == Phase::Resting && self.intervals < 3 && self.escapes < 2 {
            self.escapes += 1;
            self.offset = self.offset + 0.5 * DEGREE;
            self.unwind();
            self.enter(Phase::Resting);
        } else {
            // The load has risen, or the initial line is too low.
            let within = self.offset >= 0.0 && self.offset < HIGHEST;
            self.offset = if within { self.offset + FIRST_STEP } else { 0.0 };
            self.enter(Phase::Waiting);
        }
    }

    /// Take back what the integral has wound up in vain.
    fn unwind(&mut self) {
        let most = 1.02 * self.best_integral;
        if most < self.integral {
            self.integral = most;
        }
    }
}

#[no_mangle]
pub extern "C" fn drivegate_abi_version() -> i64 {
    ABI_VERSION
}

#[no_mangle]
pub extern "C" fn drivegate_state_size() -> i64 {
    std::mem::size_of::<Controller>() as i64
}

/// # Safety
/// Both pointers are valid, and the state is as large and aligned as drivegate.h says.
#[no_mangle]
pub unsafe extern "C" fn drivegate_reset(state: *mut c_void, nameplate: *const Nameplate) -> c_int {
    state.cast::<Controller>().write(Controller::new(&*nameplate));
    0
}

/// # Safety
/// All pointers are valid, and the state has been reset.
#[no_mangle]
pub unsafe extern "C" fn drivegate_step(state: *mut c_void, sense: *const Sense, command: *mut Command) {
    (*state.cast::<Controller>()).step(&*sense, &mut *command);
}
