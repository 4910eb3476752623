/* Field-oriented control in the interrupt of the converter. */
#include "firmware.h"

#include <math.h>

#define ROOT_THREE 1.73205081F
#define BANDWIDTH 0.2F        /* of the current regulators, times the control period */
#define VOLTAGE_SHARE 0.985F  /* of the linear range; the current regulators need the rest */
#define BRAKING_SHARE 0.185F  /* of it for regulation while the speed regulator brakes */
#define DECAY 32              /* samples that follow a reset, in which currents decay through the diodes */
#define CALIBRATION 256       /* samples of each offset */

parameter_page motor;
int16_t shaft_speed;
float demand;
int32_t demands_torque, bridge_is_on;

static struct { float speed, speed_step, direct, quadrature, direct_step, quadrature_step, weakening_step; } gain;
static struct { float speed, direct, quadrature, weakening; } integral;
static float deepest, most_torque, offsets[3];
static int32_t samples; /* that offsets are means of */

static float clamp(float value, float lowest, float highest) { return fminf(fmaxf(value, lowest), highest); }

/* Sine of an angle with 65536 counts per turn. */
static float sine(uint16_t angle) {
    int32_t folded = (int16_t)angle;
    if (folded > 16384) folded = 32768 - folded;
    if (folded < -16384) folded = -32768 - folded;
    float x = (float)folded / 16384.0F, square = x * x;
    return x * (1.57079633F + square * (-0.64596410F + square * (0.07969263F + square * (-0.00468175F + square * 0.00016044F))));
}

static float torque_per_ampere(float direct) {
    float saliency = motor.quadrature_inductance - motor.direct_inductance;
    return 1.5F * (float)motor.pole_pairs * (motor.magnet_flux - saliency * direct);
}

/* Direct current of least magnitude for a torque. */
static float least_current(float torque) {
    float saliency = motor.quadrature_inductance - motor.direct_inductance, direct = 0.0F;
    if (saliency < 1e-3F * motor.direct_inductance) return 0.0F;
    for (int round = 0; round < 6; round++) {
        float reluctance = 2.0F * saliency * torque / torque_per_ampere(direct);
        direct = (motor.magnet_flux - sqrtf(motor.magnet_flux * motor.magnet_flux + reluctance * reluctance)) / (2.0F * saliency);
    }
    return direct;
}

/* Greatest torque at a direct current within the limits of current and voltage; negative for none. */
static float greatest_torque(float direct, float electrical, float voltage) {
    float headroom = motor.current_limit * motor.current_limit - direct * direct, resistance = motor.resistance;
    float emf = electrical * (motor.direct_inductance * direct + motor.magnet_flux);
    float reactance = electrical * motor.quadrature_inductance;
    /* a q^2 + 2 b q + c = 0 at the limit of the voltage. */
    float a = reactance * reactance + resistance * resistance, b = resistance * (emf - reactance * direct);
    float c = resistance * resistance * direct * direct + emf * emf - voltage * voltage, inside = b * b - a * c;
    if (headroom < 0.0F || inside < 0.0F) return -1.0F;
    return torque_per_ampere(direct) * fminf(sqrtf(headroom), (sqrtf(inside) - b) / a);
}

/* Direct current between two that allows a torque, of which the first allows less and the second more. */
static float crossing(float less, float below, float more, float above, float torque, float electrical, float voltage) {
    float direct = more;
    for (int round = 0; round < 3; round++) {
        direct = less + (more - less) * (torque - below) / (above - below);
        float possible = greatest_torque(direct, electrical, voltage);
        if (possible >= torque) more = direct, above = possible;
        else less = direct, below = possible;
    }
    return direct;
}

/* First direct current from a given one on that allows a torque, else the one that allows most. */
static float weakened(float start, float torque, float electrical, float voltage) {
    float best = start, last = start, before = greatest_torque(start, electrical, voltage), most = before;
    for (int step = 1; step <= 64 && most < torque; step++) {
        float direct = start + (deepest - start) * (float)step / 64.0F;
        float possible = greatest_torque(direct, electrical, voltage);
        if (possible >= torque) return crossing(last, before, direct, possible, torque, electrical, voltage);
        if (possible > most) most = possible, best = direct;
        last = direct, before = possible;
    }
    return best;
}

void firmware_start(void) {
    float bandwidth = BANDWIDTH / motor.period, speed_bandwidth = 0.02F * bandwidth;
    gain.direct = bandwidth * motor.direct_inductance;
    gain.quadrature = bandwidth * motor.quadrature_inductance;
    gain.direct_step = BANDWIDTH * fmaxf(motor.resistance, 0.1F * gain.direct);
    gain.quadrature_step = BANDWIDTH * fmaxf(motor.resistance, 0.1F * gain.quadrature);
    gain.speed = motor.inertia * speed_bandwidth;
    gain.speed_step = gain.speed * 0.25F * speed_bandwidth * motor.period;
    gain.weakening_step = 0.1F * BANDWIDTH * motor.current_limit / motor.voltage;
    deepest = -fminf(0.999F * motor.current_limit, motor.magnet_flux / motor.direct_inductance);
    most_torque = greatest_torque(weakened(0.0F, INFINITY, 0.0F, motor.voltage), 0.0F, motor.voltage);
    TIM1->ARR = PWM_PERIOD;
    samples = 0;
    for (int phase = 0; phase < 3; phase++) offsets[phase] = CURRENT_OFFSET;
}

