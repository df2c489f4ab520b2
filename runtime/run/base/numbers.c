/* Writes the fewest digits that read back as the same number; see numbers.h. */
#include "numbers.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

enum { DIGITS = 17 };

/* Returns whether the decimal number d[0].d[1]...d[n-1] times 10^e, also given as `text`, reads
 * back as x. It is computed as a long double, whose error is at most two units in the last place.
 * If both ends of this error interval round to the same double, strtod() would return this double,
 * too. Otherwise strtod() decides. */
static int is_same(const char *text, const char *d, int n, int e, double x)
{
    static const long double power[] = {1e0L,  1e1L,  1e2L,  1e3L,  1e4L,  1e5L,  1e6L,  1e7L,
                                        1e8L,  1e9L,  1e10L, 1e11L, 1e12L, 1e13L, 1e14L, 1e15L,
                                        1e16L, 1e17L, 1e18L, 1e19L, 1e20L, 1e21L, 1e22L};
    const int k = e - (n - 1);
    long long m = 0;
    for (int i = 0; i < n; i++)
        m = 10 * m + (d[i] - '0');
    if (k <= 22 && k >= -22) {
        const long double whole = (long double)m;
        const long double y = k < 0 ? whole / power[-k] : whole * power[k];
        const double least = (double)(y - 2 * LDBL_EPSILON * y);
        if (least >= (double)(y + 2 * LDBL_EPSILON * y))
            return least == (x < 0 ? -x : x);
    }
    return strtod(text, NULL) == x;
}

/* Rounds `exact`, a number of 17 digits in the form d.ddde+XX, to n digits and writes it in the
 * form of %g. Returns the length of the text; 0 if it does not read back as x. */
static size_t rounded(char text[], const char *exact, int n, double x)
{
    char d[DIGITS + 1], *p = text;
    const int sign = exact[0] == '-';
    int first = 1, e = atoi(exact + sign + DIGITS + 2);
    const int asked = n;
    d[0] = '0'; /* rounding up digits 9 may carry into this digit */
    d[1] = exact[sign];
    memcpy(d + 2, exact + sign + 2, DIGITS - 1);
    if (n < DIGITS && d[n + 1] >= '5') {
        int i = n;
        while (d[i] == '9')
            d[i--] = '0';
        d[i]++;
        if (i == 0)
            first = 0, e++;
    }
    const char *digit = d + first;
    while (n > 1 && digit[n - 1] == '0')
        n--;
    if (sign)
        *p++ = '-';
    if (e < -4 || e >= DIGITS) {
        p += sprintf(p, n > 1 ? "%c.%.*se%+03d" : "%c%.*se%+03d", digit[0], n - 1, digit + 1, e);
    } else if (e < 0) {
        memcpy(p, "0.000", (size_t)(1 - e));
        memcpy(p + 1 - e, digit, (size_t)n);
        p += 1 - e + n;
        *p = '\0';
    } else {
        for (int i = 0; i < n || i <= e; i++) {
            if (i == e + 1)
                *p++ = '.';
            *p++ = i < n ? digit[i] : '0';
        }
        *p = '\0';
    }
    return asked == DIGITS || is_same(text, digit, n, e, x) ? (size_t)(p - text) : 0;
}

size_t numbers_text(char text[NUMBERS_LONGEST], double x)
{
    char exact[NUMBERS_LONGEST], shorter[NUMBERS_LONGEST];
    if (!(x - x == 0) || x == 0)
        return (size_t)sprintf(text, "%.17g", x);
    sprintf(exact, "%.16e", x);
    char *const last = exact + (x < 0) + DIGITS;
    size_t length;
    /* A last digit 5 is itself rounded, so printf() rounds x, not this digit, to 16 digits. */
    if (*last == '5') {
        sprintf(shorter, "%.15e", x);
        memmove(shorter + (last - exact) + 1, shorter + (last - exact), strlen(last));
        shorter[last - exact] = '0';
        length = rounded(text, shorter, DIGITS - 1, x);
    } else {
        length = rounded(text, exact, DIGITS - 1, x);
    }
    if (!length)
        return rounded(text, exact, DIGITS, x);
    const size_t less = rounded(shorter, exact, DIGITS - 2, x);
    if (!less)
        return length;
    memcpy(text, shorter, less + 1);
    return less;
}

void numbers_write(FILE *file, double x)
{
    char text[NUMBERS_LONGEST];
    if (x > 0 || x <= 0)
        fwrite(text, 1, numbers_text(text, x), file);
    else
        fputs("nan", file); /* never "-nan": C libraries differ in the sign that they print */
}
