/* current_signals.c: the variables of a controller of current reference and advance angle. */
#include "signals.h"

#include <math.h>
#include <string.h>

/* Value references, as build_fmu.py writes them into modelDescription.xml. */
enum {
    SPEED_REFERENCE = 1,
    SPEED,
    CURRENT_MAGNITUDE_SUM,
    HALF_SUPPLY_VOLTAGE,
    CURRENT_REFERENCE = 11,
    ADVANCE_ANGLE,
    INPUT_POWER,
    PHASES = 21,
    POLE_PAIRS,
    KIND,
    NOMINAL_HALF_SUPPLY_VOLTAGE = 31,
    BASE_SPEED,
    RATED_POWER,
    CURRENT_LIMIT,
    CONTROL_PERIOD,
    HYSTERESIS_BAND,
    RESISTANCE,
    INDUCTANCE,
    EMF_CONSTANT,
    INERTIA,
    WINDOW,
    CONDUCTING_PHASES,
    ADVANCE_START,
    ADVANCE_SLOPE,
    HIGHEST_SPEED,
    PHASE_CURRENTS = 101 /* the first one; the others follow */
};

void signals_reset(signals *self) {
    memset(self, 0, sizeof *self);
    self->nameplate.struct_size = sizeof self->nameplate;
    self->sense.struct_size = sizeof self->sense;
    self->sense.phase_count = CONTROLLER_PHASES;
    self->sense.phase_currents = self->phase_currents;
    self->command = (drivegate_command){sizeof self->command, 0.0, 0.0, NAN};
}

double *signals_real(signals *self, unsigned reference) {
    drivegate_nameplate *nameplate = &self->nameplate;
    if (reference >= PHASE_CURRENTS && reference < PHASE_CURRENTS + CONTROLLER_PHASES)
        return &self->phase_currents[reference - PHASE_CURRENTS];
    switch (reference) {
    case SPEED_REFERENCE: return &self->sense.speed_reference;
    case SPEED: return &self->sense.speed;
    case CURRENT_MAGNITUDE_SUM: return &self->sense.current_magnitude_sum;
    case HALF_SUPPLY_VOLTAGE: return &self->sense.half_supply_voltage;
    case CURRENT_REFERENCE: return &self->command.current_reference;
    case ADVANCE_ANGLE: return &self->command.advance_angle;
    case INPUT_POWER: return &self->command.input_power;
    case NOMINAL_HALF_SUPPLY_VOLTAGE: return &nameplate->half_supply_voltage;
    case BASE_SPEED: return &nameplate->base_speed;
    case RATED_POWER: return &nameplate->rated_power;
    case CURRENT_LIMIT: return &nameplate->current_limit;
    case CONTROL_PERIOD: return &nameplate->control_period;
    case HYSTERESIS_BAND: return &nameplate->hysteresis_band;
    case RESISTANCE: return &nameplate->resistance;
    case INDUCTANCE: return &nameplate->inductance;
    case EMF_CONSTANT: return &nameplate->emf_constant;
    case INERTIA: return &nameplate->inertia;
    case WINDOW: return &nameplate->window;
    case CONDUCTING_PHASES: return &nameplate->conducting_phases;
    case ADVANCE_START: return &nameplate->advance_start;
    case ADVANCE_SLOPE: return &nameplate->advance_slope;
    case HIGHEST_SPEED: return &nameplate->highest_speed;
    default: return NULL;
    }
}

int64_t *signals_integer(signals *self, unsigned reference) {
    switch (reference) {
    case PHASES: return &self->nameplate.phases;
    case POLE_PAIRS: return &self->nameplate.pole_pairs;
    case KIND: return &self->nameplate.kind;
    default: return NULL;
    }
}

/* The array of phase currents is one variable with many values. */
size_t signals_width(unsigned reference) { return reference == PHASE_CURRENTS ? CONTROLLER_PHASES : 1; }

int signals_begin(signals *self, void *state) { return drivegate_reset(state, &self->nameplate); }

void signals_step(signals *self, void *state, double time) {
    self->sense.time = time;
    self->command = (drivegate_command){sizeof self->command, NAN, NAN, NAN};
    drivegate_step(state, &self->sense, &self->command);
}
