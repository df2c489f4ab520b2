/* Clocks, requests to stop a run, and the file descriptor of its rows. */
#define _POSIX_C_SOURCE 200809L

#include "state.h"

#include <time.h>
#include <unistd.h>

#define SELDOM 64u /* if steps are short, the clock is read after so many steps */
/* if SELDOM steps take more seconds than this, the clock is read after each step */
#define SHORT 1e-3
#define BETWEEN 0.1 /* seconds between two calls of `poll` */

static double seconds_of(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double run_now(void) { return seconds_of(CLOCK_MONOTONIC); }
double run_processor(void) { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }

static volatile sig_atomic_t stops; /* whether all runs of the process must end */

void pk_run_stop(int whether) { stops = whether; }

int run_ending(void *context)
{
    (void)context;
    return stops;
}

int run_stopped(struct pk_run *run, double part)
{
    struct control *c = run->settings.control;
    c->stop |= stops;
    if (c->stop || !run->settings.polls)
        return c->stop;
    const struct pk_run_settings *asked = &run->settings.asked;
    if (asked->cap > 0 && run_processor() - c->began > asked->cap)
        return c->slow = c->stop = 1;
    if (!asked->poll && !asked->checkpoint)
        return 0;
    const double t = run_now();
    c->often = t - c->looked < SHORT ? SELDOM : 1;
    c->looked = t;
    if (t - c->last < BETWEEN)
        return 0;
    c->last = t;
    return c->stop = asked->poll && asked->poll(asked->context, part) != 0;
}

int run_open(struct pk_run *run, int fd)
{
    const int own = dup(fd);
    run->out = own < 0 ? NULL : fdopen(own, "w");
    return run->out != NULL;
}
