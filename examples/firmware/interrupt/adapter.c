/* What drivegate calls: it writes the registers that the handler reads, and reads those that it writes. */
#include "drivegate_duty.h"
#include "firmware.h"

#include <math.h>

#ifndef __arm__
TIM_TypeDef tim1, tim2;
ADC_TypeDef adc1;
#endif

static double counts(double value, double lowest, double highest) { return fmin(fmax(floor(value + 0.5), lowest), highest); }

int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }
int64_t drivegate_state_size(void) { return 0; } /* the state is in globals */

int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *plate) {
    (void)state;
    motor = (parameter_page){
        (int32_t)plate->pole_pairs, (float)(plate->current_limit / 16384.0), (float)(plate->supply_voltage / 32768.0),
        (float)(plate->highest_speed / 24576.0), (float)plate->resistance, (float)plate->direct_inductance,
        (float)plate->quadrature_inductance, (float)plate->magnet_flux, (float)plate->current_limit,
        (float)plate->supply_voltage, (float)plate->inertia, (float)plate->control_period,
        (float)(((double)plate->update_delay + 0.5) * plate->control_period)};
    demands_torque = plate->reference_kind == DRIVEGATE_TORQUE_REFERENCE;
    firmware_start();
    return 0;
}

void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    (void)state;
    ADC1->JDR1 = (uint32_t)counts(CURRENT_OFFSET + sense->phase_currents[0] / motor.amperes_per_count, 0.0, 65535.0);
    ADC1->JDR2 = (uint32_t)counts(CURRENT_OFFSET + sense->phase_currents[1] / motor.amperes_per_count, 0.0, 65535.0);
    ADC1->JDR3 = (uint32_t)counts(CURRENT_OFFSET + sense->phase_currents[2] / motor.amperes_per_count, 0.0, 65535.0);
    ADC1->JDR4 = (uint32_t)counts(sense->supply_voltage / motor.volts_per_count, 0.0, 65535.0);
    TIM2->CNT = (uint32_t)counts(sense->angle * 10430.378350470453, 0.0, 65535.0);
    shaft_speed = (int16_t)counts(sense->speed / motor.speed_per_count, -32768.0, 32767.0);
    demand = (float)sense->reference;
    bridge_is_on = (int32_t)sense->enable;
    ADC_IRQHandler();
    command->duty_ratios[0] = (double)TIM1->CCR1 / TIM1->ARR;
    command->duty_ratios[1] = (double)TIM1->CCR2 / TIM1->ARR;
    command->duty_ratios[2] = (double)TIM1->CCR3 / TIM1->ARR;
}
