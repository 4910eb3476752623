/* Drivers. Those that wait for a clock or a peripheral never end without it, and are answered by the manifest. */
#include "hal.h"

static volatile uint32_t ticks;

void HAL_IncTick(void) { ticks++; }

__attribute__((noinline)) uint32_t HAL_GetTick(void) { return ticks; }

__attribute__((noinline)) void HAL_Delay(uint32_t Delay) {
    uint32_t begin = HAL_GetTick();
    while (HAL_GetTick() - begin < Delay) {
    }
}

__attribute__((noinline)) HAL_StatusTypeDef HAL_SPI_Receive(SPI_HandleTypeDef *hspi, uint8_t *pData, uint16_t Size,
                                                           uint32_t Timeout) {
    uint32_t begin = HAL_GetTick();
    for (uint16_t place = 0; place < Size; place++) {
        while (!(hspi->Instance->SR & SPI_FLAG_RXNE)) {
            if (HAL_GetTick() - begin > Timeout) return HAL_TIMEOUT;
        }
        pData[place] = (uint8_t)hspi->Instance->DR;
    }
    return HAL_OK;
}

void HAL_ADC_IRQHandler(ADC_HandleTypeDef *hadc) {
    if (!(hadc->Instance->SR & ADC_FLAG_JEOC)) return;
    hadc->Instance->SR = ~ADC_FLAG_JEOC;
    HAL_ADCEx_InjectedConvCpltCallback(hadc);
}
