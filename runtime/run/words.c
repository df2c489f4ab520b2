/* Words of the settings as numbers; see words.h. */
#include "words.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int words_usage(size_t line, const char *message, const char *word)
{
    fprintf(stderr, "run: settings line %zu: %s%s%s\n", line, message, word ? ": " : "",
            word ? word : "");
    return EXIT_USAGE;
}

int words_real(const char *word, pk_real *x)
{
    char *end = NULL;
    if (!word || !*word)
        return 0;
#ifdef PK_LONG_DOUBLE
    *x = strtold(word, &end);
#else
    *x = (pk_real)strtod(word, &end);
#endif
    return *end == '\0' && *x - *x == PK_C(0.0);
}

int words_index(const char *word, size_t count, size_t *index)
{
    char *end = NULL;
    if (!word || *word < '0' || *word > '9')
        return 0;
    const unsigned long long value = strtoull(word, &end, 10);
    *index = (size_t)value;
    return *end == '\0' && value < count;
}

void *words_allocate(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory) {
        fprintf(stderr, "run: out of memory\n");
        exit(4);
    }
    return memory;
}

void words_keep(char **kept, const char *word)
{
    free(*kept);
    *kept = (char *)words_allocate(strlen(word) + 1, 1);
    strcpy(*kept, word);
}
