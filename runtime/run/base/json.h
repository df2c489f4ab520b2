/* Pieces of JSON. */
#ifndef RUN_JSON_H
#define RUN_JSON_H

#include <stdio.h>

#include <pk/real.h>

void report_text(FILE *file, const char *text);
void report_real(FILE *file, pk_real x);
void report_numbers(FILE *file, const char *key, const pk_real *x, size_t count);
/* After other members: `, "key": [...]`. */
void numbers_list(FILE *file, const char *key, const pk_real *x, size_t count);

#endif
