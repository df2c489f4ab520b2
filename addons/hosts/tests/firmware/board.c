/* Cortex-M on QEMU's mps2 boards: vectors, words by semihosting, time by SysTick (25 MHz). */
#include "board.h"

extern uint32_t stack_top, data_begin, data_end, data_from, bss_begin, bss_end;
void reset(void);
static void fault(void);

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    &stack_top,          (const void *)reset, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault, (const void *)fault};

static int semihost(int what, const void *argument)
{
    register int r0 __asm__("r0") = what;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void leave(int bad)
{
    semihost(0x18, (const void *)(bad ? 0x20023 : 0x20026));
    for (;;)
        ;
}

void say(const char *text) { semihost(4, text); }

static void fault(void)
{
    say("fault\n");
    leave(1);
}

#define SYST ((volatile uint32_t *)0xe000e010)
void ticks_begin(void)
{
    SYST[1] = 0xffffff;
    SYST[2] = 0;
    SYST[0] = 5;
}
uint32_t ticks(void) { return 0xffffff - SYST[2]; }

void reset(void)
{
    for (uint32_t *to = &data_begin, *from = &data_from; to < &data_end;)
        *to++ = *from++;
    for (uint32_t *to = &bss_begin; to < &bss_end;)
        *to++ = 0;
#ifdef __ARM_FP
    *(volatile uint32_t *)0xe000ed88 |= 0xfu << 20; /* the unit for floating point, on */
    __asm__ volatile("dsb\nisb");
#endif
    leave(program());
}
