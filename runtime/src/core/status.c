/* Names and texts of the statuses, from the list in pk/status.h. */
#include <stdarg.h>
#include <stdio.h>

#include "internal.h"

#define WORDS(name, value, text) {name, #name, text},
static const struct words {
    enum pk_status status;
    const char *name, *text;
} statuses[] = {PK_STATUSES(WORDS){PK_STATUS_LAST, "PK_UNKNOWN", "unknown status"}};

static const struct words *words(enum pk_status status)
{
    const struct words *x = statuses;
    while (x->status != status && x->status != PK_STATUS_LAST)
        x++;
    return x;
}

const char *pk_status_name(enum pk_status status) { return words(status)->name; }
const char *pk_status_text(enum pk_status status) { return words(status)->text; }

int pk_say(const struct pk_integrator *it, char *text, size_t size, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int used = vsnprintf(text, size, format, arguments);
    va_end(arguments);
    const size_t at = used > 0 && (size_t)used < size ? (size_t)used : size;
    return used + snprintf(at < size ? text + at : NULL, size - at, "; last valid time %.17g",
                           (double)it->t);
}
