/* Arrays of numbers as members of a JSON object, after others: `, "key": [...]`. */
#ifndef RUN_NUMBERS_H
#define RUN_NUMBERS_H

#include <stdio.h>

#include <pk/real.h>

enum { NUMBERS_LONGEST = 32 };

/* The fewest digits that read back as x; returns their length. */
size_t numbers_text(char text[NUMBERS_LONGEST], double x);
void numbers_write(FILE *file, double x);
void numbers_list(FILE *file, const char *key, const pk_real *x, size_t count);
/* Each as the sum of two doubles, [high, low], for it may have more digits than one has. */
void numbers_pairs(FILE *file, const char *key, const pk_real *x, size_t count);

#endif
