/* A JSON writer. It writes the commas, and writes null for a number that is not finite, which JSON
 * cannot express. Keys are NULL in arrays. Each member of the outermost object has a line. */
#ifndef RUN_JSON_H
#define RUN_JSON_H

#include <stdio.h>

#include <pk/real.h>

struct json {
    FILE *file;
    /* `depth`: number of open brackets; `behind`: whether the next value needs a comma */
    int depth, behind;
};

struct json_real {
    const char *key;
    pk_real x;
};

struct json_integer {
    const char *key;
    size_t x;
};

struct json_text {
    const char *key, *x;
};

void json_open(struct json *j, const char *key, char bracket);
void json_close(struct json *j, char bracket);
void json_text(struct json *j, const char *key, const char *text); /* NULL is written as null */
/* `text` is a value in JSON, which is written unchanged */
void json_raw(struct json *j, const char *key, const char *text);
void json_real(struct json *j, const char *key, pk_real x);
void json_integer(struct json *j, const char *key, size_t x);
/* Writes several members in order: json_reals(j, {"t", t}, {"energy", energy}). */
#define json_reals(j, ...) json_each_real(j, (const struct json_real[]){__VA_ARGS__, {NULL, 0}})
#define json_counts(j, ...) \
    json_each_integer(j, (const struct json_integer[]){__VA_ARGS__, {NULL, 0}})
/* Writes an object of such members. */
#define json_object(j, key, ...) \
    (json_open(j, key, '{'), json_reals(j, __VA_ARGS__), json_close(j, '}'))
#define json_texts(j, ...) json_each_text(j, (const struct json_text[]){__VA_ARGS__, {NULL, 0}})
void json_each_real(struct json *j, const struct json_real *each);
void json_each_integer(struct json *j, const struct json_integer *each);
void json_each_text(struct json *j, const struct json_text *each);
void json_flag(struct json *j, const char *key, int x);
void json_numbers(struct json *j, const char *key, const pk_real *x, size_t count);

#endif
