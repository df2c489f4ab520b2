/* Words of the settings as numbers, and what is said of those that are wrong. */
#ifndef RUN_WORDS_H
#define RUN_WORDS_H

#include <stddef.h>

#include <pk/real.h>

enum { EXIT_USAGE = 2 };

/* Says what is wrong in a line; EXIT_USAGE. */
int words_usage(size_t line, const char *message, const char *word);
/* 1 if the word is a finite number, or an index below count. */
int words_real(const char *word, pk_real *x);
int words_index(const char *word, size_t count, size_t *index);
/* Zeroed memory; ends the process where there is none. */
void *words_allocate(size_t count, size_t size);
/* A copy of a word in place of the one that is kept. */
void words_keep(char **kept, const char *word);

#endif
