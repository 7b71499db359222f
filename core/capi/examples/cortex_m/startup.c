/* Reset of a Cortex-M4F: enables the floating point unit, copies data, starts the C library. */
#include <stdint.h>

extern uint32_t data_start[], data_end[], data_load[], __stack[];
extern void _start(void);

#define CPACR (*(volatile uint32_t *)0xE000ED88)
#define AIRCR_EXIT 0x18 /* semihosting: the program ends */
#define STOPPED_BY_ERROR 0x20023

void reset(void)
{
    CPACR |= 0xFu << 20;
    __asm volatile("dsb\n isb");
    for (uint32_t *to = data_start, *from = data_load; to < data_end;)
        *to++ = *from++;
    _start();
}

/* Every fault ends the emulator with an error. */
static void fault(void)
{
    register uint32_t operation __asm("r0") = AIRCR_EXIT;
    register uint32_t reason __asm("r1") = STOPPED_BY_ERROR;
    __asm volatile("bkpt 0xAB" : : "r"(operation), "r"(reason));
    for (;;) {
    }
}

/* Interrupt of the timer in the core. Without a handler in the program, it is a fault. */
void systick(void) __attribute__((weak, alias("fault")));

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    __stack, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
    (void *)fault, [15] = (void *)systick,
};
