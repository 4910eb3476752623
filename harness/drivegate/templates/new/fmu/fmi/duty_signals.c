/* duty_signals.c: the variables of a controller of duty ratios. */
#include "signals.h"

#include <math.h>
#include <string.h>

/* Value references, as build_fmu.py writes them into modelDescription.xml. */
enum {
    REFERENCE = 1,
    SUPPLY_VOLTAGE,
    SUPPLY_CURRENT,
    ANGLE,
    SPEED,
    HALL,
    ENCODER_COUNT,
    TRIP,
    ENABLE,
    SOURCE_CURRENT,
    WINDING_TEMPERATURE,
    NEXT_PERIOD = 16,
    TORQUE,
    INPUT_POWER,
    FAULT,
    BRAKE_DUTY,
    KIND = 21,
    REFERENCE_KIND,
    POLE_PAIRS,
    UPDATES,
    UPDATE_DELAY,
    CONTROL_EVERY,
    POSITION,
    IS_REVERSING,
    NOMINAL_SUPPLY_VOLTAGE = 31,
    BASE_SPEED,
    HIGHEST_SPEED,
    RATED_POWER,
    CURRENT_LIMIT,
    CONTROL_PERIOD,
    DEAD_TIME,
    RESISTANCE,
    DIRECT_INDUCTANCE,
    QUADRATURE_INDUCTANCE,
    MAGNET_FLUX,
    INERTIA,
    CORE_LOSS_CONDUCTANCE,
    SWITCH_DROP,
    DIODE_DROP,
    POSITION_ERROR,
    LINK_CAPACITANCE,
    SOURCE_RESISTANCE,
    LINK_LIMIT,
    CHARGE_LIMIT,
    DISCHARGE_LIMIT,
    CHOPPER_VOLTAGE,
    CHOPPER_RESISTANCE,
    LEAST_SPEED,
    START_TIME,
    HEAT_CAPACITY,
    THERMAL_RESISTANCE,
    AMBIENT_TEMPERATURE,
    TEMPERATURE_LIMIT,
    TEMPERATURE_COEFFICIENT,
    TEMPERATURE_LAG,
    VOLTAGE_FILTER,
    PHASE_CURRENTS = 101, /* the first of each three; the others follow */
    DUTY_RATIOS = 111,
    LEGS = 121,
    PHASE_VOLTAGES = 131,
    MEAN_VOLTAGES = 141
};

static void clear_command(signals *self) {
    memset(&self->command, 0, sizeof self->command);
    self->command.struct_size = sizeof self->command;
    for (int leg = 0; leg < 3; leg++) {
        self->command.duty_ratios[leg] = NAN;
        self->command.legs[leg] = DRIVEGATE_LEG_PWM;
    }
    self->command.torque = self->command.angle = self->command.speed = self->command.input_power = NAN;
    self->command.brake_duty = NAN;
}

void signals_reset(signals *self) {
    memset(self, 0, sizeof *self);
    self->nameplate.struct_size = sizeof self->nameplate;
    self->sense.struct_size = sizeof self->sense;
    self->sense.phase_currents = self->phase_currents;
    clear_command(self);
}

