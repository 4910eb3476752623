/* A project around the control of firmware.c: it runs in the callback of the converter, or in the loop of main. */
#include "main.h"

#include "firmware.h"

ADC_HandleTypeDef hadc1;
TIM_HandleTypeDef htim1;
SPI_HandleTypeDef hspi1;
telegram received;
int16_t measured_speed[2];
static volatile uint32_t sample_is_ready;
__attribute__((section(".ccmram"))) static uint32_t sensor_faults = 1; /* until the first reading */

void MX_TIM1_Init(void) { htim1.Instance = TIM1; }

void MX_ADC1_Init(void) {
    hadc1.Instance = ADC1;
    hadc1.Instance->SR = 0;
}

void MX_SPI1_Init(void) {
    hspi1.Instance = SPI1;
    HAL_Delay(5); /* the sensor's power-on time */
}

static void control(void) {
    uint8_t reading[2];
    if (HAL_SPI_Receive(&hspi1, reading, sizeof reading, 1) == HAL_OK) {
        TIM2->CNT = (uint32_t)reading[0] << 8 | reading[1];
        sensor_faults = 0;
    } else {
        sensor_faults++;
    }
    shaft_speed = measured_speed[0];
    demand = received.demand;
    bridge_is_on = received.bridge_is_on && sensor_faults == 0;
    if (bridge_is_on) htim1.Instance->BDTR |= TIM_BDTR_MOE;
    else htim1.Instance->BDTR &= ~TIM_BDTR_MOE;
    ADC_IRQHandler();
}

void HAL_ADCEx_InjectedConvCpltCallback(ADC_HandleTypeDef *hadc) {
    if (hadc->Instance != hadc1.Instance) return;
#ifdef SUPER_LOOP
    sample_is_ready = 1;
#else
    control();
#endif
}

void ADC1_2_IRQHandler(void) { HAL_ADC_IRQHandler(&hadc1); }

int main(void) {
    MX_TIM1_Init();
    MX_ADC1_Init();
    MX_SPI1_Init();
    demands_torque = received.demands_torque;
    firmware_start();
    for (;;) {
        __asm__ volatile("wfi");
        if (!sample_is_ready) continue;
        sample_is_ready = 0;
        control();
    }
}
