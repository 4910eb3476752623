/* The registers of the board that the firmware uses, at the addresses of the target or as variables elsewhere. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

typedef struct {
    volatile uint32_t JDR1, JDR2, JDR3, JDR4; /* three phase currents and the link, each the sum of 16 conversions */
    volatile uint32_t SR;
} ADC_TypeDef;

typedef struct {
    volatile uint32_t CNT, ARR, CCR1, CCR2, CCR3, BDTR;
} TIM_TypeDef;

#ifdef __arm__
#define TIM1 ((TIM_TypeDef *)0x40010000)
#define TIM2 ((TIM_TypeDef *)0x40010400)
#define ADC1 ((ADC_TypeDef *)0x40012000)
#else
extern TIM_TypeDef tim1, tim2;
extern ADC_TypeDef adc1;
#define TIM1 (&tim1)
#define TIM2 (&tim2)
#define ADC1 (&adc1)
#endif

#endif
