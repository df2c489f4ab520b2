/* Calls a unit of FMI 3 at random, rightly and wrongly, and looks whether each refusal has a
 * message. Arguments: seed, calls, the token. Compiled with the unit's sources and sanitizers, and
 * with the standard's own header. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

enum { MOST = 12, STATES = 4 };
static unsigned long long state;
static unsigned long messages, refusals, silent, done, steps;

static unsigned draw(unsigned below)
{
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return (unsigned)(state >> 33) % below;
}

static double number(void)
{
    static const double some[] = {0,     1,    -1,   0.5,  2,        1e-3,   3.25, -0.0,
                                  1e300, -1e9, 1e-9, 1e-3, INFINITY, -2.125, NAN,  1e-300};
    const double x = some[draw(sizeof some / sizeof *some)];
    return draw(30) ? draw(1000000) / 5e5 : x;
}

static fmi3ValueReference reference(void)
{
    if (draw(20) == 0)
        return state >> 32;
    return (fmi3ValueReference)(draw(11) << 20 | draw(6));
}

static void said(fmi3InstanceEnvironment e, fmi3Status s, fmi3String c, fmi3String m)
{
    (void)e, (void)s, (void)c;
    if (s >= fmi3Discard && m && *m)
        messages++;
}

static fmi3Instance unit;

static void updated(fmi3InstanceEnvironment e, double t, bool set, bool get, bool end, bool may,
                    bool *ask, double *when)
{
    const fmi3ValueReference vr = reference();
    double value = number();
    (void)e, (void)get, (void)end;
    if (draw(2))
        (set ? fmi3SetFloat64(unit, &vr, 1, &value, 1) : fmi3GetFloat64(unit, &vr, 1, &value, 1));
    if (draw(9) == 0)
        fmi3Terminate(unit);
    *ask = may && draw(3) == 0;
    *when = t;
}

static void judged(fmi3Status status, unsigned long before, const char *call)
{
    done += status < fmi3Discard;
    if (status < fmi3Discard)
        return;
    refusals++;
    if (messages == before) {
        silent++;
        printf("no message of status %d: %.60s\n", (int)status, call);
    }
}

#define TRY(call)                              \
    do {                                       \
        const unsigned long before = messages; \
        judged(call, before, #call);           \
    } while (0)

int main(int count, char **words)
{
    (void)count;
    state = strtoull(words[1], NULL, 10);
    const unsigned long calls = strtoul(words[2], NULL, 10);
    fmi3FMUState kept[STATES] = {0};
    double time = 0;
    for (unsigned long k = 0; k < calls; k++) {
        if (!unit) {
            const fmi3ValueReference all[] = {2u << 20};
            unit = draw(2) ? fmi3InstantiateModelExchange("me", words[3], NULL, 0, 1, NULL, said)
                           : fmi3InstantiateCoSimulation("cs", words[3], NULL, 0, draw(2), 0,
                                                         draw(2), all, draw(2), NULL, said,
                                                         draw(2) ? updated : NULL);
            if (!unit)
                return 2;
            time = 0;
        }
        fmi3ValueReference vr[MOST], other[MOST];
        double x[MOST], y[MOST];
        fmi3Int64 whole[MOST];
        const size_t n = draw(MOST), m = draw(7) ? n : draw(MOST);
        for (size_t i = 0; i < MOST; i++) {
            vr[i] = reference();
            other[i] = reference();
            x[i] = y[i] = number();
            whole[i] = (fmi3Int64)draw(60) - 3;
        }
        bool a, b, c, d, e;
        double last = 0;
        size_t size = 0;
        fmi3FMUState *const slot = kept + draw(STATES);
        const fmi3ValueReference now = 0;
        fmi3GetFloat64(unit, &now, 1, &time, 1);
        switch (draw(40)) {
        case 0:
        case 35:
            TRY(fmi3EnterInitializationMode(unit, draw(2), number(), draw(9) ? 0 : number(),
                                            draw(2), 1));
            break;
        case 1:
        case 36:
            TRY(fmi3ExitInitializationMode(unit));
            break;
        case 2:
            if (draw(20) == 0)
                TRY(fmi3Terminate(unit));
            break;
        case 3:
            if (draw(3) == 0)
                TRY(fmi3Reset(unit));
            break;
        case 4:
        case 5:
        case 6:
            TRY(fmi3SetFloat64(unit, draw(30) ? vr : NULL, n, draw(30) ? x : NULL, m));
            break;
        case 7:
        case 8:
            TRY(fmi3GetFloat64(unit, draw(30) ? vr : NULL, n, draw(30) ? x : NULL, m));
            break;
        case 9:
            vr[0] = 10u << 20;
            TRY(fmi3SetInt64(unit, vr, draw(3), whole, draw(3)));
            break;
        case 10:
            vr[0] = 10u << 20;
            TRY(fmi3GetInt64(unit, vr, draw(3), whole, draw(3)));
            break;
        case 11:
            TRY(fmi3GetFMUState(unit, draw(9) ? slot : NULL));
            break;
        case 12:
            TRY(fmi3SetFMUState(unit, *slot));
            break;
        case 13:
            TRY(fmi3FreeFMUState(unit, slot));
            break;
        case 14:
            TRY(fmi3SerializedFMUStateSize(unit, *slot, &size));
            if (size) {
                fmi3Byte *bytes = malloc(size);
                TRY(fmi3SerializeFMUState(unit, *slot, bytes, size - (draw(9) == 0)));
                for (unsigned flips = draw(3); flips; flips--)
                    bytes[draw(4) ? 16 + draw((unsigned)size - 16) : draw((unsigned)size)] ^=
                        (fmi3Byte)draw(256);
                TRY(fmi3DeserializeFMUState(unit, bytes, size - (draw(9) == 0), slot));
                free(bytes);
            }
            break;
        case 15:
            TRY(fmi3GetDirectionalDerivative(unit, vr, n, other, m, x, draw(9) ? m : n, y,
                                             draw(9) ? n : m));
            break;
        case 16:
            TRY(fmi3GetAdjointDerivative(unit, vr, n, other, m, x, n, y, m));
            break;
        case 17:
            TRY(fmi3EnterEventMode(unit));
            break;
        case 18:
        case 19:
            TRY(fmi3UpdateDiscreteStates(unit, &a, &b, &c, &d, &e, draw(9) ? &last : NULL));
            break;
        case 20:
        case 21:
        case 34:
            TRY(fmi3EnterContinuousTimeMode(unit));
            break;
        case 22:
            TRY(fmi3CompletedIntegratorStep(unit, 1, &a, draw(9) ? &b : NULL));
            break;
        case 23:
            TRY(fmi3SetTime(unit, number()));
            break;
        case 24:
            TRY(fmi3SetContinuousStates(unit, draw(9) ? x : NULL, draw(4) ? 2 : n));
            break;
        case 25:
            TRY(fmi3GetContinuousStateDerivatives(unit, draw(9) ? x : NULL, draw(4) ? 2 : n));
            break;
        case 26:
            TRY(fmi3GetEventIndicators(unit, draw(9) ? x : NULL, draw(4) ? 2 : n));
            break;
        case 27:
            TRY(fmi3GetNominalsOfContinuousStates(unit, draw(9) ? x : NULL, draw(4) ? 2 : n));
            break;
        case 28:
            TRY(fmi3GetBoolean(unit, vr, n, NULL, n));
            break;
        case 29:
            if (draw(20) == 0) {
                for (int i = 0; i < STATES; i++)
                    fmi3FreeFMUState(unit, kept + i);
                fmi3FreeInstance(unit);
                unit = NULL;
            }
            break;
        default: {
            const double step = draw(9) ? draw(100) / 1e3 : number(),
                         from = draw(20) ? time : number();
            if (step < 10) {
                const unsigned long before = done;
                TRY(fmi3DoStep(unit, from, step, 1, &a, &b, &c, draw(20) ? &last : NULL));
                steps += done - before;
            }
        }
        }
    }
    for (int i = 0; unit && i < STATES; i++)
        fmi3FreeFMUState(unit, kept + i);
    fmi3FreeInstance(unit);
    printf("%lu steps, %lu done, %lu refusals, %lu messages, %lu silent\n", steps, done, refusals,
           messages, silent);
    return silent != 0;
}
