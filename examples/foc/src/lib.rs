//! The crate `foc` as a candidate: its regulators, transforms and modulation, without any change.

use fixed::types::I16F16;
use foc::pid::PIController;
use foc::pwm::SpaceVector;
use foc::Foc;

#[allow(dead_code)]
#[path = "../../firmware/crate/src/records.rs"]
mod records;
use records::{Command, Nameplate, Sense};

const RESOLUTION: u16 = 8400;
const SIGN: f64 = if cfg!(feature = "negative_gains") { -1.0 } else { 1.0 };

pub struct Instance {
    foc: Foc<SpaceVector, RESOLUTION>,
    pole_pairs: f64,
    torque_per_ampere: f64,
}

/// Return a regulator with a bandwidth of a fifth of the sampling rate; an output of 1 is the linear range.
fn regulator(plate: &Nameplate, inductance: f64) -> PIController {
    let linear = plate.supply_voltage / 3f64.sqrt();
    let gain = 0.2 / plate.control_period * inductance;
    let step = 0.2 * plate.resistance.max(0.1 * gain);
    let [gain, step] = [gain, step].map(|value| I16F16::from_num(SIGN * value / linear));
    PIController::new(gain, step)
}

#[no_mangle]
pub extern "C" fn drivegate_abi_version() -> i64 {
    1001
}

#[no_mangle]
pub extern "C" fn drivegate_state_size() -> i64 {
    std::mem::size_of::<Instance>() as i64
}

#[no_mangle]
pub unsafe extern "C" fn drivegate_duty_reset(state: *mut Instance, plate: &Nameplate) -> i32 {
    state.write(Instance {
        foc: Foc::new(regulator(plate, plate.direct_inductance), regulator(plate, plate.quadrature_inductance)),
        pole_pairs: plate.pole_pairs as f64,
        torque_per_ampere: 1.5 * plate.pole_pairs as f64 * plate.magnet_flux,
    });
    0
}

#[no_mangle]
pub unsafe extern "C" fn drivegate_duty_step(state: &mut Instance, sense: &Sense, command: &mut Command) {
    let [a, b, _] = (*sense.phase_currents).map(I16F16::saturating_from_num);
    // The crate's sine is made for half a turn to either side.
    let turn = std::f64::consts::TAU;
    let angle = (state.pole_pairs * sense.angle + 0.5 * turn).rem_euclid(turn) - 0.5 * turn;
    let current = I16F16::from_num(sense.reference / state.torque_per_ampere);
    let compare = state.foc.update([a, b], I16F16::from_num(angle), current, I16F16::ONE);
    command.duty_ratios = compare.map(|counts| f64::from(counts) / f64::from(RESOLUTION));
}
