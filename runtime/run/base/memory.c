/* Memory of a run, freed all at once. A failed allocation ends the run: longjmp() returns to
 * memory_try(). Only this file calls longjmp(). */
#define _POSIX_C_SOURCE 200809L

#include "state.h"

#include <stdarg.h>

struct piece {
    struct piece *next, *before;
    max_align_t begin[1];
};

static void link_in(struct memory *m, struct piece *piece)
{
    piece->before = NULL;
    piece->next = m->pieces;
    if (m->pieces)
        m->pieces->before = piece;
    m->pieces = piece;
}

static void unlink_from(struct memory *m, const struct piece *piece)
{
    if (piece->next)
        piece->next->before = piece->before;
    *(piece->before ? &piece->before->next : &m->pieces) = piece->next;
}

static struct piece *piece_of(void *begin)
{
    return (struct piece *)(void *)((char *)begin - offsetof(struct piece, begin));
}

int memory_try(struct memory *m, void (*work)(void *context), void *context)
{
    if (setjmp(m->none))
        return 0;
    work(context);
    return 1;
}

void *memory_ask(struct memory *m, size_t count, size_t size)
{
    const size_t most = SIZE_MAX - sizeof(struct piece);
    struct piece *piece = NULL;
    if (!size || count <= most / size)
        piece = calloc(1, sizeof *piece + count * size);
    if (!piece)
        return NULL;
    link_in(m, piece);
    return piece->begin;
}

void *memory_take(struct memory *m, size_t count, size_t size)
{
    void *begin = memory_ask(m, count, size);
    if (!begin)
        longjmp(m->none, 1);
    return begin;
}

void *memory_grow(struct memory *m, void *old, size_t count, size_t size)
{
    if (!old)
        return memory_take(m, count, size);
    struct piece *was = piece_of(old), *piece = NULL;
    unlink_from(m, was);
    if (count <= (SIZE_MAX - sizeof *was) / size)
        piece = realloc(was, sizeof *was + count * size);
    link_in(m, piece ? piece : was);
    if (!piece)
        longjmp(m->none, 1);
    return piece->begin;
}

void *memory_room(struct memory *m, void *old, size_t count, size_t *room, size_t size)
{
    if (count <= *room)
        return old;
    while (*room < count)
        *room = *room ? 2 * *room : 256;
    return memory_grow(m, old, *room, size);
}

void memory_drop(struct memory *m, void *begin)
{
    if (!begin)
        return;
    unlink_from(m, piece_of(begin));
    free(piece_of(begin));
}

void memory_end(struct memory *m)
{
    /* A longjmp() may have left the text open. fclose() still needs its buffer. */
    if (m->text)
        fclose(m->text);
    m->text = NULL;
    for (struct piece *piece = m->pieces, *next; piece; piece = next) {
        next = piece->next;
        free(piece);
    }
    m->pieces = NULL;
}

void run_say(struct pk_run *run, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    const int length = vsnprintf(NULL, 0, format, list);
    va_end(list);
    if (length < 0)
        return;
    const size_t had = run->said ? strlen(run->said) : 0;
    run->said = memory_grow(&run->memory, run->said, had + (size_t)length + 2, 1);
    va_start(list, format);
    vsnprintf(run->said + had, (size_t)length + 1, format, list);
    va_end(list);
    strcpy(run->said + had + (size_t)length, "\n");
}

FILE *run_text(struct pk_run *run, char **text)
{
    run->memory.text = open_memstream(text, &run->memory.text_size);
    if (!run->memory.text)
        longjmp(run->memory.none, 1);
    return run->memory.text;
}

void run_text_end(struct pk_run *run)
{
    if (run->memory.text)
        fclose(run->memory.text);
    run->memory.text = NULL;
}
