/* See numbers.h. */
#include "numbers.h"

#include "state.h"

void numbers_list(FILE *file, const char *key, const pk_real *x, size_t count)
{
    fprintf(file, ", \"%s\": [", key);
    for (size_t i = 0; i < count; i++) {
        fputs(i ? ", " : "", file);
        report_real(file, x[i]);
    }
    fputs("]", file);
}

void numbers_pairs(FILE *file, const char *key, const pk_real *x, size_t count)
{
    fprintf(file, ", \"%s\": [", key);
    for (size_t i = 0; i < count; i++) {
        const double high = (double)x[i];
        fputs(i ? ", [" : "[", file);
        report_real(file, x[i]);
        fputs(", ", file);
        report_real(file, x[i] - (pk_real)high);
        fputs("]", file);
    }
    fputs("]", file);
}
