/* Faults of memory and arithmetic, one for each torque reference; the line of each has its name in a comment. */
#include "drivegate_duty.h"
#include <stdbool.h>
#include <stdlib.h>

typedef struct {
    double gains[4];
    double *table, *old;
} controller;

static volatile double zero;

int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }
int64_t drivegate_state_size(void) { return sizeof(controller); }

int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *plate) {
    controller *self = state;
    (void)plate;
    self->old = malloc(64);
    self->table = malloc(64);
    if (!self->table || !self->old) return 1;
    self->table[0] = self->old[0] = 0.0;
    free(self->old);
    for (int place = 0; place < 4; ++place) self->gains[place] = 1.0;
    return 0;
}

static double sum_of(const double *values, int count) {
    double sum = 0.0;
    for (int place = 0; place < count; ++place) sum += values[place]; /* one past the end */
    return sum;
}

static double unwritten_part(int written) {
    double taps[4], sum = 0.0;
    for (int place = 0; place < written; ++place) taps[place] = 0.0;
    for (int place = 0; place < 4; ++place) sum += taps[place]; /* array written in part */
    return sum;
}

static double unwritten(int number) {
    double estimate;
    if (number > 100) estimate = 0.0;
    return estimate; /* uninitialised read */
}

void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    controller *self = state;
    volatile int number = (int)(10.0 * sense->reference + 0.5), many = 31 + number;
    unsigned char bytes[24] = {0};
    volatile int q15 = 50000 * (number == 3), none = number - 8;
    for (int leg = 0; leg < 3; ++leg) command->duty_ratios[leg] = 0.5;
    command->torque = 0.0;
    if (sense->time < 0.001) return;
    switch (number) {
    case 1: {
        double local[3] = {1.0, 2.0, 3.0};
        command->torque = sum_of(local, 4);
        break;
    }
    case 2: command->torque = self->old[0]; break;                   /* use after reset */
    case 3: command->torque = (q15 * q15) >> 15; break;              /* overflow of a product */
    case 4: command->torque = 1 << (many - 3); break;                /* shift by 32 */
    case 5: command->torque = (int16_t)(1e5 * sense->speed); break;  /* float out of range */
    case 6: command->torque = unwritten(number); break;
    case 7: command->torque = *(const double *)(bytes + 1); break;   /* misaligned access */
    case 8: command->torque = 100 / none; break;                     /* division by zero */
    case 9: command->torque = 1.0 / zero > 0.0; break;               /* float divided by zero */
    case 10: command->torque = sense->phase_currents[3]; break;      /* past the currents */
    case 11: self->gains[(size_t)(number - 5)] = 1.0; break;         /* past an array in the state */
    case 12: self->table[8] = 1.0; break;                            /* past the heap */
    case 13: *(volatile int *)(uintptr_t)(number - 13) = 1; break;   /* null pointer */
    case 14: ((double *)self)[sizeof(*self) / 8] = 1.0; break;       /* past the state */
    case 15: command->torque = self->table[2]; break;
    case 16: command->torque = unwritten_part(number - 14); break;
    default: break;
    }
}