/* Measure the offsets of the amplifiers after a reset, with the bridge off and without currents. */
static void calibrate(const float *counts, float link) {
    float electrical = (float)motor.pole_pairs * motor.speed_per_count * fabsf((float)shaft_speed);
    if (samples == DECAY + CALIBRATION) return;
    /* At this speed the magnets drive a current through the diodes. */
    if (ROOT_THREE * electrical * motor.magnet_flux > 0.9F * link) return;
    samples++;
    if (samples <= DECAY) return;
    for (int phase = 0; phase < 3; phase++) offsets[phase] += (counts[phase] - offsets[phase]) / (float)(samples - DECAY);
}

/* Write the compare registers of a voltage in the frame that stands still. */
static void modulate(float alpha, float beta, float link) {
    float a = alpha, b = 0.5F * (ROOT_THREE * beta - alpha), c = -0.5F * (ROOT_THREE * beta + alpha);
    float middle = 0.5F * (fmaxf(a, fmaxf(b, c)) + fminf(a, fminf(b, c)));
    TIM1->CCR1 = (uint32_t)(clamp(0.5F + (a - middle) / link, 0.0F, 1.0F) * PWM_PERIOD + 0.5F);
    TIM1->CCR2 = (uint32_t)(clamp(0.5F + (b - middle) / link, 0.0F, 1.0F) * PWM_PERIOD + 0.5F);
    TIM1->CCR3 = (uint32_t)(clamp(0.5F + (c - middle) / link, 0.0F, 1.0F) * PWM_PERIOD + 0.5F);
}

void ADC_IRQHandler(void) {
    float counts[] = {(float)ADC1->JDR1, (float)ADC1->JDR2, (float)ADC1->JDR3};
    float link = fmaxf((float)ADC1->JDR4 * motor.volts_per_count, 1.0F), limit = link / ROOT_THREE;
    if (!bridge_is_on) {
        calibrate(counts, link);
        return;
    }
    float a = (counts[0] - offsets[0]) * motor.amperes_per_count;
    float b = (counts[1] - offsets[1]) * motor.amperes_per_count;
    float c = (counts[2] - offsets[2]) * motor.amperes_per_count;
    float speed = (float)shaft_speed * motor.speed_per_count, electrical = (float)motor.pole_pairs * speed;
    uint16_t angle = (uint16_t)((uint32_t)motor.pole_pairs * TIM2->CNT);

    float alpha = (2.0F * a - b - c) / 3.0F, beta = (b - c) / ROOT_THREE;
    float sin = sine(angle), cos = sine((uint16_t)(angle + 16384));
    float direct = cos * alpha + sin * beta, quadrature = cos * beta - sin * alpha;

    float torque = demand, error = demand - speed, allowed = VOLTAGE_SHARE * limit;
    if (!demands_torque) {
        integral.speed += gain.speed_step * error;
        torque = gain.speed * error + integral.speed;
        if (torque * speed < 0.0F) allowed -= BRAKING_SHARE * limit * fminf(1.0F, fabsf(torque) / (0.2F * most_torque));
    }
    float wanted = fminf(fabsf(torque), most_torque);
    float target = weakened(least_current(wanted), wanted, fabsf(electrical), allowed) + integral.weakening;
    target = fmaxf(target, deepest);
    float possible = fmaxf(greatest_torque(target, fabsf(electrical), allowed), 0.0F);
    /* The speed integral waits while the limits leave less than it demands: less by more than target is exact to. */
    if (!demands_torque && fabsf(torque) > possible + 0.002F * most_torque && torque * error > 0.0F) integral.speed -= gain.speed_step * error;
    float direct_error = target - direct;
    float quadrature_error = clamp(torque, -possible, possible) / torque_per_ampere(target) - quadrature;

    float direct_voltage = gain.direct * direct_error + integral.direct - electrical * motor.quadrature_inductance * quadrature;
    float quadrature_voltage = gain.quadrature * quadrature_error + integral.quadrature
                               + electrical * (motor.direct_inductance * direct + motor.magnet_flux);
    float length = sqrtf(direct_voltage * direct_voltage + quadrature_voltage * quadrature_voltage);
    float excess = 1.0F - fminf(1.0F, limit / fmaxf(length, 1e-6F));
    integral.direct += gain.direct_step * (direct_error - excess * direct_voltage / gain.direct);
    integral.quadrature += gain.quadrature_step * (quadrature_error - excess * quadrature_voltage / gain.quadrature);
    integral.weakening += gain.weakening_step * (0.5F * (1.0F + VOLTAGE_SHARE) * limit - length);
    integral.weakening = clamp(integral.weakening, -0.3F * motor.current_limit, 0.0F);
    direct_voltage -= excess * direct_voltage;
    quadrature_voltage -= excess * quadrature_voltage;

    /* The voltage acts later; the rotor turns on meanwhile. */
    angle = (uint16_t)(angle + (int32_t)(electrical * motor.delay * 10430.378F));
    sin = sine(angle), cos = sine((uint16_t)(angle + 16384));
    modulate(cos * direct_voltage - sin * quadrature_voltage, sin * direct_voltage + cos * quadrature_voltage, link);
}
