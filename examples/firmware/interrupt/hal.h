/* The part of a vendor's library that the project uses: handles, which point to registers. */
#ifndef HAL_H
#define HAL_H

#include "board.h"

#define ADC_FLAG_JEOC 4U
#define TIM_BDTR_MOE (1U << 15)
#define SPI_FLAG_RXNE 1U

typedef enum { HAL_OK, HAL_ERROR, HAL_BUSY, HAL_TIMEOUT } HAL_StatusTypeDef;

typedef struct {
    volatile uint32_t CR1, SR, DR;
} SPI_TypeDef;

#define SPI1 ((SPI_TypeDef *)0x40013000)

typedef struct {
    ADC_TypeDef *Instance;
    uint32_t State;
} ADC_HandleTypeDef;

typedef struct {
    TIM_TypeDef *Instance;
} TIM_HandleTypeDef;

typedef struct {
    SPI_TypeDef *Instance;
} SPI_HandleTypeDef;

void HAL_IncTick(void);
uint32_t HAL_GetTick(void);
void HAL_Delay(uint32_t Delay);
HAL_StatusTypeDef HAL_SPI_Receive(SPI_HandleTypeDef *hspi, uint8_t *pData, uint16_t Size, uint32_t Timeout);
void HAL_ADC_IRQHandler(ADC_HandleTypeDef *hadc);
void HAL_ADCEx_InjectedConvCpltCallback(ADC_HandleTypeDef *hadc);

#endif
