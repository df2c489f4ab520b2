/* fput_system.h
 *
 * The model as pkgen's runtime takes it: fput.h includes this with -DPK_RUNTIME.
 *
 * SPDX-License-Identifier: MIT-0
 */
#ifndef fput_SYSTEM_H
#define fput_SYSTEM_H

#include <pk/system.h>

#ifdef __cplusplus
extern "C" {
#endif

extern const struct pk_system fput_system;

#ifdef __cplusplus
}
#endif

#endif
