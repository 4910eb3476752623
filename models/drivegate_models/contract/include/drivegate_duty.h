/* drivegate_duty.h: the contract between drivegate and a controller in C, C++ or anything that speaks C that answers
 * with duty ratios, as the firmware of a three-phase drive does.
 *
 * Once per control period the controller senses the phase currents, the angle and the speed of the shaft and the
 * voltage of the dc link, and answers with the duty ratios of the three upper switches. They act update_delay control
 * periods later. All legs are off until the first answer acts, so a machine that already turns carries no current then,
 * unless its EMF exceeds the link and the diodes rectify. Modulator, dead time and gates belong to the plant.
 *
 * A candidate exports drivegate_abi_version and drivegate_state_size, which drivegate.h declares, and the two functions
 * at the end of this file in place of drivegate_reset and drivegate_step. A whole controller may be as small as this,
 * which turns a voltage and lets the machine follow:
 *
 *     #include "drivegate_duty.h"
 *     #include <math.h>
 *
 *     typedef struct { double pole_pairs; } controller;
 *
 *     int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }
 *     int64_t drivegate_state_size(void) { return sizeof(controller); }
 *
 *     int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *nameplate) {
 *         controller *self = state;
 *         self->pole_pairs = (double)nameplate->pole_pairs;
 *         return 0;
 *     }
 *
 *     void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
 *         controller *self = state;
 *         double angle = self->pole_pairs * sense->reference * sense->time;
 *         for (int leg = 0; leg < 3; ++leg)
 *             command->duty_ratios[leg] = 0.5 + 0.2 * cos(angle - leg * 2.0943951023931953);
 *     }
 *
 * All quantities are in SI units. Angles and speeds are those of the shaft, in rad and rad/s; the electrical angle is
 * pole_pairs times that of the shaft, from the first phase's axis to the magnet's.
 */
#ifndef DRIVEGATE_DUTY_H
#define DRIVEGATE_DUTY_H

#include "drivegate.h"

