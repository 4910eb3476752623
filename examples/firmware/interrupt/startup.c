/* From reset to main: the vector table, and what has to be in memory before C runs. */
#include <stdint.h>
#include <string.h>

extern uint32_t _estack[], _sidata[], _sdata[], _edata[], _siccmram[], _sccmram[], _eccmram[], _sbss[], _ebss[];
int main(void);
void ADC1_2_IRQHandler(void);
void Reset_Handler(void);
void copy_initial_values(void);

/* Full access to the floating-point unit. */
void SystemInit(void) { *(volatile uint32_t *)0xE000ED88 |= 0xFU << 20; }

void copy_initial_values(void) {
    memcpy(_sdata, _sidata, (size_t)((char *)_edata - (char *)_sdata));
    memcpy(_sccmram, _siccmram, (size_t)((char *)_eccmram - (char *)_sccmram));
    memset(_sbss, 0, (size_t)((char *)_ebss - (char *)_sbss));
}

void Reset_Handler(void) {
    copy_initial_values();
    SystemInit();
    main();
}

static void Default_Handler(void) {
    for (;;) {
    }
}

__attribute__((section(".isr_vector"), used)) static void *const vectors[] = {
    _estack, (void *)Reset_Handler, (void *)Default_Handler, (void *)ADC1_2_IRQHandler};
