//! What drivegate calls: it makes the controller in the memory of the harness, and passes signals on.

use crate::foc::{Controller, Demand, Measured, Motor};
use crate::records::{Command, Nameplate, Sense};

type Instance = (Controller, fn(f64) -> Demand);

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
    let motor = Motor {
        pole_pairs: plate.pole_pairs as f64,
        resistance: plate.resistance,
        direct_inductance: plate.direct_inductance,
        quadrature_inductance: plate.quadrature_inductance,
        magnet_flux: plate.magnet_flux,
        inertia: plate.inertia,
        current_limit: plate.current_limit,
        voltage: plate.supply_voltage,
        period: plate.control_period,
        delay: (plate.update_delay as f64 + 0.5) * plate.control_period,
    };
    state.write((Controller::new(motor), if plate.reference_kind == 1 { Demand::Torque } else { Demand::Speed }));
    0
}

#[no_mangle]
pub unsafe extern "C" fn drivegate_duty_step(state: &mut Instance, sense: &Sense, command: &mut Command) {
    let (currents, link) = (*sense.phase_currents, sense.supply_voltage);
    let measured = Measured { currents, link, angle: sense.angle, speed: sense.speed };
    command.duty_ratios = state.0.step(&measured, state.1(sense.reference));
}
