/* Field-oriented control: speed, least current for a torque, field weakening, current regulators with decoupling, and a
 * min-max zero sequence. Every constant follows from the nameplate; all quantities are in SI units. */
#include "drivegate_duty.h"

#include <math.h>

#ifndef REAL
#define REAL double /* float for a processor that computes in single precision */
#endif
typedef REAL real;
typedef struct { real direct, quadrature; } rotor; /* along and across the magnet's axis */

#define ROOT_THREE 1.7320508075688772
/* Bandwidth of the currents over the sampling rate, of the speed over that, and of the currents' integrals over that. */
#define CURRENT_SHARE 0.2
#define SPEED_SHARE 0.02
#define INTEGRAL_SHARE 0.1
/* Share of the voltage limit that references use; the rest is for the current regulators. Braking from a speed to a lower
 * one leaves more, for a machine of less inductance than on the nameplate. */
#define VOLTAGE_SHARE 0.985
#define BRAKING_SHARE 0.185

/* All that the controller remembers. The buffer is drivegate's; keep nothing in globals, so that many can run. */
typedef struct {
    int regulates_torque;
    real pole_pairs, resistance, direct_inductance, quadrature_inductance, saliency, flux, limit, deepest, greatest;
    real lead, direct_gain, quadrature_gain, direct_step, quadrature_step, speed_gain, speed_step, weakening_step;
    real speed_integral, direct_integral, quadrature_integral, weakening;
} controller;

static real between(real value, real bound) { return fmin(fmax(value, -bound), bound); }

static real magnitude(real along, real across) { return sqrt(along * along + across * across); }

/* Return the torque of one ampere across the magnet's axis (N m/A). */
static real per_ampere(const controller *self, real direct) {
    return 1.5 * self->pole_pairs * (self->flux - self->saliency * direct);
}

/* Return the direct current with which a torque needs the least current (A). */
static real least_current(const controller *self, real torque) {
    real direct = 0.0;
    for (int round = 0; round < 6; ++round) {
        real quadrature = torque / per_ampere(self, direct), turned = 2.0 * self->saliency * quadrature;
        direct = -turned * quadrature / (self->flux + magnitude(self->flux, turned));
    }
    return direct;
}

/* Return the greatest torque at a direct current within both limits (N m), negative if there is none. */
static real possible(const controller *self, real direct, real electrical, real voltage) {
    real room = self->limit * self->limit - direct * direct;
    real along = electrical * (self->direct_inductance * direct + self->flux);
    real reactance = electrical * self->quadrature_inductance, resistance = self->resistance;
    /* The voltage is a quadratic in the quadrature current: a q^2 + 2 b q + c = 0 at its limit. */
    real a = reactance * reactance + resistance * resistance;
    real b = resistance * (along - reactance * direct);
    real c = resistance * resistance * direct * direct + along * along - voltage * voltage;
    real inside = b * b - a * c;
    if (room < 0.0 || inside < 0.0) return fmin(room, inside);
    return per_ampere(self, direct) * fmin(sqrt(room), (sqrt(inside) - b) / a);
}

/* Return the direct current (A) for a torque: the least, weakened for the voltage, or that of most torque. */
static real direct_for(const controller *self, real torque, real electrical, real voltage) {
    real direct = least_current(self, torque), deeper = self->deepest, near = 0.001 * self->limit;
    if (possible(self, direct, electrical, voltage) >= torque) return direct;
    for (int halving = 0; halving < 14; ++halving) {
        real middle = 0.5 * (direct + deeper), found = possible(self, middle, electrical, voltage);
        if (found >= torque || possible(self, middle - near, electrical, voltage) <= found) deeper = middle;
        else direct = middle;
    }
    return deeper;
}

/* Return the currents for what the reference requests, as far as the limits allow (A). */
static rotor references(controller *self, real reference, real speed, real electrical, real limit) {
    real error = reference - speed, torque = reference, voltage = VOLTAGE_SHARE * limit;
    if (!self->regulates_torque) {
        self->speed_integral += self->speed_step * error;
        torque = self->speed_gain * error + self->speed_integral;
        if (torque * speed < 0.0) voltage -= BRAKING_SHARE * limit * fmin(fabs(torque) / (0.2 * self->greatest), 1.0);
    }
    /* Negative where the torque brakes: the drop of the resistance is then against the back-EMF. */
    real turning = torque < 0.0 ? -electrical : electrical;
    real direct = direct_for(self, fmin(fabs(torque), self->greatest), turning, voltage);
    direct = fmax(direct + self->weakening, self->deepest);
    real most = fmax(possible(self, direct, turning, voltage), 0.0);
    /* The integral of the speed waits while the limits allow less than it requests. */
    if (!self->regulates_torque && fabs(torque) > most && torque * error > 0.0)
        self->speed_integral -= self->speed_step * error;
    return (rotor){direct, between(torque, most) / per_ampere(self, direct)};
}

/* Return the voltage that brings the currents to their references (V), within the limit. */
static rotor regulate(controller *self, rotor error, rotor current, real electrical, real limit) {
    /* The coupling of the axes and the back-EMF are added in advance. */
    real direct = self->direct_gain * error.direct + self->direct_integral
                  - electrical * self->quadrature_inductance * current.quadrature;
    real quadrature = self->quadrature_gain * error.quadrature + self->quadrature_integral
                      + electrical * (self->direct_inductance * current.direct + self->flux);
    /* A voltage beyond the limit is shortened, not turned. What the limit cuts does not enter the integrals. */
    real used = magnitude(direct, quadrature), share = limit / fmax(limit, used), cut = share - 1.0;
    self->direct_integral += self->direct_step * (error.direct + cut * direct / self->direct_gain);
    self->quadrature_integral += self->quadrature_step * (error.quadrature + cut * quadrature / self->quadrature_gain);
    /* A machine that differs from the nameplate shows in the voltage that is requested. */
    self->weakening += self->weakening_step * (0.5 * (1.0 + VOLTAGE_SHARE) * limit - used);
    self->weakening = fmin(fmax(self->weakening, -0.3 * self->limit), 0.0);
    return (rotor){share * direct, share * quadrature};
}

