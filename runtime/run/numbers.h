/* Arrays of numbers as members of a JSON object, after others: `, "key": [...]`. */
#ifndef RUN_NUMBERS_H
#define RUN_NUMBERS_H

#include <stdio.h>

#include <pk/real.h>

void numbers_list(FILE *file, const char *key, const pk_real *x, size_t count);
/* Each as the sum of two doubles, [high, low], for it may have more digits than one has. */
void numbers_pairs(FILE *file, const char *key, const pk_real *x, size_t count);

#endif
