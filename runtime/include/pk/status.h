/* Statuses of the runtime's calls. Zero is success; positive: the integration stopped as requested;
 * negative: it failed, and the state is the last valid state.
 *
 * The list is one X-macro, which defines name and text of each status. */
#ifndef PK_STATUS_H
#define PK_STATUS_H

#include <pk/begin.h>

PK_BEGIN

#define PK_STATUSES(X)                                                                       \
    X(PK_DONE, 0, "done")                                                                    \
    X(PK_STOPPED_EVENT, 1, "stopped at an event")                                            \
    X(PK_STOPPED_USER, 2, "stopped by the user")                                             \
    X(PK_BAD_ARGUMENT, -1, "bad argument")                                                   \
    X(PK_BLOCK_TOO_SMALL, -2, "memory block too small or misaligned")                        \
    X(PK_REFUSED, -3, "the method does not apply to this system")                            \
    X(PK_OUT_OF_BOUNDS, -4, "a parameter is outside its bounds")                             \
    X(PK_SINGULAR_MASS, -5, "the mass matrix is singular or indefinite")                     \
    X(PK_NO_CONVERGENCE, -6, "the iteration of an implicit step did not converge")           \
    X(PK_STEP_UNDERFLOW, -7, "the step size fell to the round-off of time")                  \
    X(PK_NOT_FINITE, -8, "the motion is no longer finite")                                   \
    X(PK_TOO_MANY_STEPS, -9, "too many steps")                                               \
    X(PK_NO_MEMORY, -10, "a foreign library could not allocate its workspace")               \
    X(PK_SINGULAR_TIME, -11, "the equations of motion as written end here")                  \
    X(PK_SINGULAR_COORDINATES, -12, "the coordinates are singular here")                     \
    X(PK_AMBIGUOUS_STEP, -13, "the equations of an implicit step have several solutions")    \
    X(PK_STEP_TOO_LONG, -14, "a step is too long to be of the motion")                       \
    X(PK_SLIDING, -15, "the motion stays where the equations change")                        \
    X(PK_OFF_CONSTRAINTS, -16, "the start, or an event, breaks a constraint")                \
    X(PK_NO_PROJECTION, -17, "the constraints cannot be fulfilled here")                     \
    X(PK_NO_PROGRESS, -18, "the steps get nowhere")                                          \
    X(PK_NO_IMPULSE, -19, "what the motion does where the equations jump is not determined") \
    X(PK_PENETRATES, -20, "a contact begins violated")                                       \
    X(PK_NO_CONTACT, -21, "no motion satisfies contacts and friction here")

#define PK_STATUS_ENUM(name, value, text) name = value,
/* Extract the names (as for an enum) and the texts from a list of X(NAME, "text"). */
#define PK_EACH_NAME(name, text) name,
#define PK_EACH_TEXT(name, text) text,

enum pk_status {
    PK_STATUSES(PK_STATUS_ENUM) PK_STATUS_LAST = -22 /* a number below all statuses */
};

/* Return the name of a status, such as "PK_NOT_FINITE", and its text. Never NULL. */
const char *pk_status_name(enum pk_status status);
const char *pk_status_text(enum pk_status status);

PK_END

#endif