/* Transform currents (A) or voltages (V) of the phases into the frame of the rotor. */
static rotor rotor_components(const double phases[3], real angle) {
    real first = phases[0], second = phases[1], third = phases[2];
    real along = (2.0 * first - second - third) / 3.0, across = (second - third) / ROOT_THREE;
    return (rotor){cos(angle) * along + sin(angle) * across, cos(angle) * across - sin(angle) * along};
}

/* Write the duty ratios for a voltage (V), centred in the link by a zero sequence. */
static void duty_ratios(double ratios[3], rotor voltage, real angle, real supply) {
    real along = cos(angle) * voltage.direct - sin(angle) * voltage.quadrature;
    real across = sin(angle) * voltage.direct + cos(angle) * voltage.quadrature;
    real second = -0.5 * along + 0.5 * ROOT_THREE * across, third = -0.5 * along - 0.5 * ROOT_THREE * across;
    real middle = 0.5 * (fmax(along, fmax(second, third)) + fmin(along, fmin(second, third)));
    ratios[0] = fmin(fmax(0.5 + (along - middle) / supply, 0.0), 1.0);
    ratios[1] = fmin(fmax(0.5 + (second - middle) / supply, 0.0), 1.0);
    ratios[2] = fmin(fmax(0.5 + (third - middle) / supply, 0.0), 1.0);
}

/* Let the integrals begin at what the back-EMF adds to the nominal one, while the bridge is off. */
static void preload(controller *self, const double terminals[3], real angle, real electrical, real supply) {
    /* Terminals at the rail of a conducting diode do not show it. */
    if (fmax((real)terminals[0], fmax((real)terminals[1], (real)terminals[2])) >= supply) return;
    rotor induced = rotor_components(terminals, angle);
    self->direct_integral = induced.direct;
    self->quadrature_integral = induced.quadrature - electrical * self->flux;
}

int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }

int64_t drivegate_state_size(void) { return sizeof(controller); }

/* Prepare for a run: called before every one, and must forget everything. */
int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *nameplate) {
    controller *self = state;
    real period = nameplate->control_period, bandwidth = CURRENT_SHARE / period;
    self->regulates_torque = nameplate->reference_kind == DRIVEGATE_TORQUE_REFERENCE;
    self->pole_pairs = nameplate->pole_pairs;
    self->resistance = nameplate->resistance;
    self->direct_inductance = nameplate->direct_inductance;
    self->quadrature_inductance = nameplate->quadrature_inductance;
    self->saliency = self->quadrature_inductance - self->direct_inductance;
    self->flux = nameplate->magnet_flux;
    self->limit = nameplate->current_limit;
    /* Beyond the magnet's whole flux the voltage rises again. */
    self->deepest = -fmin(0.999 * self->limit, self->flux / self->direct_inductance);
    /* The torque at the current limit, with the direct current that makes it the greatest. */
    real turned = 2.0 * self->saliency * self->limit;
    real direct = -turned * self->limit / (self->flux + sqrt(self->flux * self->flux + 2.0 * turned * turned));
    self->greatest = per_ampere(self, direct) * sqrt(self->limit * self->limit - direct * direct);
    /* From the sample to the middle of the period in which the answer acts (s). */
    self->lead = (nameplate->update_delay + 0.5) * period;
    self->direct_gain = bandwidth * self->direct_inductance;
    self->quadrature_gain = bandwidth * self->quadrature_inductance;
    self->direct_step = CURRENT_SHARE * fmax(self->resistance, INTEGRAL_SHARE * self->direct_gain);
    self->quadrature_step = CURRENT_SHARE * fmax(self->resistance, INTEGRAL_SHARE * self->quadrature_gain);
    self->speed_gain = (real)nameplate->inertia * SPEED_SHARE * bandwidth;
    self->speed_step = self->speed_gain * 0.25 * SPEED_SHARE * CURRENT_SHARE;
    real base_speed = self->pole_pairs * (real)nameplate->base_speed;
    self->weakening_step = 0.02 * CURRENT_SHARE / (base_speed * self->direct_inductance);
    self->speed_integral = self->direct_integral = self->quadrature_integral = self->weakening = 0.0;
    return 0;
}

/* Answer for one control period. */
void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    controller *self = state;
    real electrical = self->pole_pairs * (real)sense->speed, angle = self->pole_pairs * (real)sense->angle;
    real supply = fmax((real)sense->supply_voltage, 1e-9), limit = supply / ROOT_THREE;
    if (!sense->enable) {
        preload(self, sense->phase_voltages, angle, electrical, supply);
        command->duty_ratios[0] = command->duty_ratios[1] = command->duty_ratios[2] = 0.5;
        return;
    }
    rotor current = rotor_components(sense->phase_currents, angle);
    rotor wanted = references(self, sense->reference, sense->speed, electrical, limit);
    rotor error = {wanted.direct - current.direct, wanted.quadrature - current.quadrature};
    rotor voltage = regulate(self, error, current, electrical, limit);
    duty_ratios(command->duty_ratios, voltage, angle + electrical * self->lead, supply);
    command->torque = per_ampere(self, current.direct) * current.quadrature;
}
