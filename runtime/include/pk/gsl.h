/* Steppers of the GNU Scientific Library behind the same pk_method as the core's, for comparison
 * and for problems where they do better. Link libpk_gsl.a before libpk.a, then -lgsl -lgslcblas.
 * double only. GSL allocates: in init, never while stepping; call pk_integrator_free().
 *
 * GSL's error handler is one for the whole process. It is switched off for each call and put back,
 * which two threads would do across one another: a program that steps these methods in several
 * threads calls gsl_set_error_handler_off() itself, once, before it starts them.
 */
#ifndef PK_GSL_H
#define PK_GSL_H

#include <pk/method.h>

#ifdef __cplusplus
extern "C" {
#endif

const struct pk_method *pk_gsl_method_find(const char *name);
const struct pk_method *pk_gsl_method_at(size_t index);

#ifdef __cplusplus
}
#endif

#endif