#ifdef __cplusplus
#define DRIVEGATE_ASSERT(condition, message) static_assert(condition, message)
extern "C" {
#else
#define DRIVEGATE_ASSERT(condition, message) _Static_assert(condition, message)
#endif

/* What the reference is. */
#define DRIVEGATE_SPEED_REFERENCE 0  /* speed of the shaft, rad/s */
#define DRIVEGATE_TORQUE_REFERENCE 1 /* torque, N m */
#define DRIVEGATE_CURRENT_REFERENCE 2 /* q current, A; the d current is the controller's choice */

/* Flags of trip. */
#define DRIVEGATE_OVERVOLTAGE 1 /* the link has exceeded link_limit in the period just ended */
#define DRIVEGATE_OVERCURRENT 2 /* a phase current has exceeded 1.5 times current_limit in it */

/* What shows the shaft; without a sensor angle and speed are NaN. */
#define DRIVEGATE_POSITION_EXACT 0   /* angle and speed without edges */
#define DRIVEGATE_POSITION_ENCODER 1 /* edges of an encoder */
#define DRIVEGATE_POSITION_HALL 2    /* three Hall switches */
#define DRIVEGATE_POSITION_NONE 3    /* nothing */

/* States of a leg. */
#define DRIVEGATE_LEG_OFF 0  /* both switches off */
#define DRIVEGATE_LEG_PWM 1  /* as its duty ratio says */
#define DRIVEGATE_LEG_HIGH 2 /* upper switch on */
#define DRIVEGATE_LEG_LOW 3  /* lower switch on */

/* What the controller may know of its drive before a run. The machine's parameters are the nominal ones: the drive
 * that the controller is then run against may have others. All since 1.1. */
typedef struct drivegate_duty_nameplate {
    int64_t struct_size;           /* size of this record in bytes, as the harness knows it */
    int64_t kind;                  /* kind of drive: DRIVEGATE_PM_AC */
    int64_t reference_kind;        /* DRIVEGATE_SPEED_REFERENCE, .._TORQUE_.. or .._CURRENT_.. */
    int64_t pole_pairs;            /* number of pole pairs */
    int64_t updates;               /* updates of the duty ratios in a period of the carrier: 1 or 2, 0 edge aligned */
    int64_t update_delay;          /* control periods between an answer and its effect: 1 or 0 */
    double supply_voltage;         /* nominal voltage of the dc link, V */
    double base_speed;             /* shaft speed at which constant power begins, rad/s */
    double highest_speed;          /* shaft speed up to which rated power is required, rad/s */
    double rated_power;            /* rated mechanical power, W */
    double current_limit;          /* greatest peak current of a phase, A */
    double control_period;         /* time from one step to the next, s */
    double dead_time;              /* time for which both switches of a leg are off when it changes, s */
    double resistance;             /* nominal resistance of a phase, ohm */
    double direct_inductance;      /* nominal inductance along the magnet's axis, H */
    double quadrature_inductance;  /* nominal inductance across it, H */
    double magnet_flux;            /* nominal peak flux linkage of a phase, V s */
    double inertia;                /* nominal moment of inertia of rotor and load, kg m^2 */
    double core_loss_conductance;  /* core loss of a phase over the mean square of the voltage that the mean flux of a
                                    * period induces, S; 0 where it is not known; it comes from the link, or without
                                    * any current from the shaft: no part of a phase current or of the torque */
    int64_t control_every;         /* carrier periods from one step to the next; the duty ratios hold in all of them */
    double switch_drop;            /* forward drop of a switch with current, V */
    double diode_drop;             /* forward drop of a diode with current, V */
    double position_error;         /* greatest error by which the shown electrical angle swings within a turn, rad: of
                                    * the tracks of a sensor without edges, which also shows in the speed, or of the
                                    * places of Hall switches; 0 for an encoder */
    double link_capacitance;       /* capacitance of the dc link, F; 0: an ideal link, of which the rest is 0 */
    double source_resistance;      /* resistance between source and link, ohm */
    double link_limit;             /* greatest permitted voltage of the link, V */
    double charge_limit;           /* greatest mean current that the source takes back, A; 0: it takes nothing back */
    double discharge_limit;        /* greatest mean current of the source, A */
    double chopper_voltage;        /* voltage from which the brake chopper turns on by itself, V; 0 without one */
    double chopper_resistance;     /* resistance of the brake chopper, ohm; 0 without one */
    int64_t position;              /* DRIVEGATE_POSITION_EXACT, .._ENCODER, .._HALL or .._NONE */
    double least_speed;            /* without a sensor, shaft speed from which on it must run steadily, rad/s; else 0 */
    double start_time;             /* without a sensor, time from standstill to least_speed under half of rated torque,
                                    * s; else 0 */
    int64_t is_reversing;          /* 1 where references may be negative, 0 for a drive that turns one way */
    double heat_capacity;          /* heat capacity of all windings together, J/K; 0: no thermal data, the rest is 0 */
    double thermal_resistance;     /* rise of the windings' steady temperature over the copper loss, K/W */
    double ambient_temperature;    /* temperature of the surroundings, at which resistance is stated, deg C */
    double temperature_limit;      /* greatest permitted temperature of the windings, deg C */
    double temperature_coefficient; /* change of the resistance over resistance, for a change of temperature, 1/K */
    double temperature_lag;        /* time constant of the temperature's sensor, s */
    double voltage_filter;         /* time constant of the filter of one pole of mean_voltages, s; 0: none */
} drivegate_duty_nameplate;

/* What the controller senses at the start of a control period. */
typedef struct drivegate_duty_sense {
    int64_t struct_size;          /* size of this record in bytes, as the harness knows it */
    double time;                  /* simulated time, s */
    double reference;             /* demanded speed, torque or q current, as the nameplate states, rad/s, N m or A */
    const double *phase_currents; /* three measured phase currents at this instant, positive into the machine, A;
                                   * valid during the step only */
    DRIVEGATE_POINTER_PADDING(phase_currents)
    double supply_voltage;        /* measured voltage of the whole dc link at this instant, V */
    double supply_current;        /* mean current of the bridge from the link in the period just ended, A; < 0 in
                                   * braking; the source's own is source_current */
    double angle;                 /* angle of the shaft at this instant, 0 <= angle < 2 pi, rad; Hall switches show it
                                   * by counted electrical cycles, from the cycle of the start; NaN without a
                                   * sensor */
    double speed;                 /* speed of the shaft at this instant, rad/s; < 0 backward; NaN without a sensor */
    int64_t hall;                 /* states of the Hall switches, the first phase's the lowest bit; -1 without them:
                                   * 1, 3, 2, 6, 4, 5 forward, in sectors of 60 electrical degrees that begin at 30 */
    int64_t encoder_count;        /* count of the encoder's edges, from 0 to one less than a turn has; angle is the
                                   * middle between the edges of this count and the next; -1 without an encoder */
    int64_t trip;                 /* DRIVEGATE_OVERVOLTAGE and DRIVEGATE_OVERCURRENT; the legs stay the controller's;
                                   * 0 for none, as always on an ideal link */
    double phase_voltages[3];     /* voltages of the three terminals from the negative rail, as dividers show them when
                                   * the currents are sampled, before the legs switch, V; with all legs off and no
                                   * current they differ by line-to-line EMFs, and a diode's drop below 0 is the lowest */
    int64_t enable;               /* 1 if the answer acts on the bridge, 0 while the bridge is off before the run and
                                   * after a restart, which only a candidate sees whose manifest has
                                   * reads_enable = true */
    double source_current;        /* mean current of the source in the period just ended, A; < 0 while it takes energy
                                   * back; on an ideal link it is supply_current */
    double winding_temperature;   /* temperature of the windings as a lagging sensor shows it, deg C; NaN without one */
    double mean_voltages[3];      /* means of the terminals' voltages from the negative rail over the period just ended,
                                   * V, after the filter of voltage_filter; at first phase_voltages; NaN where the drive
                                   * does not sense them */
} drivegate_duty_sense;

/* What the controller answers. Before the step the duty ratios and estimates are NaN, the legs DRIVEGATE_LEG_PWM and
 * the rest is 0. A duty ratio outside 0 to 1 is recorded and clamped before it reaches the plant, and fails the check
 * of that range; one that is not finite, and a leg in none of the states above, end the run. */
typedef struct drivegate_duty_command {
    int64_t struct_size;   /* size of this record in bytes; the harness sets it, leave it as it is */
    double duty_ratios[3]; /* share of the period with the upper switch on, from 0 to 1 */
    int64_t legs[3];       /* one of DRIVEGATE_LEG_OFF and so on */
    double next_period;    /* length asked for of the next period, s; 0 keeps it, and drives so far keep theirs */
    double torque;         /* the controller's own estimates; leave NaN for none: of the torque, N m, */
    double angle;          /* of the shaft's angle, rad, */
    double speed;          /* of its speed, rad/s, */
    double input_power;    /* and of the power from the link, W */
    int64_t fault;         /* the controller's own code of a fault; 0 for none */
    double brake_duty;     /* share of the period with the brake chopper on, from 0 to 1, which acts with the duty
                            * ratios; leave NaN for the chopper's own thresholds */
} drivegate_duty_command;

DRIVEGATE_ASSERT(sizeof(drivegate_duty_nameplate) == 328, "drivegate_duty_nameplate must not be padded");
DRIVEGATE_ASSERT(sizeof(drivegate_duty_sense) == 160, "drivegate_duty_sense must not be padded");
DRIVEGATE_ASSERT(sizeof(drivegate_duty_command) == 112, "drivegate_duty_command must not be padded");

/* Prepare for a run and forget all earlier ones. Return 0 for success, anything else to refuse the run. */
DRIVEGATE_EXPORT int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *nameplate);

/* Answer for one control period. Called once per period, in simulated time; must not block. */
DRIVEGATE_EXPORT void drivegate_duty_step(
    void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command);

#ifdef __cplusplus
}
#endif

#undef DRIVEGATE_ASSERT

#endif /* DRIVEGATE_DUTY_H */
