/* What the project's files share. */
#ifndef MAIN_H
#define MAIN_H

#include "hal.h"

/* The latest telegram of the fieldbus, as it came, and by its fields. */
typedef struct {
    union {
        uint8_t bytes[12];
        struct {
            float demand;
            int32_t demands_torque, bridge_is_on;
        };
    };
} telegram;

extern telegram received;
extern int16_t measured_speed[]; /* by the sensor's driver, of each axis */

void MX_TIM1_Init(void);
void MX_ADC1_Init(void);
void MX_SPI1_Init(void);
void ADC1_2_IRQHandler(void);

#endif
