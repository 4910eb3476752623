/* Field-oriented control: a speed regulator, the least current for a torque, field weakening, current regulators with
 * decoupling and anti-windup, and min-max modulation. Every constant follows from the nameplate; all quantities are in SI
 * units. */
#include "drivegate_duty.h"

#include <math.h>

#ifndef real
#define real double /* float for a processor that computes in single precision */
#endif
typedef struct { real direct, quadrature; } rotor; /* along and across the magnet's axis */

static const real ROOT_THREE = 1.7320508075688772;
/* Bandwidth of the currents over the sampling rate, of the speed over that, and of the currents' integrals over that. */
static const real CURRENT_SHARE = 0.2, SPEED_SHARE = 0.02, INTEGRAL_SHARE = 0.1;
/* Share of the voltage limit that references use; the rest is for the current regulators. Braking from a speed to a lower
 * one leaves more, for a machine of less inductance than on the nameplate. */
static const real VOLTAGE_SHARE = 0.985, BRAKING_SHARE = 0.185;

/* All that the controller remembers. The buffer is drivegate's; keep nothing in globals, so that many can run. */
typedef struct {
    int regulates_torque;
    real pole_pairs, resistance, saliency, flux, limit, deepest, greatest, lead, speed_gain, speed_step, weakening_step;
    real speed_integral, weakening;
    rotor inductance, gain, step, integral;
} controller;

static real between(real value, real least, real greatest) { return fmin(fmax(value, least), greatest); }

/* Transform currents (A) or voltages (V) of the phases into the frame of the rotor, by Clarke and Park. */
static rotor park(const double phases[3], real angle) {
    real first = phases[0], second = phases[1], third = phases[2];
    real along = (2.0 * first - second - third) / 3.0, across = (second - third) / ROOT_THREE;
    return (rotor){cos(angle) * along + sin(angle) * across, cos(angle) * across - sin(angle) * along};
}

/* Write the duty ratios for a voltage (V), by inverse Park and Clarke, centred in the link by a zero sequence. */
static void modulate(double ratios[3], rotor voltage, real angle, real supply) {
    real along = cos(angle) * voltage.direct - sin(angle) * voltage.quadrature;
    real across = 0.5 * ROOT_THREE * (sin(angle) * voltage.direct + cos(angle) * voltage.quadrature);
    real phases[3] = {along, across - 0.5 * along, -across - 0.5 * along};
    real middle = 0.5 * (fmax(along, fmax(phases[1], phases[2])) + fmin(along, fmin(phases[1], phases[2])));
    for (int leg = 0; leg < 3; ++leg) ratios[leg] = between(0.5 + (phases[leg] - middle) / supply, 0.0, 1.0);
}

/* Return the torque of one ampere across the magnet's axis (N m/A). */
static real per_ampere(const controller *self, real direct) {
    return 1.5 * self->pole_pairs * (self->flux - self->saliency * direct);
}

/* Return the direct current with which a torque needs the least current (A). */
static real least_current(const controller *self, real torque) {
    real direct = 0.0;
    for (int round = 0; round < 6; ++round) {
        real quadrature = torque / per_ampere(self, direct), turned = 2.0 * self->saliency * quadrature;
        direct = -turned * quadrature / (self->flux + sqrt(self->flux * self->flux + turned * turned));
    }
    return direct;
}

/* Return the greatest torque at a direct current within both limits (N m), negative if there is none. */
static real possible(const controller *self, real direct, real electrical, real voltage) {
    real headroom = self->limit * self->limit - direct * direct, resistance = self->resistance;
    real reactance = electrical * self->inductance.quadrature;
    real along = electrical * (self->inductance.direct * direct + self->flux);
    /* The voltage is a quadratic in the quadrature current: a q^2 + 2 b q + c = 0 at its limit. */
    real a = reactance * reactance + resistance * resistance, b = resistance * (along - reactance * direct);
    real c = resistance * resistance * direct * direct + along * along - voltage * voltage;
    real inside = b * b - a * c;
    if (inside < 0.0) return inside;
    return per_ampere(self, direct) * fmin(sqrt(headroom), (sqrt(inside) - b) / a);
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
    real error = reference - speed, integral = self->speed_integral + self->speed_step * error;
    real torque = self->regulates_torque ? reference : self->speed_gain * error + integral;
    /* Negative where the torque brakes: the drop of the resistance is then against the back-EMF. */
    real turning = torque < 0.0 ? -electrical : electrical, voltage = VOLTAGE_SHARE * limit;
    if (!self->regulates_torque && turning < 0.0)
        voltage -= BRAKING_SHARE * limit * fmin(fabs(torque) / (0.2 * self->greatest), 1.0);
    real direct = direct_for(self, fmin(fabs(torque), self->greatest), turning, voltage);
    direct = fmax(direct + self->weakening, self->deepest);
    real most = fmax(possible(self, direct, turning, voltage), 0.0);
    /* The integral of the speed waits while the limits allow less than it requests. */
    if (fabs(torque) <= most || torque * error <= 0.0) self->speed_integral = integral;
    return (rotor){direct, between(torque, -most, most) / per_ampere(self, direct)};
}

