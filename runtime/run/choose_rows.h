/* Rows of a run kept in memory, and how far two runs of the same rows differ. */
#ifndef RUN_CHOOSE_ROWS_H
#define RUN_CHOOSE_ROWS_H

#include "output.h"

struct rows {
    size_t columns, count, room;
    pk_real *t;
    pk_real *x;   /* count * columns */
    double *low;  /* what x lacks of more digits, as read from a file; else NULL */
    int by_number; /* they are at crossings, whose times differ: the third is the third; */
    int without;   /* there were none: the start and the end are in their place */
    size_t stride, seen; /* every so many rows are kept, but the last always is */
};

/* How far rows are from those of an exact run, relative to each column's largest magnitude there. */
struct difference {
    pk_real *columns; /* the largest of each; the caller's */
    pk_real largest;
    pk_real holds; /* the last time up to which none is beyond the accuracy */
    size_t count;  /* rows compared */
};

/* As output_row(), into run->kept: what it shows in a row. `out` has room for what is observed. */
void rows_keep(struct run *run, pk_real t, const pk_real *q, const pk_real *v, const pk_real *z,
               pk_real *out);
/* In place of rows at crossings of which there were none. */
void rows_keep_ends(struct run *run);
size_t rows_columns(const struct settings *s);
void rows_clear(struct rows *rows);
void rows_free(struct rows *rows);
/* Largest magnitude of a column. */
pk_real rows_scale(const struct rows *rows, size_t column);
/* Columns of which `ignored` is set do not count but in `columns`. */
void rows_compare(const struct rows *exact, const struct rows *tried, pk_real accuracy,
                  const unsigned char *ignored, struct difference *found);
/* As doubles, each number two of them; 0, or -1 where the file cannot be written or read. */
int rows_save(const struct rows *rows, const char *path);
int rows_load(struct rows *rows, const char *path, size_t columns);

#endif
