/* Pieces of JSON, where a number that is not finite is null: it has no other word. */
#include "json.h"

#include "numbers.h"

void report_text(FILE *file, const char *text)
{
    fputc('"', file);
    for (; *text; text++) {
        const unsigned char c = (unsigned char)*text;
        if (c == '"' || c == '\\')
            fprintf(file, "\\%c", c);
        else if (c < 0x20)
            fprintf(file, "\\u%04x", c);
        else
            fputc(c, file);
    }
    fputc('"', file);
}

void report_real(FILE *file, pk_real x)
{
    if (x - x == PK_C(0.0))
        numbers_write(file, (double)x);
    else
        fputs("null", file);
}

void report_numbers(FILE *file, const char *key, const pk_real *x, size_t count)
{
    fprintf(file, "\"%s\": [", key);
    for (size_t i = 0; x && i < count; i++) {
        fputs(i ? ", " : "", file);
        report_real(file, x[i]);
    }
    fputs("]", file);
}

void numbers_list(FILE *file, const char *key, const pk_real *x, size_t count)
{
    fprintf(file, ", \"%s\": [", key);
    for (size_t i = 0; i < count; i++) {
        fputs(i ? ", " : "", file);
        report_real(file, x[i]);
    }
    fputs("]", file);
}
