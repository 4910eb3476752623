/* The controller of ../python in C: speed regulator, initial angle line, and a search for the least sum of currents. */
#include <drivegate.h>
#include <math.h>
#include <stdbool.h>

#define DEGREE 0.017453292519943295

#define INTERVAL 57.5   /* rad at base speed: the search decides once in this time */
#define PATIENCE 4.6    /* rad at base speed: a speed that stays behind for so long has lost its torque */
#define CALM 0.003      /* of base speed */
#define CREEPING 0.0014 /* of base speed */
#define MARGIN 0.02     /* of base speed: how far above it the advance begins */
#define FIRST_STEP (2.0 * DEGREE)
#define LAST_STEP (0.7 * DEGREE)
#define HIGHEST (24.0 * DEGREE)
#define NOWHERE (-90.0 * DEGREE)

typedef enum { WAITING, SEARCHING, RECOVERING, RESTING } phase;

typedef struct {
    double limit, base_speed, nominal_voltage, period, gain, integral_step, integral;
    double interval, patience, calm, creeping, advance_begins, line_start, line_slope;
    double speed_reference, speed_mark, current_sum, worst_error, last_current;
    double offset, step_size, lost_offset, best_offset, best_current, best_integral;
    int64_t advancing, intervals, steps, moves, escapes, strained;
    phase phase;
} controller;

static double limited(double value, double lowest, double highest) {
    return value < lowest ? lowest : value > highest ? highest : value;
}

/* Begin to take the mean of the current sum. */
static void begin_interval(controller *self) {
    self->steps = 0;
    self->current_sum = 0.0;
    self->worst_error = 0.0;
}

static void enter(controller *self, phase phase) {
    self->phase = phase;
    self->intervals = 0;
    begin_interval(self);
}

/* Begin a new search, with nothing known of the edge where the torque is lost. */
static void begin_anew(controller *self) {
    self->lost_offset = NOWHERE;
    enter(self, WAITING);
    self->last_current = 0.0;
}

int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }

int64_t drivegate_state_size(void) { return sizeof(controller); }

int drivegate_reset(void *state, const drivegate_nameplate *nameplate) {
    controller *self = state;
    double frequency = (double)nameplate->pole_pairs * nameplate->base_speed;
    double bandwidth = frequency / 7.2;
    *self = (controller){
        .limit = nameplate->current_limit,
        .base_speed = nameplate->base_speed,
        .nominal_voltage = nameplate->half_supply_voltage,
        .period = nameplate->control_period,
        .interval = INTERVAL / frequency,
        .patience = PATIENCE / frequency,
        .calm = CALM * nameplate->base_speed,
        .creeping = CREEPING * nameplate->base_speed,
        .advance_begins = nameplate->base_speed + MARGIN * nameplate->base_speed,
        .line_start = nameplate->advance_start,
        .line_slope = nameplate->advance_slope,
        .speed_reference = -1.0,
    };
    self->gain = bandwidth * nameplate->inertia / (nameplate->conducting_phases * nameplate->emf_constant);
    self->integral_step = 0.1875 * bandwidth * self->gain * nameplate->control_period;
    begin_anew(self);
    return 0;
}

/* Return the current reference: a PI regulator whose integral waits while the output is limited. */
static double regulate(controller *self, double error) {
    double integral = self->integral + self->integral_step * error;
    double reference = self->gain * error + integral, output = limited(reference, 0.0, self->limit);
    if (output == reference) self->integral = integral;
    return output;
}

/* Return the initial line over speed, at the same EMF over supply, plus the search's offset. */
static double advance_angle(const controller *self, double speed, double voltage) {
    if (voltage > 1.0) speed = speed * self->nominal_voltage / voltage;
    double line = self->line_start + self->line_slope * (speed - self->base_speed);
    return limited(line + self->offset, 0.0, 90.0 * DEGREE);
}

/* Note the present angle as the best one. */
static void keep(controller *self, double current) {
    self->best_current = current;
    self->best_offset = self->offset;
    self->best_integral = self->integral;
}

/* Go one step on from the best angle, by half a step where more loses the torque; or rest there. */
static void try_next(controller *self) {
    double following = self->best_offset + self->step_size;
    if (following <= self->lost_offset) {
        self->step_size = 0.5 * self->step_size;
        following = self->best_offset + self->step_size;
    }
    if (fabs(self->step_size) < LAST_STEP || following <= self->lost_offset) {
        self->offset = self->best_offset;
        self->escapes = 0;
        enter(self, RESTING);
    } else {
        self->offset = following;
        enter(self, SEARCHING);
    }
}