double *signals_real(signals *self, unsigned reference) {
    drivegate_duty_nameplate *nameplate = &self->nameplate;
    if (reference >= PHASE_CURRENTS && reference < PHASE_CURRENTS + 3)
        return &self->phase_currents[reference - PHASE_CURRENTS];
    if (reference >= PHASE_VOLTAGES && reference < PHASE_VOLTAGES + 3)
        return &self->sense.phase_voltages[reference - PHASE_VOLTAGES];
    if (reference >= MEAN_VOLTAGES && reference < MEAN_VOLTAGES + 3)
        return &self->sense.mean_voltages[reference - MEAN_VOLTAGES];
    if (reference >= DUTY_RATIOS && reference < DUTY_RATIOS + 3)
        return &self->command.duty_ratios[reference - DUTY_RATIOS];
    if (reference >= LEGS && reference < LEGS + 3) return &self->legs[reference - LEGS];
    switch (reference) {
    case REFERENCE: return &self->sense.reference;
    case SUPPLY_VOLTAGE: return &self->sense.supply_voltage;
    case SUPPLY_CURRENT: return &self->sense.supply_current;
    case ANGLE: return &self->sense.angle;
    case SPEED: return &self->sense.speed;
    case HALL: return &self->hall;
    case ENCODER_COUNT: return &self->encoder_count;
    case TRIP: return &self->trip;
    case ENABLE: return &self->enable;
    case SOURCE_CURRENT: return &self->sense.source_current;
    case WINDING_TEMPERATURE: return &self->sense.winding_temperature;
    case NEXT_PERIOD: return &self->command.next_period;
    case TORQUE: return &self->command.torque;
    case INPUT_POWER: return &self->command.input_power;
    case FAULT: return &self->fault;
    case BRAKE_DUTY: return &self->command.brake_duty;
    case NOMINAL_SUPPLY_VOLTAGE: return &nameplate->supply_voltage;
    case BASE_SPEED: return &nameplate->base_speed;
    case HIGHEST_SPEED: return &nameplate->highest_speed;
    case RATED_POWER: return &nameplate->rated_power;
    case CURRENT_LIMIT: return &nameplate->current_limit;
    case CONTROL_PERIOD: return &nameplate->control_period;
    case DEAD_TIME: return &nameplate->dead_time;
    case RESISTANCE: return &nameplate->resistance;
    case DIRECT_INDUCTANCE: return &nameplate->direct_inductance;
    case QUADRATURE_INDUCTANCE: return &nameplate->quadrature_inductance;
    case MAGNET_FLUX: return &nameplate->magnet_flux;
    case INERTIA: return &nameplate->inertia;
    case CORE_LOSS_CONDUCTANCE: return &nameplate->core_loss_conductance;
    case SWITCH_DROP: return &nameplate->switch_drop;
    case DIODE_DROP: return &nameplate->diode_drop;
    case POSITION_ERROR: return &nameplate->position_error;
    case LINK_CAPACITANCE: return &nameplate->link_capacitance;
    case SOURCE_RESISTANCE: return &nameplate->source_resistance;
    case LINK_LIMIT: return &nameplate->link_limit;
    case CHARGE_LIMIT: return &nameplate->charge_limit;
    case DISCHARGE_LIMIT: return &nameplate->discharge_limit;
    case CHOPPER_VOLTAGE: return &nameplate->chopper_voltage;
    case CHOPPER_RESISTANCE: return &nameplate->chopper_resistance;
    case LEAST_SPEED: return &nameplate->least_speed;
    case START_TIME: return &nameplate->start_time;
    case HEAT_CAPACITY: return &nameplate->heat_capacity;
    case THERMAL_RESISTANCE: return &nameplate->thermal_resistance;
    case AMBIENT_TEMPERATURE: return &nameplate->ambient_temperature;
    case TEMPERATURE_LIMIT: return &nameplate->temperature_limit;
    case TEMPERATURE_COEFFICIENT: return &nameplate->temperature_coefficient;
    case TEMPERATURE_LAG: return &nameplate->temperature_lag;
    case VOLTAGE_FILTER: return &nameplate->voltage_filter;
    default: return NULL;
    }
}

int64_t *signals_integer(signals *self, unsigned reference) {
    switch (reference) {
    case KIND: return &self->nameplate.kind;
    case REFERENCE_KIND: return &self->nameplate.reference_kind;
    case POLE_PAIRS: return &self->nameplate.pole_pairs;
    case UPDATES: return &self->nameplate.updates;
    case UPDATE_DELAY: return &self->nameplate.update_delay;
    case CONTROL_EVERY: return &self->nameplate.control_every;
    case POSITION: return &self->nameplate.position;
    case IS_REVERSING: return &self->nameplate.is_reversing;
    default: return NULL;
    }
}

size_t signals_width(unsigned reference) {
    return reference == PHASE_CURRENTS || reference == PHASE_VOLTAGES || reference == MEAN_VOLTAGES || reference == DUTY_RATIOS || reference == LEGS
               ? 3
               : 1;
}

int signals_begin(signals *self, void *state) { return drivegate_duty_reset(state, &self->nameplate); }

void signals_step(signals *self, void *state, double time) {
    self->sense.time = time;
    self->sense.hall = (int64_t)self->hall;
    self->sense.encoder_count = (int64_t)self->encoder_count;
    self->sense.trip = (int64_t)self->trip;
    self->sense.enable = (int64_t)self->enable;
    clear_command(self);
    drivegate_duty_step(state, &self->sense, &self->command);
    for (int leg = 0; leg < 3; leg++) self->legs[leg] = (double)self->command.legs[leg];
    self->fault = (double)self->command.fault;
}
