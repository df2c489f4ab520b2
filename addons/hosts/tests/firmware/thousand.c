/* A thousand steps of double_pendulum: the least and the most ticks of one, then the bits of q. */
#include "board.h"
#include "double_pendulum_step.h"

static struct double_pendulum_motion m;

static void hex(uint32_t n)
{
    char text[10] = {0};
    for (int k = 0; k < 8; k++)
        text[k] = "0123456789abcdef"[n >> (28 - 4 * k) & 15];
    text[8] = ' ';
    say(text);
}

int program(void)
{
    int status = double_pendulum_begin(&m, PK_C(0.001));
    uint32_t least = 0xffffff, most = 0;

    ticks_begin();
    for (int k = 0; k < 1000 && status == 0; k++) {
        const uint32_t from = ticks();
        uint32_t taken;

        status = double_pendulum_step(&m);
        taken = (ticks() - from) & 0xffffff;
        least = taken < least ? taken : least;
        most = taken > most ? taken : most;
    }
    hex(least);
    hex(most);
    for (int i = 0; i < double_pendulum_N; i++) {
        union {
            pk_real x;
            uint32_t bits[sizeof(pk_real) / 4];
        } both = {m.q[i]};
        for (unsigned k = 0; k < sizeof(pk_real) / 4; k++)
            hex(both.bits[k]);
    }
    say("\n");
    return status;
}
