/* What a program of the tests asks of the machine that it runs on. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

int program(void); /* 0: it went well */
void say(const char *text);
void ticks_begin(void);
uint32_t ticks(void); /* modulo 2^24; 8 are 5 instructions with QEMU's -icount shift=6 */

#endif
