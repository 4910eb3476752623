/* drivegate.h: the contract between drivegate and a controller written in C, C++ or anything that speaks C.
 *
 * A candidate is an outer-loop controller. Once per control period it senses the speed and the currents of the
 * drive, and answers with a current reference and an advance angle. Commutation, the hysteresis comparators and
 * the gates belong to the plant.
 *
 * Export the four functions at the end of this file. A whole controller may be as small as this:
 *
 *     #include "drivegate.h"
 *
 *     typedef struct { double limit; } controller;
 *
 *     int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }
 *     int64_t drivegate_state_size(void) { return sizeof(controller); }
 *
 *     int drivegate_reset(void *state, const drivegate_nameplate *nameplate) {
 *         controller *self = state;
 *         self->limit = nameplate->current_limit;
 *         return 0;
 *     }
 *
 *     void drivegate_step(void *state, const drivegate_sense *sense, drivegate_command *command) {
 *         controller *self = state;
 *         command->current_reference = sense->speed < sense->speed_reference ? self->limit : 0.0;
 *         command->advance_angle = 0.0;
 *     }
 *
 * All quantities are in SI units. Speeds are those of the shaft, in rad/s; angles are electrical, in rad.
 */
#ifndef DRIVEGATE_H
#define DRIVEGATE_H

#include <stddef.h>
#include <stdint.h>

/* A controller that was built for another major version is refused. Within a major version, fields are only ever
 * appended to the records below, so an older controller goes on working. */
#define DRIVEGATE_ABI_MAJOR 1
#define DRIVEGATE_ABI_MINOR 1
#define DRIVEGATE_ABI_VERSION (1000 * DRIVEGATE_ABI_MAJOR + DRIVEGATE_ABI_MINOR)

#if defined(__GNUC__) || defined(__clang__)
#define DRIVEGATE_EXPORT __attribute__((visibility("default")))
#else
#define DRIVEGATE_EXPORT
#endif

#ifdef __cplusplus
#define DRIVEGATE_ASSERT(condition, message) static_assert(condition, message)
extern "C" {
#else
#define DRIVEGATE_ASSERT(condition, message) _Static_assert(condition, message)
#endif

/* Records have the same layout on targets with pointers of 32 bits, which are little-endian. */
#if UINTPTR_MAX == 0xffffffffu
#define DRIVEGATE_POINTER_PADDING(name) uint32_t name##_padding;
#else
#define DRIVEGATE_POINTER_PADDING(name)
#endif

/* Kinds of drive. */
#define DRIVEGATE_HALF_BRIDGE 1 /* decoupled phases, each on a half-bridge leg at a split supply */
#define DRIVEGATE_STAR 2        /* star connection with an isolated neutral, trapezoidal EMF */
#define DRIVEGATE_PM_AC 3       /* star connection, sinusoidal EMF */

/* What the controller may know of its drive before a run. The machine's parameters are the nominal ones: the
 * drive that the controller is then run against may have others. */
typedef struct drivegate_nameplate {
    int64_t struct_size;        /* size of this record in bytes, as the harness knows it */
    int64_t phases;             /* number of phases */
    int64_t pole_pairs;         /* number of pole pairs */
    double half_supply_voltage; /* nominal voltage of one half of the split supply, V */
    double base_speed;          /* shaft speed above which the advance angle may leave zero, rad/s */
    double rated_power;         /* rated mechanical power, W */
    double current_limit;       /* greatest current reference, A */
    double control_period;      /* time from one step to the next, s */
    double hysteresis_band;     /* half width of the current regulators' band, A */
    double resistance;          /* nominal phase resistance, ohm */
    double inductance;          /* nominal phase inductance, H */
    double emf_constant;        /* nominal amplitude of the phase EMF over the shaft speed, V s/rad */
    double inertia;             /* nominal moment of inertia at the shaft, kg m^2 */
    /* since 1.1 */
    int64_t kind;               /* kind of drive: one of DRIVEGATE_HALF_BRIDGE and so on */
    double window;              /* conduction of a phase in each half cycle, rad electrical */
    double conducting_phases;   /* how many phases conduct at a time, on average: phases * window / pi */
    double advance_start;       /* recommended line of advance angles: angle at base speed, rad electrical */
    double advance_slope;       /* its rise over the speed of the shaft, rad electrical per rad/s */
    double highest_speed;       /* shaft speed up to which rated power is required, rad/s */
} drivegate_nameplate;

/* What the controller senses at the start of a control period. */
typedef struct drivegate_sense {
    int64_t struct_size;          /* size of this record in bytes, as the harness knows it */
    double time;                  /* simulated time, which need not begin at 0, s */
    double speed_reference;       /* demanded shaft speed, rad/s */
    double speed;                 /* measured shaft speed, rad/s */
    int64_t phase_count;          /* number of phase currents that follow */
    const double *phase_currents; /* measured phase currents at this instant, A; valid during the step only */
    DRIVEGATE_POINTER_PADDING(phase_currents)
    double current_magnitude_sum; /* sum of |phase current|, mean over the control period just ended, A */
    double half_supply_voltage;   /* measured voltage of one half of the split supply, V */
} drivegate_sense;

/* What the controller answers. All numbers are NaN before the step. An answer outside its range is recorded and
 * clamped before it reaches the plant, and fails the check of that range; one that is not finite ends the run. */
typedef struct drivegate_command {
    int64_t struct_size;      /* size of this record in bytes; the harness sets it, leave it as it is */
    double current_reference; /* amplitude that the current regulators hold, A, from 0 to current_limit */
    double advance_angle;     /* advance of the conduction windows, rad, from 0 to pi/2 */
    double input_power;       /* the controller's own estimate of its input power, W; leave NaN if it has none */
} drivegate_command;

DRIVEGATE_ASSERT(sizeof(double) == 8, "drivegate needs 64-bit numbers");
DRIVEGATE_ASSERT(sizeof(drivegate_nameplate) == 152, "drivegate_nameplate must not be padded");
DRIVEGATE_ASSERT(sizeof(drivegate_sense) == 64, "drivegate_sense must not be padded");
DRIVEGATE_ASSERT(sizeof(drivegate_command) == 32, "drivegate_command must not be padded");

/* Return DRIVEGATE_ABI_VERSION: the version that the controller was built for. */
DRIVEGATE_EXPORT int64_t drivegate_abi_version(void);

/* Return the size of the controller's state in bytes. The harness provides a buffer of that size, zeroed and
 * aligned to 16 bytes, and passes it to every call. With a size of 0 the state pointer is NULL: a controller that
 * keeps its state in globals instead is run as one instance per process. */
DRIVEGATE_EXPORT int64_t drivegate_state_size(void);

/* Prepare for a run and forget all earlier ones. Return 0 for success, anything else to refuse the run. */
DRIVEGATE_EXPORT int drivegate_reset(void *state, const drivegate_nameplate *nameplate);

/* Answer for one control period. Called once per period, in simulated time; must not block. */
DRIVEGATE_EXPORT void drivegate_step(void *state, const drivegate_sense *sense, drivegate_command *command);

#ifdef __cplusplus
}
#endif

#undef DRIVEGATE_ASSERT

#endif /* DRIVEGATE_H */
