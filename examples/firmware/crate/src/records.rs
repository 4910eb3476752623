//! The records of drivegate_duty.h.

#[repr(C)]
pub struct Nameplate {
    pub struct_size: i64,
    pub kind: i64,
    pub reference_kind: i64,
    pub pole_pairs: i64,
    pub updates: i64,
    pub update_delay: i64,
    pub supply_voltage: f64,
    pub base_speed: f64,
    pub highest_speed: f64,
    pub rated_power: f64,
    pub current_limit: f64,
    pub control_period: f64,
    pub dead_time: f64,
    pub resistance: f64,
    pub direct_inductance: f64,
    pub quadrature_inductance: f64,
    pub magnet_flux: f64,
    pub inertia: f64,
    pub core_loss_conductance: f64,
}

/// Its end is left out: the adapter reads nothing behind the speed.
#[repr(C)]
pub struct Sense {
    pub struct_size: i64,
    pub time: f64,
    pub reference: f64,
    pub phase_currents: *const [f64; 3],
    pub supply_voltage: f64,
    pub supply_current: f64,
    pub angle: f64,
    pub speed: f64,
}

/// Its end is left out: the adapter writes nothing behind the duty ratios.
#[repr(C)]
pub struct Command {
    pub struct_size: i64,
    pub duty_ratios: [f64; 3],
}
