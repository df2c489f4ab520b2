/* The states of a run, from which `pkgen run --diagnose modes` computes modes and their energies in
 * Python (analysis/linear/normal.py). */

#include "parts.h"

enum { ROWS = 200 };

void diagnose_modes(struct diagnostics *d)
{
    const size_t rows = d->n_rows < ROWS ? d->n_rows : ROWS;
    diagnose_told(d, PK_DONE, NULL, NULL);
    json_open(&d->json, "states", '[');
    for (size_t k = 0; k < rows; k++)
        json_numbers(&d->json, NULL, diagnose_row(d, k, rows), 1 + 2 * d->run->settings.n);
    json_close(&d->json, ']');
}
