/* Numbers as text. */
#ifndef RUN_NUMBERS_H
#define RUN_NUMBERS_H

#include <stdio.h>

enum { NUMBERS_LONGEST = 32 };

/* Writes the fewest digits that read back as x; returns their length. */
size_t numbers_text(char text[NUMBERS_LONGEST], double x);
void numbers_write(FILE *file, double x);

#endif
