/* Terms with sines and cosines.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_ANGLES_H
#define PK_MEMBERS_ANGLES_H

#include <pk/members.h>

/* A term with angles is computed with a fast sine, and again with care if an angle is too large. */
#define PK_TERM_PASS(name)                                                                         \
    PK_INLINE static pk_bits name##_pass(enum pk_pass pass, PK_PERHAPS const struct pk_members *x, \
                                         PK_PERHAPS ptrdiff_t row, PK_PERHAPS ptrdiff_t from,      \
                                         ptrdiff_t n, pk_real *const *o)
#define PK_TERM_OF_PASSES(name)                                  \
    PK_TERM(name)                                                \
    {                                                            \
        if (name##_pass(PK_IN_LANE, x, row, from, n, o))         \
            (void)name##_pass(PK_CAREFULLY, x, row, from, n, o); \
    }

#endif
