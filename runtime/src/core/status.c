/* Names and texts of the statuses, out of their one list in pk/status.h. */
#include <pk/status.h>

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
