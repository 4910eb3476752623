/* What the interrupt handler shares with the other files of the firmware. */
#ifndef FIRMWARE_H
#define FIRMWARE_H

#include "board.h"

#define PWM_PERIOD 8400        /* counts of TIM1 */
#define CURRENT_OFFSET 32768   /* counts of ADC1 at 0 A, without the offsets of the amplifiers */

/* The parameter page in flash, in SI units. */
typedef struct {
    int32_t pole_pairs;
    float amperes_per_count, volts_per_count, speed_per_count; /* the last in rad/s of the shaft */
    float resistance, direct_inductance, quadrature_inductance, magnet_flux;
    float current_limit, voltage, inertia, period, delay; /* delay: from sampling to the middle of the pulse, s */
} parameter_page;

extern parameter_page motor;
extern int16_t shaft_speed;   /* by the encoder's driver */
extern float demand;          /* by the fieldbus: rad/s, or N m */
extern int32_t demands_torque;
extern int32_t bridge_is_on;  /* by the gate driver */

void firmware_start(void);
void ADC_IRQHandler(void);

#endif
