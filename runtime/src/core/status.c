/* Names and texts of the statuses, out of their one list in pk/status.h. */
#include <stdarg.h>
#include <stdio.h>

#include "internal.h"

const char *pk_status_name(enum pk_status status)
{
    switch (status) {
#define PK_STATUS_NAME(name, value, text) \
    case name:                            \
        return #name;
        PK_STATUSES(PK_STATUS_NAME)
    case PK_STATUS_LAST:
        break;
    }
    return "PK_UNKNOWN";
}

const char *pk_status_text(enum pk_status status)
{
    switch (status) {
#define PK_STATUS_TEXT(name, value, text) \
    case name:                            \
        return text;
        PK_STATUSES(PK_STATUS_TEXT)
    case PK_STATUS_LAST:
        break;
    }
    return "unknown status";
}

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
