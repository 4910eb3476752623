/*
 * The closed loop of drivegate by hand in C, as a measure of its compiled loop's speed: the same event-exact plant,
 * the same ledger with its check in every period, a load that follows a course, and a speed regulator with a line of
 * angles (drivegate's built-in `initial`), or any controller by the address of its drivegate_step.
 *
 * Compiled as a library, with cc -std=c11 -O3 -march=native -ffp-contract=fast.
 */
#include <drivegate.h>

#include "phase.h"

#define MOST_PHASES 32
#define RPM (PI / 30.0)
#define DEGREE (PI / 180.0)

/* A run at a steady speed reference and supply, in the order in which the caller lays it out. */
typedef struct {
    double initial_speed, speed_reference, base_speed, control_period;
    int64_t steps;
    int64_t load_points; /* corners of the load's course */
    const double *load_times, *load_torques;
    void (*step)(void *state, const drivegate_sense *, drivegate_command *); /* NULL for the line of angles here */
    void *state;
} task;

typedef struct {
    ledger totals;
    double speed, shaft_energy, input_energy, kinetic_residual, worst_mismatch;
} result;

/* One row of the optional record: what happened in one control period. */
typedef struct {
    double speed, current_reference, advance, current_sum, impulse, source;
} record;

typedef struct {
    double proportional, integral_step, limit, base_speed, integral;
} controller;

static controller make_controller(const drive *d, const task *t) {
    double proportional = d->inertia * 80.0 / (0.8 * (double)d->phases * d->emf_constant);
    return (controller){proportional, proportional * 15.0 * t->control_period, d->current_limit, t->base_speed, 0.0};
}

static inline double regulate(controller *c, double error) {
    double following = least(most(c->integral + c->integral_step * error, 0.0), c->limit);
    double reference = c->proportional * error + following;
    if (reference > c->limit) {
        c->integral = error > 0.0 ? least(c->integral, following) : following;
        return c->limit;
    }
    if (reference < 0.0) {
        c->integral = error < 0.0 ? most(c->integral, following) : following;
        return 0.0;
    }
    c->integral = following;
    return reference;
}

static inline void answer(controller *c, const drivegate_sense *sense, drivegate_command *command) {
    double line = 33.0 * DEGREE + 0.025 * DEGREE / RPM * (sense->speed - c->base_speed);
    command->current_reference = regulate(c, sense->speed_reference - sense->speed);
    command->advance_angle = sense->speed < c->base_speed ? 0.0 : least(most(line, 0.0), 0.5 * PI);
    command->input_power = sense->half_supply_voltage * sense->current_magnitude_sum;
}

static inline double follow(const task *t, int64_t *position, double time) {
    while (*position + 1 < t->load_points && t->load_times[*position + 1] <= time) ++*position;
    if (*position + 1 >= t->load_points) return t->load_torques[t->load_points - 1];
    double span = t->load_times[*position + 1] - t->load_times[*position];
    double share = (time - t->load_times[*position]) / span;
    return t->load_torques[*position] + share * (t->load_torques[*position + 1] - t->load_torques[*position]);
}

static inline double stored_energy(const drive *d, const phase *phases) {
    double total = 0.0;
    for (int64_t j = 0; j < d->phases; j++) total += phases[j].current * phases[j].current;
    return 0.5 * d->inductance * total;
}

static inline void add(ledger *total, const ledger *part) {
    total->magnitude += part->magnitude;
    total->square += part->square;
    total->impulse += part->impulse;
    total->upper += part->upper;
    total->lower += part->lower;
    total->exchanged += part->exchanged;
    total->returned += part->returned;
    total->device += part->device;
    total->switching += part->switching;
    total->core_source += part->core_source;
    total->core_drag_impulse += part->core_drag_impulse;
    total->peak = most(total->peak, part->peak);
    total->events += part->events;
}

/* Run from rest of the currents; returns 0, or 1 where the plant or the command is beyond use. */
int yardstick_run(const drive *d, const task *t, result *done, record *rows) {
    phase phases[MOST_PHASES];
    double currents[MOST_PHASES];
    if (d->phases > MOST_PHASES) return 1;
    for (int64_t j = 0; j < d->phases; j++) phases[j] = (phase){0.0, 0, 1};
    controller own = make_controller(d, t);
    drivegate_sense sense = {.struct_size = sizeof sense,
                             .speed_reference = t->speed_reference,
                             .phase_count = d->phases,
                             .phase_currents = currents,
                             .half_supply_voltage = d->half_supply_voltage};
    drivegate_command command = {.struct_size = sizeof command};
    const double period = t->control_period;
    double speed = t->initial_speed, gained = 0.0, angle = 0.0, current_sum = 0.0, stored = 0.0;
    int64_t position = 0;
    result whole = {0};

    for (int64_t k = 0; k < t->steps; k++) {
        const double time = (double)k * period;
        const double load = follow(t, &position, time);
        for (int64_t j = 0; j < d->phases; j++) currents[j] = phases[j].current;
        sense.time = time;
        sense.speed = speed;
        sense.current_magnitude_sum = current_sum;
        if (t->step)
            t->step(t->state, &sense, &command);
        else
            answer(&own, &sense, &command);
        if (!isfinite(command.current_reference) || !isfinite(command.advance_angle)) return 1;

        /* The speed of the middle of the period, as far as the last one shows. */
        const double held = most(speed + 0.5 * gained, 0.0);
        const period_inputs inputs = {
            .speed = held,
            .upper = d->half_supply_voltage,
            .lower = d->half_supply_voltage,
            .reference = least(most(command.current_reference, 0.0), d->current_limit),
            .advance = least(most(command.advance_angle, 0.0), 0.5 * PI),
            .duration = period,
        };
        ledger part = {0};
        for (int64_t j = 0; j < d->phases; j++)
            if (!advance_phase(d, &phases[j], angle - (double)j * PI / (double)d->phases, &inputs, &part)) return 1;

        add(&whole.totals, &part);
        const double now_stored = stored_energy(d, phases);
        const double spent = d->resistance * part.square + held * part.impulse + part.device + (now_stored - stored);
        const double throughput = part.exchanged + stored + now_stored;
        if (throughput > 0.0)
            whole.worst_mismatch =
                most(whole.worst_mismatch, fabs(part.exchanged - 2.0 * part.returned - spent) / throughput);
        stored = now_stored;
        const double source = part.upper + part.lower + part.core_source + part.switching;
        current_sum = part.magnitude / period;
        whole.shaft_energy += held * part.impulse;
        whole.input_energy += source;
        if (rows)
            rows[k] = (record){speed, inputs.reference, inputs.advance, current_sum, part.impulse, source};

        const double turned = angle + (double)d->pole_pairs * held * period;
        angle = turned - 2.0 * PI * floor(turned * (0.5 / PI));
        const double resisting = load + d->friction + d->viscous_friction * held;
        const double change = (part.impulse - part.core_drag_impulse - resisting * period) / d->inertia;
        gained = most(change, -speed);
        whole.kinetic_residual += d->inertia * gained * (speed + 0.5 * gained - held);
        speed += gained;
    }
    whole.speed = speed;
    *done = whole;
    return 0;
}