/* Keep the angle that was tried if the current sum is less there and the regulator does not creep up. */
static void judge(controller *self, double current, double error) {
    bool creeps = error >= self->creeping && self->integral >= 1.02 * self->best_integral;
    if (current < 0.999 * self->best_current && !creeps) {
        keep(self, current);
        self->moves += 1;
    } else if (self->moves == 0 && self->step_size == -FIRST_STEP) {
        self->step_size = 0.5 * FIRST_STEP;
    } else {
        self->step_size = 0.5 * self->step_size;
    }
    try_next(self);
}

/* Take back what the integral has wound up in vain. */
static void unwind(controller *self) {
    double most = 1.02 * self->best_integral;
    if (most < self->integral) self->integral = most;
}

/* Decide on the angle from the mean of the current sum over the interval. */
static void end_interval(controller *self) {
    double current = self->current_sum / (double)self->steps;
    double error = self->worst_error;
    double change = fabs(current - self->last_current);
    self->intervals += 1;
    begin_interval(self);
    if (self->phase == WAITING) {
        self->last_current = current;
        if (self->intervals >= 2 && error <= self->calm && change <= 0.004 * current) {
            keep(self, current);
            self->moves = 0;
            self->step_size = -FIRST_STEP;
            try_next(self);
        }
    } else if (self->phase == SEARCHING) {
        if (self->intervals >= 2) judge(self, current, error);
    } else if (self->phase == RECOVERING) {
        if (error <= self->calm) {
            try_next(self);
        } else if (self->intervals >= 3) {
            /* The best angle so far keeps the torque for a while only. */
            self->lost_offset = self->best_offset;
            self->best_offset = self->best_offset + FIRST_STEP;
            self->offset = self->best_offset;
            unwind(self);
            enter(self, RECOVERING);
        }
    } else if (self->intervals < 3) {
        self->last_current = current;
    } else if (fabs(current - self->best_current) > 0.05 * self->best_current) {
        begin_anew(self);
    } else if (self->intervals < 25 && change > 0.003 * self->last_current) {
        /* Restless, so too near to the edge. */
        self->offset = self->offset + 0.5 * DEGREE;
        enter(self, RESTING);
    }
}

/* Return whether the speed has stayed behind for some time, or does not rise at the current limit. */
static bool has_lost_torque(controller *self, double error, double reference, double speed) {
    bool settled = self->phase == SEARCHING || self->phase == RESTING;
    bool strained = settled ? error > self->calm : reference >= self->limit;
    self->strained = strained ? self->strained + 1 : 0;
    if (self->strained == 1) self->speed_mark = speed;
    if ((double)self->strained * self->period < self->patience) return false;
    self->strained = 0;
    return settled || speed <= self->speed_mark;
}

/* Go back from the edge of what the angle allows. */
static void regain_torque(controller *self) {
    if (self->phase == SEARCHING) {
        self->lost_offset = self->offset;
        self->step_size = 0.5 * self->step_size;
        self->offset = self->best_offset + FIRST_STEP;
        unwind(self);
        enter(self, RECOVERING);
    } else if (self->phase == RESTING && self->intervals < 3 && self->escapes < 2) {
        self->escapes += 1;
        self->offset = self->offset + 0.5 * DEGREE;
        unwind(self);
        enter(self, RESTING);
    } else {
        /* The load has risen, or the initial line is too low. */
        bool within = self->offset >= 0.0 && self->offset < HIGHEST;
        self->offset = within ? self->offset + FIRST_STEP : 0.0;
        enter(self, WAITING);
    }
}

void drivegate_step(void *state, const drivegate_sense *sense, drivegate_command *command) {
    controller *self = state;
    double error = sense->speed_reference - sense->speed;
    double reference = regulate(self, error);
    command->current_reference = reference;
    command->advance_angle = 0.0;
    command->input_power = sense->half_supply_voltage * sense->current_magnitude_sum;
    if (sense->speed_reference != self->speed_reference) {
        self->speed_reference = sense->speed_reference;
        self->offset = 0.0;
        begin_anew(self);
    }
    if (sense->speed < self->base_speed) self->advancing = 0;
    else if (sense->speed >= self->advance_begins) self->advancing = 1;
    if (self->advancing == 0) return;

    if (fabs(error) > self->worst_error) self->worst_error = fabs(error);
    self->current_sum += sense->current_magnitude_sum;
    self->steps += 1;
    if (has_lost_torque(self, error, reference, sense->speed)) regain_torque(self);
    else if ((double)self->steps * self->period >= self->interval) end_interval(self);
    command->advance_angle = advance_angle(self, sense->speed, sense->half_supply_voltage);
}