/* Return the voltage that brings the currents to their references (V), within the limit. */
static rotor regulate(controller *self, rotor error, rotor current, real electrical, real limit) {
    /* The coupling of the axes and the back-EMF are added in advance. */
    real direct = self->gain.direct * error.direct + self->integral.direct
                  - electrical * self->inductance.quadrature * current.quadrature;
    real quadrature = self->gain.quadrature * error.quadrature + self->integral.quadrature
                      + electrical * (self->inductance.direct * current.direct + self->flux);
    /* A voltage beyond the limit is shortened, not turned. What the limit cuts does not enter the integrals. */
    real used = sqrt(direct * direct + quadrature * quadrature), share = limit / fmax(limit, used), cut = share - 1.0;
    self->integral.direct += self->step.direct * (error.direct + cut * direct / self->gain.direct);
    self->integral.quadrature += self->step.quadrature * (error.quadrature + cut * quadrature / self->gain.quadrature);
    /* A machine that differs from the nameplate shows in the voltage that is requested. */
    real weakening = self->weakening + self->weakening_step * (0.5 * (1.0 + VOLTAGE_SHARE) * limit - used);
    self->weakening = between(weakening, -0.3 * self->limit, 0.0);
    return (rotor){share * direct, share * quadrature};
}

int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }

int64_t drivegate_state_size(void) { return sizeof(controller); }

/* Prepare for a run: called before every one, and must forget everything. */
int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *nameplate) {
    real period = nameplate->control_period, bandwidth = CURRENT_SHARE / period, limit = nameplate->current_limit;
    real resistance = nameplate->resistance, flux = nameplate->magnet_flux, pole_pairs = nameplate->pole_pairs;
    rotor inductance = {nameplate->direct_inductance, nameplate->quadrature_inductance};
    rotor gain = {bandwidth * inductance.direct, bandwidth * inductance.quadrature};
    real speed_gain = (real)nameplate->inertia * SPEED_SHARE * bandwidth;
    controller *self = state;
    *self = (controller){
        .regulates_torque = nameplate->reference_kind == DRIVEGATE_TORQUE_REFERENCE,
        .pole_pairs = pole_pairs, .resistance = resistance, .flux = flux, .limit = limit, .gain = gain,
        .inductance = inductance, .saliency = inductance.quadrature - inductance.direct,
        /* Beyond the magnet's whole flux the voltage rises again. The lead is the time to the middle of an answer. */
        .deepest = -fmin(0.999 * limit, flux / inductance.direct), .lead = (nameplate->update_delay + 0.5) * period,
        .step = {CURRENT_SHARE * fmax(resistance, INTEGRAL_SHARE * gain.direct),
                 CURRENT_SHARE * fmax(resistance, INTEGRAL_SHARE * gain.quadrature)},
        .speed_gain = speed_gain, .speed_step = speed_gain * 0.25 * SPEED_SHARE * CURRENT_SHARE,
        .weakening_step = 0.02 * CURRENT_SHARE / (pole_pairs * (real)nameplate->base_speed * inductance.direct),
    };
    /* The torque at the current limit, with the direct current that makes it the greatest. */
    real turned = 2.0 * self->saliency * limit;
    real direct = -turned * limit / (flux + sqrt(flux * flux + 2.0 * turned * turned));
    self->greatest = per_ampere(self, direct) * sqrt(limit * limit - direct * direct);
    return 0;
}

/* Answer for one control period. */
void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    controller *self = state;
    real electrical = self->pole_pairs * (real)sense->speed, angle = self->pole_pairs * (real)sense->angle;
    real supply = fmax((real)sense->supply_voltage, 1e-9), limit = supply / ROOT_THREE;
    if (!sense->enable) {
        /* The integrals begin at the back-EMF beyond the nominal one. Terminals at the rail of a diode do not show it. */
        rotor induced = park(sense->phase_voltages, angle);
        if (fmax(fmax(sense->phase_voltages[0], sense->phase_voltages[1]), sense->phase_voltages[2]) < supply)
            self->integral = (rotor){induced.direct, induced.quadrature - electrical * self->flux};
        command->duty_ratios[0] = command->duty_ratios[1] = command->duty_ratios[2] = 0.5;
        return;
    }
    rotor current = park(sense->phase_currents, angle);
    rotor wanted = references(self, sense->reference, sense->speed, electrical, limit);
    rotor error = {wanted.direct - current.direct, wanted.quadrature - current.quadrature};
    rotor voltage = regulate(self, error, current, electrical, limit);
    modulate(command->duty_ratios, voltage, angle + electrical * self->lead, supply);
    command->torque = per_ampere(self, current.direct) * current.quadrature;
}
