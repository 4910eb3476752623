//! Faults of memory and arithmetic, one for each torque reference; the line of each has its name in a comment.
#![allow(clippy::all)]
use std::hint::black_box;

#[repr(C)]
pub struct Sense {
    struct_size: i64,
    time: f64,
    reference: f64,
    phase_currents: *const f64,
}

#[repr(C)]
pub struct Command {
    struct_size: i64,
    duty_ratios: [f64; 3],
    legs: [i64; 3],
    next_period: f64,
    torque: f64,
}

#[no_mangle]
pub extern "C" fn drivegate_abi_version() -> i64 {
    1001
}

#[no_mangle]
pub extern "C" fn drivegate_state_size() -> i64 {
    32
}

#[no_mangle]
pub extern "C" fn drivegate_duty_reset(_state: *mut [f64; 4], _nameplate: *const f64) -> i32 {
    0
}

#[no_mangle]
pub unsafe extern "C" fn drivegate_duty_step(state: *mut [f64; 4], sense: *const Sense, command: *mut Command) {
    let (sense, command) = (&*sense, &mut *command);
    command.duty_ratios = [0.5; 3];
    command.torque = 0.0;
    let number = black_box((10.0 * sense.reference + 0.5) as i32);
    if sense.time < 0.001 {
        return;
    }
    let (table, bytes) = (black_box([1.0, 2.0, 3.0]), black_box([0u8; 24]));
    command.torque = match number {
        1 => table[number as usize + 2], // past the end
        2 => (black_box(50000 * number) * 50000) as f64, // overflow of a product
        3 => (1 << (number + 29)) as f64, // shift by 32
        4 => (100 / (number - 4)) as f64, // division by zero
        5 => *(bytes.as_ptr().add(number as usize) as *const f64), // misaligned access
        6 => *table.get_unchecked(number as usize), // unchecked index
        7 => *sense.phase_currents.add(3), // past the currents
        8 => *(state as *const f64).add(4), // past the state
        _ => 0.0,
    };
}
