/* Writes JSON; see json.h. */
#include "json.h"

#include "numbers.h"

static void quoted(FILE *file, const char *text)
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

/* Writes the comma before a value, if it needs one, and the key. */
static void begin(struct json *j, const char *key)
{
    if (j->behind)
        fputs(j->depth == 1 ? ",\n  " : ", ", j->file);
    j->behind = 1;
    if (key) {
        quoted(j->file, key);
        fputs(": ", j->file);
    }
}

void json_open(struct json *j, const char *key, char bracket)
{
    begin(j, key);
    fputc(bracket, j->file);
    j->behind = 0;
    j->depth++;
}

void json_close(struct json *j, char bracket)
{
    fputc(bracket, j->file);
    j->behind = 1;
    if (--j->depth == 0)
        fputc('\n', j->file);
}

void json_text(struct json *j, const char *key, const char *text)
{
    if (!text) {
        json_raw(j, key, "null");
        return;
    }
    begin(j, key);
    quoted(j->file, text);
}

void json_raw(struct json *j, const char *key, const char *text)
{
    begin(j, key);
    fputs(text, j->file);
}

void json_real(struct json *j, const char *key, pk_real x)
{
    begin(j, key);
    if (x - x == 0)
        numbers_write(j->file, (double)x);
    else
        fputs("null", j->file);
}

void json_integer(struct json *j, const char *key, size_t x)
{
    begin(j, key);
    fprintf(j->file, "%zu", x);
}

void json_each_real(struct json *j, const struct json_real *each)
{
    for (; each->key; each++)
        json_real(j, each->key, each->x);
}

void json_each_integer(struct json *j, const struct json_integer *each)
{
    for (; each->key; each++)
        json_integer(j, each->key, each->x);
}

void json_each_text(struct json *j, const struct json_text *each)
{
    for (; each->key; each++)
        json_text(j, each->key, each->x);
}

void json_flag(struct json *j, const char *key, int x) { json_raw(j, key, x ? "true" : "false"); }

void json_numbers(struct json *j, const char *key, const pk_real *x, size_t count)
{
    json_open(j, key, '[');
    for (size_t i = 0; x && i < count; i++)
        json_real(j, NULL, x[i]);
    json_close(j, ']');
}
